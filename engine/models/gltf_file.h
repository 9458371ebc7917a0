// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// A model at its place in a room.
struct GltfObject {
  std::string name;
  const CadModel* model = nullptr;  ///< Must not be null, nor empty.
  Eigen::Isometry3d room_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;
  std::filesystem::path texture;              ///< As of TextureOf; "" without one.
  std::map<std::string, std::string> extras;  ///< What else is known of it.
};

/// Which axis of the file points up. glTF says y, and readers such as Blender's turn it to theirs;
/// z is for programs that take numbers as they are.
enum class GltfUp { kY, kZ };

/// One binary glTF 2.0 file: metres, one node for each object below a node that turns the room
/// (z up) to `up`, meshes shared by objects of one model, with colours, texture or, where a model
/// has neither, a colour for each object. Surfaces are two-sided. Errors: kInvalidInput (no
/// objects, a name without .glb), kIo.
Status WriteGltf(const std::filesystem::path& file, std::span<const GltfObject> objects, GltfUp up);

}  // namespace plumbline
