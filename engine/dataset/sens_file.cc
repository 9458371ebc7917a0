// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/sens_file.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <zlib.h>

#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/sensor/image_decoding.h"

namespace plumbline {
namespace {

constexpr std::uint32_t kSensVersion = 4;
constexpr std::uint64_t kSensFrameHead = 64 + 4 * 8;
enum SensColor : std::int32_t { kSensPng = 1, kSensJpeg = 2 };
enum SensDepth : std::int32_t { kSensRawDepth = 0, kSensZlibDepth = 1 };

template <typename Number>
Number SensNumber(const std::string& bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

/// 16 numbers of four bytes, row by row.
Eigen::Matrix4d SensMatrix(const std::string& bytes, std::size_t at) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i)
    matrix(i / 4, i % 4) = SensNumber<float>(bytes, at + 4 * static_cast<std::size_t>(i));
  return matrix;
}

PinholeCamera SensCamera(const Eigen::Matrix4d& k, std::uint32_t width, std::uint32_t height) {
  return {static_cast<int>(std::min(width, 65536u)),
          static_cast<int>(std::min(height, 65536u)),
          k(0, 0),
          k(1, 1),
          k(0, 2),
          k(1, 2)};
}

}  // namespace

Status SensFile::ReadHeads() {
  const Result<std::string> start = file_.Read(0, 12);
  if (!start.ok()) return start.error();
  if (const auto version = SensNumber<std::uint32_t>(*start, 0); version != kSensVersion) {
    return Error{ErrorCode::kUnsupported, "'" + file_.path().string() + "' is of version " +
                                              std::to_string(version) +
                                              " of the .sens format; this version reads 4"};
  }
  const auto name_size = SensNumber<std::uint64_t>(*start, 4);
  if (name_size > 4096)
    return file_.Damage("a sensor's name of " + std::to_string(name_size) + " bytes");
  constexpr std::size_t kMatrices = 4 * 64, kRest = 4 * 7 + 8;
  const Result<std::string> head = file_.Read(12 + name_size, kMatrices + kRest);
  if (!head.ok()) return head.error();
  const auto color = SensNumber<std::int32_t>(*head, kMatrices);
  depth_compression_ = SensNumber<std::int32_t>(*head, kMatrices + 4);
  if ((color != kSensPng && color != kSensJpeg) ||
      (depth_compression_ != kSensRawDepth && depth_compression_ != kSensZlibDepth)) {
    return Error{ErrorCode::kUnsupported,
                 "'" + file_.path().string() + "' has images compressed in the ways " +
                     std::to_string(color) + " (colour) and " + std::to_string(depth_compression_) +
                     " (depth); this version reads colour as PNG (1) or JPEG (2), depth plain (0) "
                     "or by zlib (1)"};
  }
  color_camera_ = SensCamera(SensMatrix(*head, 0), SensNumber<std::uint32_t>(*head, kMatrices + 8),
                             SensNumber<std::uint32_t>(*head, kMatrices + 12));
  depth_camera_ =
      SensCamera(SensMatrix(*head, 128), SensNumber<std::uint32_t>(*head, kMatrices + 16),
                 SensNumber<std::uint32_t>(*head, kMatrices + 20));
  same_place_ = (SensMatrix(*head, 64) - SensMatrix(*head, 192)).cwiseAbs().maxCoeff() < 1e-4;
  depth_units_per_metre_ = SensNumber<float>(*head, kMatrices + 24);
  if (!(depth_units_per_metre_ > 0.1 && depth_units_per_metre_ < 1e6))
    return file_.Damage("a depth unit that is none");
  const auto count = SensNumber<std::uint64_t>(*head, kMatrices + 28);
  std::uint64_t at = 12 + name_size + kMatrices + kRest;
  if (count > file_.size() / kSensFrameHead)
    return file_.Damage("more frames than it has room for");
  for (std::uint64_t i = 0; i < count; ++i) {
    const Result<std::string> bytes = file_.Read(at, kSensFrameHead);
    if (!bytes.ok()) return bytes.error();
    Frame frame;
    frame.world_from_cam = RigidFromMatrix(SensMatrix(*bytes, 0));
    frame.color_stamp_us = SensNumber<std::uint64_t>(*bytes, 64);
    frame.color_size = SensNumber<std::uint64_t>(*bytes, 80);
    frame.depth_size = SensNumber<std::uint64_t>(*bytes, 88);
    if (frame.color_size > file_.size() || frame.depth_size > file_.size())
      return file_.Damage("it ends before what it says to hold");
    frame.color_begin = at + kSensFrameHead;
    frame.depth_begin = frame.color_begin + frame.color_size;
    at = frame.depth_begin + frame.depth_size;
    if (at > file_.size()) return file_.Damage("it ends within frame " + std::to_string(i));
    frames_.push_back(frame);
  }
  return {};
}

Result<std::shared_ptr<const SensFile>> SensFile::Open(const std::filesystem::path& file) {
  Result<RandomAccessFile> opened = RandomAccessFile::Open(file);
  if (!opened.ok()) return opened.error();
  std::shared_ptr<SensFile> sens(new SensFile(std::move(opened).value()));
  if (Status read = sens->ReadHeads(); !read.ok()) return read.error();
  return std::shared_ptr<const SensFile>(std::move(sens));
}

Result<cv::Mat> SensFile::ReadColor(std::size_t frame) const {
  const Result<std::string> bytes =
      file_.Read(frames_[frame].color_begin, frames_[frame].color_size);
  if (!bytes.ok()) return bytes.error();
  return DecodeImage(*bytes, ImageKind::kColor, cv::Size(color_camera_.width, color_camera_.height),
                     file_.path().string() + " frame " + std::to_string(frame));
}

Result<std::optional<cv::Mat>> SensFile::ReadDepth(std::size_t frame) const {
  if (frames_[frame].depth_size == 0) return std::optional<cv::Mat>();
  Result<std::string> packed = file_.Read(frames_[frame].depth_begin, frames_[frame].depth_size);
  if (!packed.ok()) return packed.error();
  const std::size_t size = 2ull * static_cast<std::size_t>(depth_camera_.width) *
                           static_cast<std::size_t>(depth_camera_.height);
  if (depth_compression_ == kSensZlibDepth) {
    // zlib makes at most some thousand bytes of one.
    if (size / 2000 > packed->size()) return file_.Damage("depth that cannot be unpacked");
    std::string unpacked(size, '\0');
    uLongf length = size;
    if (uncompress(reinterpret_cast<Bytef*>(unpacked.data()), &length,
                   reinterpret_cast<const Bytef*>(packed->data()),
                   static_cast<uLong>(packed->size())) != Z_OK)
      return file_.Damage("depth that cannot be unpacked");
    unpacked.resize(length);
    *packed = std::move(unpacked);
  }
  if (packed->size() != size) return file_.Damage("depth of another size than its camera's");
  const cv::Mat raw(depth_camera_.height, depth_camera_.width, CV_16UC1, packed->data());
  return std::optional(InMillimetres(raw, depth_units_per_metre_));
}

}  // namespace plumbline
