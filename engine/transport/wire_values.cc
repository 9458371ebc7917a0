// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/wire_values.h"

#include <cmath>
#include <cstring>

#include <opencv2/imgcodecs.hpp>

namespace plumbline {
namespace {

constexpr int kMostSide = 1 << 15;
constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;

Error BadMessage(const std::string& what) {
  return {ErrorCode::kCorrupt, "a node sent " + what + "; it may be damaged or another program's"};
}

void SetCovariance(const PoseCovariance& covariance, google::protobuf::RepeatedField<double>& out) {
  if (covariance.isZero(0)) return;
  for (int i = 0; i < 36; ++i) out.Add(covariance(i / 6, i % 6));
}

void SetVector(const Eigen::Vector3d& vector, wire::Vector3& out) {
  out.set_x(vector.x());
  out.set_y(vector.y());
  out.set_z(vector.z());
}

/// The size that a PNG file states, so that nothing larger is made of it.
std::optional<cv::Size> SizeOfPng(const std::string& bytes) {
  if (bytes.size() < 24 || bytes.compare(0, 4, "\x89PNG") != 0) return std::nullopt;
  const auto number = [&](std::size_t at) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  if (number(16) > kMostSide || number(20) > kMostSide) return std::nullopt;
  return cv::Size(static_cast<int>(number(16)), static_cast<int>(number(20)));
}

}  // namespace

Result<wire::Pixels> SendablePixels::For(const wire::Request& request) {
  wire::Pixels pixels;
  pixels.set_width(static_cast<std::uint32_t>(image_.cols));
  pixels.set_height(static_cast<std::uint32_t>(image_.rows));
  pixels.set_channels(static_cast<std::uint32_t>(image_.channels()));
  const std::size_t row_bytes = image_.cols * image_.elemSize(), bytes = image_.rows * row_bytes;
  const std::lock_guard lock(mutex_);
  if (request.machine() == ThisMachine() && bytes > 0) {
    if (shared_ == nullptr) {
      Result<std::shared_ptr<const SharedImage>> shared = SharedImage::Create(image_);
      if (!shared.ok()) return shared.error();
      shared_ = std::move(shared).value();
      counts_->copied_bytes += bytes;
    }
    *pixels.mutable_shared() = shared_->name();
    ++counts_->shared;
    return pixels;
  }
  ++counts_->sent;
  if (request.plain_pixels()) {
    std::string& plain = *pixels.mutable_plain();
    for (int row = 0; row < image_.rows; ++row) plain.append(image_.ptr<char>(row), row_bytes);
    counts_->copied_bytes += bytes;
    return pixels;
  }
  if (png_.empty() && bytes > 0) {
    std::vector<unsigned char> file;
    cv::imencode(".png", image_, file, {cv::IMWRITE_PNG_COMPRESSION, 1});
    png_.assign(file.begin(), file.end());
    counts_->copied_bytes += bytes;
  }
  pixels.set_png(png_);
  return pixels;
}

Result<cv::Mat> PixelsFromWire(const wire::Pixels& pixels) {
  if (pixels.width() == 0 && pixels.height() == 0) return cv::Mat();
  if (pixels.width() == 0 || pixels.height() == 0 || pixels.width() > kMostSide ||
      pixels.height() > kMostSide ||
      std::int64_t{pixels.width()} * std::int64_t{pixels.height()} > kMostPixels ||
      (pixels.channels() != 1 && pixels.channels() != 3))
    return BadMessage("an image of a size that none has");
  const cv::Size size(static_cast<int>(pixels.width()), static_cast<int>(pixels.height()));
  const int type = pixels.channels() == 1 ? CV_8UC1 : CV_8UC3;
  switch (pixels.content_case()) {
    case wire::Pixels::kShared:
      return MapSharedImage(pixels.shared(), size, type);
    case wire::Pixels::kPlain: {
      cv::Mat image(size, type);
      if (pixels.plain().size() != image.total() * image.elemSize())
        return BadMessage("an image of another size than it says");
      std::memcpy(image.data, pixels.plain().data(), pixels.plain().size());
      return image;
    }
    case wire::Pixels::kPng: {
      if (SizeOfPng(pixels.png()) != size)
        return BadMessage("an image of another size than it says");
      const cv::Mat bytes(1, static_cast<int>(pixels.png().size()), CV_8UC1,
                          const_cast<char*>(pixels.png().data()));
      cv::Mat image;
      try {
        image = cv::imdecode(bytes, type == CV_8UC1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
      } catch (const cv::Exception&) {
        image.release();
      }
      if (image.size() != size || image.type() != type)
        return BadMessage("an image that cannot be decoded");
      return image;
    }
    default:
      return BadMessage("an image without pixels");
  }
}

void SetTransform(const Eigen::Isometry3d& transform,
                  google::protobuf::RepeatedField<double>& rows) {
  rows.Clear();
  for (int i = 0; i < 12; ++i) rows.Add(transform.matrix()(i / 4, i % 4));
}

Result<Eigen::Isometry3d> TransformFromWire(const google::protobuf::RepeatedField<double>& rows) {
  if (rows.size() != 12) return BadMessage("a pose that is none");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) {
    if (!std::isfinite(rows[i])) return BadMessage("a pose that is none");
    transform.matrix()(i / 4, i % 4) = rows[i];
  }
  return transform;
}

wire::Sequence SequenceToWire(const Sequence& sequence) {
  wire::Sequence message;
  const auto file = [](const std::optional<std::filesystem::path>& path) {
    return path ? std::filesystem::absolute(*path).string() : std::string();
  };
  message.set_path(std::filesystem::absolute(sequence.path()).string());
  const PinholeCamera& camera = sequence.camera();
  message.mutable_camera()->set_width(camera.width);
  message.mutable_camera()->set_height(camera.height);
  message.mutable_camera()->set_fx(camera.fx);
  message.mutable_camera()->set_fy(camera.fy);
  message.mutable_camera()->set_cx(camera.cx);
  message.mutable_camera()->set_cy(camera.cy);
  message.set_rate_hz(sequence.rate_hz());
  for (int frame = 0; frame < sequence.num_frames(); ++frame) {
    wire::SequenceFrame& row = *message.add_frames();
    row.set_stamp_ns(sequence.stamp_ns(frame));
    const auto pose = sequence.world_from_cam(frame);
    if (!pose) continue;
    SetTransform(*pose, *row.mutable_pose()->mutable_world_from_cam());
    const PoseUncertainty uncertainty = sequence.pose_uncertainty(frame);
    SetCovariance(uncertainty.drift, *row.mutable_pose()->mutable_drift());
    SetCovariance(uncertainty.own, *row.mutable_pose()->mutable_own());
  }
  if (const auto gravity = sequence.gravity_in_world())
    SetVector(*gravity, *message.mutable_gravity_in_world());
  if (const auto floor = sequence.floor_in_world()) {
    for (int i = 0; i < 4; ++i) message.add_floor_in_world((*floor)[i]);
  }
  message.set_floor_std_m(sequence.floor_std_m());
  for (const FloorLevel& level : sequence.floor_levels()) {
    wire::FloorLevel& row = *message.add_floor_levels();
    row.set_height_m(level.height_m);
    row.set_std_m(level.std_m);
    for (const Eigen::Vector3d& corner : level.outline_in_world)
      SetVector(corner, *row.add_outline_in_world());
  }
  message.set_has_images(sequence.has_images());
  message.set_has_edges(sequence.has_edges());
  message.set_has_proposals(sequence.has_proposals());
  message.set_models_folder(file(sequence.models_folder()));
  message.set_ground_truth_file(file(sequence.ground_truth_file()));
  message.set_scene_file(file(sequence.scene_file()));
  return message;
}

wire::Proposals ProposalsToWire(std::span<const Detection> detections) {
  wire::Proposals message;
  for (const Detection& detection : detections) {
    wire::Proposal& row = *message.add_proposals();
    row.set_x0(detection.box.x0);
    row.set_y0(detection.box.y0);
    row.set_x1(detection.box.x1);
    row.set_y1(detection.box.y1);
    row.set_category(detection.category);
    row.set_score(detection.score);
  }
  return message;
}

Result<std::vector<Detection>> ProposalsFromWire(const wire::Proposals& proposals) {
  std::vector<Detection> detections;
  for (const wire::Proposal& row : proposals.proposals()) {
    const bool numbers = std::isfinite(row.x0()) && std::isfinite(row.y0()) &&
                         std::isfinite(row.x1()) && std::isfinite(row.y1());
    if (!numbers || !(row.score() >= 0 && row.score() <= 1))
      return BadMessage("a box that is none");
    detections.push_back({{row.x0(), row.y0(), row.x1(), row.y1()}, row.category(), row.score()});
  }
  return detections;
}

}  // namespace plumbline
