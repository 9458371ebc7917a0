// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/models/axis_guess.h"
#include "engine/models/mesh_cleanup.h"
#include "engine/models/mesh_decimation.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// What is known about a mesh file; what is not stated is guessed, with a warning.
struct ModelBuildOptions {
  int faces = 5000;                ///< At most this many.
  std::optional<LengthUnit> unit;  ///< Of the file.
  std::optional<SignedAxis> up;    ///< In the file's axes.
  bool up_sign_stated =
      true;  ///< False: `up` names the axis; its sign is turned if the shape clearly says so.
  std::optional<SignedAxis> front;  ///< In the file's axes.
  std::string category;             ///< COCO name; "" for the one in the file's name, if any.
  int symmetry = 1;                 ///< Order about +z; 0 continuous.
  bool back = false;                ///< As of CadModel.
};

struct ModelBuildReport {
  CleanupReport cleanup;
  DecimationReport decimation;
  LengthUnit unit = LengthUnit::kMetre;
  SignedAxis up{2, 1}, front{0, 1};
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();  ///< After the unit [m].
  std::vector<std::string>
      warnings;  ///< Sentences: what was guessed, why and how surely; what was left out.
};

struct BuiltModel {
  CadModel model;
  ModelBuildReport report;
  std::filesystem::path source;
  std::filesystem::path texture;  ///< To be copied beside the mesh; empty without one.
};

/// Reads a mesh and brings it into the canonical frame of the database: metres, +z up, +x front,
/// origin at the centre of the footprint on the supporting plane; cleaned and decimated. Errors:
/// those of ReadMesh; kInvalidInput for options that contradict each other; kDegenerate for a mesh
/// without area or one that cannot be decimated.
Result<BuiltModel> BuildModel(const std::filesystem::path& mesh_file,
                              const ModelBuildOptions& options);

/// The same for a mesh in memory that is called `name` and was taken from `source`, beside which
/// its texture is. Errors: as of BuildModel, without those of reading.
Result<BuiltModel> BuildModelFrom(const TriangleMesh& mesh, const std::string& name,
                                  const std::filesystem::path& source,
                                  const ModelBuildOptions& options);

/// Writes the mesh as PLY (and its texture) into the folder and enters it in models.json, which is
/// replaced atomically; a model of the same name is replaced, other entries and unknown keys stay.
/// Errors: kIo, kCorrupt.
Status StoreModel(const BuiltModel& built, const std::filesystem::path& folder);

}  // namespace plumbline
