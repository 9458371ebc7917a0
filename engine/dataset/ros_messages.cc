// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/ros_messages.h"

#include <cmath>
#include <cstring>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/reach.h"

namespace plumbline {
namespace {

/// Takes a message apart from the front; what is not there makes it bad for good.
class RosCursor {
 public:
  explicit RosCursor(std::string_view message) : rest_(message) {}
  bool good() const { return good_; }

  template <typename Number>
  Number Take() {
    Number number = 0;
    const std::string_view bytes = Bytes(sizeof number);
    if (good_) std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::string_view Bytes(std::size_t count) {
    if (!good_ || count > rest_.size()) {
      good_ = false;
      return {};
    }
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  std::string_view Text() { return Bytes(Take<std::uint32_t>()); }
  std::string Frame() {
    std::string_view frame = Text();
    if (frame.starts_with('/')) frame.remove_prefix(1);
    return std::string(frame);
  }
  RosHeader Header() {
    Take<std::uint32_t>();  // its number
    RosHeader header;
    const auto seconds = Take<std::uint32_t>();
    header.stamp_ns = std::int64_t{seconds} * 1'000'000'000 + Take<std::uint32_t>();
    header.frame = Frame();
    return header;
  }
  Eigen::Vector3d Vector() {
    const auto x = Take<double>(), y = Take<double>();
    return {x, y, Take<double>()};
  }
  template <typename Matrix>
  void RowMajor(Matrix& matrix) {
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
      for (Eigen::Index c = 0; c < matrix.cols(); ++c) matrix(r, c) = Take<double>();
    }
  }

 private:
  std::string_view rest_;
  bool good_ = true;
};

struct RosPixels {
  int width = 0, height = 0;
  std::string encoding;
  bool big_endian = false;
  std::size_t step = 0;
  std::string_view data;
};

std::optional<RosPixels> PixelsOf(std::string_view message) {
  RosCursor cursor(message);
  cursor.Header();
  RosPixels pixels;
  const auto height = cursor.Take<std::uint32_t>(), width = cursor.Take<std::uint32_t>();
  pixels.encoding = cursor.Text();
  pixels.big_endian = cursor.Take<std::uint8_t>() != 0;
  pixels.step = cursor.Take<std::uint32_t>();
  pixels.data = cursor.Text();
  if (!cursor.good() || width == 0 || height == 0 || width > 65535 || height > 65535 ||
      std::uint64_t{height} * pixels.step > pixels.data.size())
    return std::nullopt;
  pixels.width = static_cast<int>(width);
  pixels.height = static_cast<int>(height);
  return pixels;
}

const Error kDamagedRosImage{ErrorCode::kCorrupt, "an image message is damaged"};

/// A view of the pixels; null where rows are too short for the type.
cv::Mat ViewOf(const RosPixels& pixels, int type) {
  if (pixels.step < static_cast<std::size_t>(pixels.width) * CV_ELEM_SIZE(type)) return {};
  return {pixels.height, pixels.width, type, const_cast<char*>(pixels.data.data()), pixels.step};
}

struct RosEncoding {
  std::string_view name;
  int type;
  int to_bgr;  ///< As of cv::cvtColor; negative: none.
};
/// sensor_msgs/image_encodings.h. A Bayer pattern is named by its first row's first pixels, in
/// OpenCV by those of its second.
constexpr RosEncoding kRosEncodings[] = {{"bgr8", CV_8UC3, -1},
                                         {"8UC3", CV_8UC3, -1},
                                         {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
                                         {"mono8", CV_8UC1, cv::COLOR_GRAY2BGR},
                                         {"8UC1", CV_8UC1, cv::COLOR_GRAY2BGR},
                                         {"mono16", CV_16UC1, cv::COLOR_GRAY2BGR},
                                         {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
                                         {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
                                         {"yuv422", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
                                         {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
                                         {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
                                         {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
                                         {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR}};

}  // namespace

std::optional<RosHeader> ParseRosHeader(std::string_view message) {
  RosCursor cursor(message);
  RosHeader header = cursor.Header();
  return cursor.good() ? std::optional(std::move(header)) : std::nullopt;
}

std::optional<std::string> ParseRosEncoding(std::string_view message) {
  const std::optional<RosPixels> pixels = PixelsOf(message);
  return pixels ? std::optional(pixels->encoding) : std::nullopt;
}

Result<cv::Mat> ParseRosImage(std::string_view message) {
  const std::optional<RosPixels> pixels = PixelsOf(message);
  if (!pixels) return kDamagedRosImage;
  for (const RosEncoding& encoding : kRosEncodings) {
    if (encoding.name != pixels->encoding) continue;
    cv::Mat view = ViewOf(*pixels, encoding.type);
    if (view.empty() || (encoding.type == CV_16UC1 && pixels->big_endian) ||
        (encoding.type == CV_8UC2 && pixels->width % 2 != 0) ||
        (encoding.name.starts_with("bayer") && (pixels->width < 4 || pixels->height < 4)))
      return kDamagedRosImage;
    if (encoding.type == CV_16UC1) {
      cv::Mat bytes;
      view.convertTo(bytes, CV_8UC1, 1.0 / 256);
      view = bytes;
    }
    if (encoding.to_bgr < 0) return view.clone();
    cv::Mat bgr;
    cv::cvtColor(view, bgr, encoding.to_bgr);
    return bgr;
  }
  return Error{ErrorCode::kUnsupported,
               "images are encoded as '" + pixels->encoding.substr(0, 40) +
                   "', which this version does not read (it reads bgr8, rgb8, bgra8, rgba8, mono8, "
                   "mono16, yuv422 and Bayer of 8 bits)"};
}

Result<cv::Mat> ParseRosDepth(std::string_view message) {
  const std::optional<RosPixels> pixels = PixelsOf(message);
  if (!pixels || pixels->big_endian) return kDamagedRosImage;
  const bool metres = pixels->encoding == "32FC1";
  if (!metres && pixels->encoding != "16UC1" && pixels->encoding != "mono16") {
    return Error{ErrorCode::kUnsupported,
                 "depth is encoded as '" + pixels->encoding.substr(0, 40) +
                     "', which this version does not read (it reads 16UC1 and 32FC1)"};
  }
  const cv::Mat view = ViewOf(*pixels, metres ? CV_32FC1 : CV_16UC1);
  if (view.empty()) return kDamagedRosImage;
  if (!metres) return view.clone();
  cv::Mat depth(view.size(), CV_16UC1);
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.cols; ++x) {
      float value = 0;  // rows need not be aligned
      std::memcpy(&value, view.ptr(y) + sizeof value * static_cast<std::size_t>(x), sizeof value);
      const float mm = std::round(value * 1000);
      depth.at<std::uint16_t>(y, x) =
          mm > 0 && mm < 65536 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
    }
  }
  return depth;
}

std::optional<std::string_view> ParseRosCompressed(std::string_view message) {
  RosCursor cursor(message);
  cursor.Header();
  const std::string_view format = cursor.Text();
  std::string_view data = cursor.Text();
  if (!cursor.good()) return std::nullopt;
  constexpr std::size_t kDepthConfiguration = 12;
  if (format.find("compressedDepth") != std::string_view::npos) {
    if (data.size() < kDepthConfiguration) return std::nullopt;
    data.remove_prefix(kDepthConfiguration);
  }
  return data;
}

std::optional<RosCameraInfo> ParseRosCameraInfo(std::string_view message) {
  RosCursor cursor(message);
  RosCameraInfo info;
  info.header = cursor.Header();
  const auto height = cursor.Take<std::uint32_t>(), width = cursor.Take<std::uint32_t>();
  info.distortion_model = cursor.Text();
  const auto count = cursor.Take<std::uint32_t>();
  if (!cursor.good() || count > 14 || width > 65535 || height > 65535) return std::nullopt;
  for (std::uint32_t i = 0; i < count; ++i) info.distortion.push_back(cursor.Take<double>());
  cursor.RowMajor(info.intrinsics);
  Eigen::Matrix3d rectification;
  cursor.RowMajor(rectification);
  cursor.RowMajor(info.projection);
  if (!cursor.good()) return std::nullopt;
  info.width = static_cast<int>(width);
  info.height = static_cast<int>(height);
  return info;
}

std::optional<RosImu> ParseRosImu(std::string_view message) {
  RosCursor cursor(message);
  RosImu imu;
  imu.header = cursor.Header();
  Eigen::Vector4d orientation;
  Eigen::Matrix3d covariance;
  cursor.RowMajor(orientation);
  cursor.RowMajor(covariance);
  imu.angular_velocity_rad_s = cursor.Vector();
  cursor.RowMajor(covariance);
  imu.specific_force_m_s2 = cursor.Vector();
  if (!cursor.good() || !imu.angular_velocity_rad_s.allFinite() ||
      !imu.specific_force_m_s2.allFinite())
    return std::nullopt;
  return imu;
}

std::optional<std::vector<RosTransform>> ParseRosTransforms(std::string_view message) {
  RosCursor cursor(message);
  const auto count = cursor.Take<std::uint32_t>();
  std::vector<RosTransform> transforms;
  for (std::uint32_t i = 0; i < count && cursor.good(); ++i) {
    RosTransform transform;
    transform.header = cursor.Header();
    transform.child = cursor.Frame();
    const Eigen::Vector3d translation = cursor.Vector();
    Eigen::Vector4d q;  // x, y, z, w
    cursor.RowMajor(q);
    if (!cursor.good() || !(std::abs(q.norm() - 1) < 0.01) ||
        !(translation.cwiseAbs().maxCoeff() < kFarthest_m) || !translation.allFinite())
      continue;
    transform.parent_from_child.linear() = Eigen::Quaterniond(q).normalized().toRotationMatrix();
    transform.parent_from_child.translation() = translation;
    transforms.push_back(std::move(transform));
  }
  return cursor.good() ? std::optional(std::move(transforms)) : std::nullopt;
}

}  // namespace plumbline
