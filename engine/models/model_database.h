// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// Rotational symmetry about an axis through the object's origin: order 1 none, n > 1 n-fold, 0
/// continuous.
struct Symmetry {
  Eigen::Vector3d axis{0, 0, 1};
  int order = 1;
};

enum class Support { kFloor, kAny };

/// One shape of the database in its canonical frame `object`: +z up, origin at the centre of the
/// footprint on the supporting plane, +x its front; metres.
struct CadModel {
  ModelId id;  ///< Index in the database: the shape label k.
  std::string name;
  std::string file;      ///< Relative to the database folder.
  std::string category;  ///< COCO name.
  Symmetry symmetry;
  Support support = Support::kAny;
  bool back = false;  ///< Its back is put against a wall or against something else.
  std::string note;
  TriangleMesh mesh;
  Eigen::AlignedBox3f bounds;  ///< In `object`.
  std::string content_hash;    ///< Of vertices, triangles and colours.
  /// c_k: the point of `object` that bearing and log-depth locate.
  Eigen::Vector3d center() const { return bounds.center().cast<double>(); }
};

/// The shape `factor` times as large: about its origin, the middle of its base.
CadModel Scaled(CadModel model, double factor);

/// The shapes that the mapper knows. Immutable; share it.
class ModelDatabase {
 public:
  /// Reads DIR/models.json and its meshes. Errors: kNotFound, kCorrupt, kInvalidInput, naming the
  /// file.
  static Result<std::shared_ptr<const ModelDatabase>> Load(const std::filesystem::path& folder);
  static std::shared_ptr<const ModelDatabase> FromModels(std::vector<CadModel> models);

  const std::vector<CadModel>& models() const { return models_; }
  const CadModel& model(ModelId id) const { return models_.at(static_cast<std::size_t>(id.value)); }
  std::optional<ModelId> Find(std::string_view name) const;
  std::vector<ModelId> OfCategory(std::string_view category) const;
  const std::filesystem::path& folder() const { return folder_; }
  /// Of all models in order.
  const std::string& content_hash() const { return content_hash_; }

 private:
  std::filesystem::path folder_;
  std::vector<CadModel> models_;
  std::string content_hash_;
};

}  // namespace plumbline
