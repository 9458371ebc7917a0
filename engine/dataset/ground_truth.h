// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
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
  /// How well the pose is known, where the file says so: one standard deviation, of the position
  /// the root of the mean squared distance.
  std::optional<double> position_std_m, azimuth_std_rad;
  double scale =
      1;  ///< Times as large as its model: world_from_object * (scale * point_in_object).
  /// Length, width and height of its box along x, y and z of `object`, which stands on the origin;
  /// where a data set tells boxes.
  std::optional<Eigen::Vector3d> size_m;
};

/// How well the pose of an instance is known. What the file does not say: 1.5 cm and 1 degree if
/// fine, else 3 cm and 3 degrees.
struct TruthDeviation {
  double position_m = 0, azimuth_rad = 0;
};
TruthDeviation DeviationOf(const GroundTruthInstance& instance);

/// What moves while a sequence is recorded: no map should hold it.
struct MovingThing {
  std::string id;
  std::string category;             ///< COCO name.
  Eigen::Vector3d size_m{0, 0, 0};  ///< As of an instance.
  struct Place {
    int frame = 0;  ///< Of the sequence.
    Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  };
  std::vector<Place> places;  ///< By rising frame.
};

struct GroundTruth {
  Eigen::Vector3d gravity_in_world{0, 0, -1};  ///< Unit vector, down.
  std::vector<GroundTruthInstance> instances;
  std::vector<MovingThing> moving;
};

/// Errors: kNotFound, kCorrupt, kInvalidInput (a rotation that is none, a duplicate id), naming
/// file and instance.
Result<GroundTruth> ReadGroundTruth(const std::filesystem::path& file);
Status WriteGroundTruth(const std::filesystem::path& file, const GroundTruth& truth);

}  // namespace plumbline
