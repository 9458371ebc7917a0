// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/models/mesh_cleanup.h"

namespace plumbline {

/// What `models check` says about one entry of a database.
struct ModelCheck {
  std::string name, file, category;
  int faces = 0, vertices = 0;
  EdgeCounts edges;
  CleanupReport flaws;                ///< What cleaning would remove.
  Eigen::Vector3d size_m{0, 0, 0};    ///< Along x (depth), y (width), z (height) of `object`.
  Eigen::Vector2d footprint_m{0, 0};  ///< Centre of the footprint; the origin should lie there.
  double lowest_m = 0;                ///< Of the lowest point; the supporting plane should be at 0.
  bool has_colors = false, has_texture = false;
  std::vector<std::string> warnings;  ///< Usable, but look at it.
  std::vector<std::string> problems;  ///< Unusable.
};

/// Every entry of DIR/models.json, also the broken ones. Errors: kNotFound, kCorrupt for the list
/// itself.
Result<std::vector<ModelCheck>> CheckModels(const std::filesystem::path& folder);

}  // namespace plumbline
