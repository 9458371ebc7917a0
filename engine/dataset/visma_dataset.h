// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// The file `dataset` of a sequence of VISMA: vlslam_pb::Dataset (vlslam.proto, proto2), without
/// features and tracks. Repeated numbers may be packed or not.
struct VismaDataset {
  int rows = 0, cols = 0;
  std::vector<double> parameters;  ///< fx, fy, cx, cy ..
  struct Packet {
    double stamp = 0;  ///< In the unit of the file names; images are not joined by it.
    std::optional<Eigen::Isometry3d> world_from_cam;  ///< gwc; none where it is no rigid transform.
    std::optional<Eigen::Vector2d> gravity_rotation;  ///< wg: exp([x, y, 0]) turns -z to gravity.
  };
  std::vector<Packet> packets;
};
/// Errors: kNotFound, kCorrupt, naming the file.
Result<VismaDataset> ReadVismaDataset(const std::filesystem::path& file);

/// A file `STAMP.bbox` (vlslam_pb::BoundingBoxList): corners in pixels, the best class and its
/// score. Errors: kNotFound, kCorrupt, naming the file.
Result<std::vector<Detection>> ReadVismaBoxes(const std::filesystem::path& file);

}  // namespace plumbline
