// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// Messages of ROS 1 as they are sent: little-endian, texts and lists behind their length
/// (wiki.ros.org/msg; std_msgs, sensor_msgs, geometry_msgs, tf2_msgs). Of damaged ones there is
/// nothing.
struct RosHeader {
  std::int64_t stamp_ns = 0;
  std::string frame;  ///< Without a leading slash.
};

/// The header that all messages of sensors begin with; the first bytes are enough.
std::optional<RosHeader> ParseRosHeader(std::string_view message);

/// sensor_msgs/Image as CV_8UC3 BGR. Errors: kCorrupt, kUnsupported (an encoding).
Result<cv::Mat> ParseRosImage(std::string_view message);
/// The encoding of a sensor_msgs/Image, as bgr8.
std::optional<std::string> ParseRosEncoding(std::string_view message);
/// sensor_msgs/Image of 16UC1 [mm] or 32FC1 [m] as CV_16UC1 [mm], 0 where there is none.
Result<cv::Mat> ParseRosDepth(std::string_view message);
/// The image file inside a sensor_msgs/CompressedImage; of a depth image (compressedDepth, PNG)
/// without what stands before it.
std::optional<std::string_view> ParseRosCompressed(std::string_view message);

struct RosCameraInfo {
  RosHeader header;
  int width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> distortion;
  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Zero();                          ///< K
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();  ///< P
};
std::optional<RosCameraInfo> ParseRosCameraInfo(std::string_view message);

struct RosImu {
  RosHeader header;
  Eigen::Vector3d angular_velocity_rad_s{0, 0, 0}, specific_force_m_s2{0, 0, 0};
};
std::optional<RosImu> ParseRosImu(std::string_view message);

struct RosTransform {
  RosHeader header;   ///< `frame` is the parent.
  std::string child;  ///< Without a leading slash.
  Eigen::Isometry3d parent_from_child = Eigen::Isometry3d::Identity();
};
/// tf/tfMessage and tf2_msgs/TFMessage. Transforms whose quaternion is not of unit length (1 %) or
/// that are not finite are left out.
std::optional<std::vector<RosTransform>> ParseRosTransforms(std::string_view message);

}  // namespace plumbline
