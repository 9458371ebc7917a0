// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/image_file.h"

#include <cctype>
#include <csetjmp>
#include <cstdint>
#include <cstdio>  // jpeglib.h needs FILE
#include <cstring>
#include <string>
#include <string_view>

// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on
#include <zlib.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/sensor/image_decoding.h"

namespace plumbline {
namespace {

/// What each kind of image is decoded to.
struct Decoding {
  int type;  ///< Of the cv::Mat.
  int png_flags;
};
Decoding DecodingOf(ImageKind kind) {
  switch (kind) {
    case ImageKind::kColor:
      return {CV_8UC3, cv::IMREAD_COLOR};
    case ImageKind::kGray:
      return {CV_8UC1, cv::IMREAD_GRAYSCALE};
    case ImageKind::kDepth:
      return {CV_16UC1, cv::IMREAD_ANYDEPTH};
  }
  return {};
}

/// Images larger than this are taken for damaged headers: 268 million pixels, 0.8 GB in colour.
constexpr int kMaxSide = 32768;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 28;

bool IsTooLarge(cv::Size size) {
  return size.width > kMaxSide || size.height > kMaxSide ||
         std::int64_t{size.width} * size.height > kMaxPixels;
}

std::string Text(cv::Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

std::optional<std::string> SizeProblem(cv::Size size, const std::optional<cv::Size>& wanted) {
  if (wanted && size != *wanted) return "is " + Text(size) + " but must be " + Text(*wanted);
  return std::nullopt;
}

/// What libjpeg hands to its callbacks. Everything that outlives a longjmp is plain data.
struct JpegErrors {
  jpeg_error_mgr manager;  // first: libjpeg knows only this part
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX] = "";
};

void KeepMessage(j_common_ptr info) {
  auto* errors = reinterpret_cast<JpegErrors*>(info->err);
  if (errors->message[0] == '\0') info->err->format_message(info, errors->message);
}

[[noreturn]] void OnFatal(j_common_ptr info) {
  KeepMessage(info);
  std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->jump, 1);
}

void OnMessage(j_common_ptr info, int level) {
  // Padding between segments is harmless and some cameras write it; every other warning is lost
  // picture.
  if (level < 0 && info->err->msg_code != JWRN_EXTRANEOUS_DATA) OnFatal(info);
}

/// Reads the header (`image` null: only the size), then the pixels into `image`. False with
/// `errors.message` on failure. Holds no object with a destructor, so that longjmp is well defined.
bool DecodeJpeg(const unsigned char* data, unsigned long length, cv::Size* size, cv::Mat* image,
                JpegErrors* errors) {
  jpeg_decompress_struct info;
  info.err = jpeg_std_error(&errors->manager);
  errors->manager.error_exit = OnFatal;
  errors->manager.emit_message = OnMessage;
  if (setjmp(errors->jump) != 0) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, data, length);
  jpeg_read_header(&info, TRUE);
  *size = {static_cast<int>(info.image_width), static_cast<int>(info.image_height)};
  if (image != nullptr) {
    info.out_color_space = image->channels() == 3 ? JCS_EXT_BGR : JCS_GRAYSCALE;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      JSAMPROW row = image->ptr(static_cast<int>(info.output_scanline));
      jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
  }
  jpeg_destroy_decompress(&info);
  return true;
}

std::uint32_t BigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// The size of a PNG whose chunks are all there and whole; nothing for any other. Asked first
/// because libpng complains on standard error.
std::optional<cv::Size> CompletePngSize(const std::string& bytes) {
  if (bytes.size() < 33 || bytes.compare(12, 4, "IHDR") != 0) return std::nullopt;
  const cv::Size size(static_cast<int>(BigEndian(bytes, 16)),
                      static_cast<int>(BigEndian(bytes, 20)));
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t next = at + 12 + BigEndian(bytes, at);
    if (next > bytes.size()) return std::nullopt;
    const auto* chunk = reinterpret_cast<const unsigned char*>(bytes.data()) + at + 4;
    if (crc32(0, chunk, static_cast<uInt>(next - at - 8)) != BigEndian(bytes, next - 4))
      return std::nullopt;
    if (bytes.compare(at + 4, 4, "IEND") == 0) return size;
    at = next;
  }
  return std::nullopt;
}

}  // namespace

bool IsImageName(const std::filesystem::path& name) {
  std::string extension = name.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

Result<cv::Mat> ReadImage(const std::filesystem::path& file, ImageKind kind,
                          std::optional<cv::Size> wanted) {
  const Result<std::string> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  return DecodeImage(*bytes, kind, wanted, file.string());
}

Result<cv::Mat> DecodeImage(const std::string& bytes, ImageKind kind,
                            std::optional<cv::Size> wanted, const std::string& name) {
  const auto error = [&](ErrorCode code, const std::string& what) {
    return Error{code, "the image '" + name + "' " + what};
  };
  const auto [type, png_flags] = DecodingOf(kind);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  if (bytes.starts_with("\xff\xd8\xff")) {
    if (kind == ImageKind::kDepth)
      return error(ErrorCode::kUnsupported, "is a JPEG; depth needs a PNG of 16 bits");
    JpegErrors errors;
    cv::Size size;
    if (!DecodeJpeg(data, bytes.size(), &size, nullptr, &errors)) {
      return error(ErrorCode::kCorrupt, std::string("is damaged: ") + errors.message);
    }
    if (const auto problem = SizeProblem(size, wanted))
      return error(ErrorCode::kInvalidInput, *problem);
    if (IsTooLarge(size)) return error(ErrorCode::kCorrupt, "claims to be " + Text(size));
    cv::Mat image(size, type);
    if (!DecodeJpeg(data, bytes.size(), &size, &image, &errors)) {
      return error(ErrorCode::kCorrupt, std::string("is truncated or damaged: ") + errors.message);
    }
    return image;
  }
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) {
    const std::optional<cv::Size> size = CompletePngSize(bytes);
    if (!size) return error(ErrorCode::kCorrupt, "is truncated or damaged");
    if (const auto problem = SizeProblem(*size, wanted))
      return error(ErrorCode::kInvalidInput, *problem);
    if (size->width < 1 || size->height < 1 || IsTooLarge(*size)) {
      return error(ErrorCode::kCorrupt, "claims to be " + Text(*size));
    }
    cv::Mat image;
    try {
      const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1,
                           const_cast<unsigned char*>(data));
      image = cv::imdecode(buffer, png_flags | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      image.release();
    }
    if (kind == ImageKind::kDepth && image.size() == *size && image.type() == CV_8UC1)
      return error(ErrorCode::kInvalidInput, "has 8 bits; depth needs a PNG of 16 bits");
    if (image.size() != *size || image.type() != type)
      return error(ErrorCode::kCorrupt, "is damaged");
    return image;
  }
  if (bytes.empty()) return error(ErrorCode::kCorrupt, "is an empty file");
  return error(ErrorCode::kUnsupported, "is neither JPEG nor PNG");
}

}  // namespace plumbline
