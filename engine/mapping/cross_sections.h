// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/models/model_database.h"

namespace plumbline {

/// Points of a model's surface at heights 2 cm apart.
class CrossSections {
 public:
  explicit CrossSections(const CadModel& model);

  /// At that height above the model's bottom (of scale 1): points [x, y of `object`, metres] along
  /// where its surface is cut, evenly spaced; none below its bottom and above its top.
  std::span<const Eigen::Vector2f> At(double height_m) const;

 private:
  std::vector<std::vector<Eigen::Vector2f>> levels_;
};

}  // namespace plumbline
