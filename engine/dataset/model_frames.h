// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace plumbline {

/// How the models that a database was built from stand in it: `object` of a model by its name from
/// the axes of its mesh file, in metres. Data sets pose mesh files; we pose what was built of them.
using ModelFrames = std::map<std::string, Eigen::Isometry3d, std::less<>>;

/// Of the model, or null; a name that lacks goes into the warnings, unless no frames are known.
const Eigen::Isometry3d* FindModelFrame(const ModelFrames& frames, const std::string& model,
                                        std::vector<std::string>& warnings);

}  // namespace plumbline
