// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"

namespace plumbline {

struct GroundTruthInstance {
  std::string id;
  std::string model;     ///< Name in the model database.
  std::string category;  ///< COCO name.
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  bool fine = true;  ///< quality "fine" (else "coarse")
};

struct GroundTruth {
  Eigen::Vector3d gravity_in_world{0, 0, -1};  ///< Unit vector, down.
  std::vector<GroundTruthInstance> instances;
};

/// Errors: kNotFound, kCorrupt, kInvalidInput (a rotation that is none, a duplicate id), naming
/// file and instance.
Result<GroundTruth> ReadGroundTruth(const std::filesystem::path& file);
Status WriteGroundTruth(const std::filesystem::path& file, const GroundTruth& truth);

}  // namespace plumbline
