// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/models/axis_guess.h"
#include "engine/models/mesh_cleanup.h"
#include "engine/models/mesh_decimation.h"
#include "engine/models/model_database.h"
#include "engine/models/textured_mesh.h"

namespace plumbline {

/// A guess that is less sure asks to be looked at, and stays marked as one in models.json.
inline constexpr double kSureGuess = 0.8;

/// What is known about a mesh file; what neither this nor the file states is guessed, with a
/// warning.
struct ModelBuildOptions {
  int faces = 5000;                ///< At most this many; a texture may add as many again.
  std::optional<LengthUnit> unit;  ///< Of the file.
  std::optional<SignedAxis> up;    ///< In the file's axes.
  bool up_sign_stated =
      true;  ///< False: `up` names the axis; its sign is turned if the shape clearly says so.
  std::optional<SignedAxis> front;  ///< In the file's axes.
  std::string category;             ///< COCO name; "" for the one in the file's name, if any.
  int symmetry = 1;                 ///< Order about +z; 0 continuous.
  bool back = false;                ///< As of CadModel.
};

/// One of unit, up and front, and how sure it is: 1 where it was stated.
template <typename T>
struct Settled {
  T value{};
  double confidence = 1;
  std::vector<std::pair<T, double>> shares;  ///< As of Guess; empty where it was stated.

  bool sure() const { return confidence >= kSureGuess; }
};

struct ModelBuildReport {
  CleanupReport cleanup;
  DecimationReport decimation;
  int faces_for_texture = 0;         ///< Added where it changes.
  Settled<double> unit{1.0, 1, {}};  ///< One unit of the file [m].
  Settled<SignedAxis> up{{2, 1}, 1, {}}, front{{0, 1}, 1, {}};
  bool has_front = true;  ///< False: a round thing, or a table: `front` is an agreement.
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();  ///< After the unit [m].
  std::vector<std::string> believed;  ///< Sentences: what the file states and was believed.
  std::vector<std::string>
      warnings;  ///< Sentences: what was guessed, why and how surely; what was left out.
};

struct BuiltModel {
  CadModel model;
  ModelBuildReport report;
  std::filesystem::path source;
  std::filesystem::path texture;  ///< To be copied beside the mesh; empty: `texture_image` is.
  cv::Mat texture_image;          ///< Empty without one.
};

/// Reads a mesh and brings it into the canonical frame of the database: metres, +z up, +x front,
/// origin at the centre of the footprint on the supporting plane; cleaned, decimated, and painted
/// by its texture (PaintByTexture), which is kept beside it. Errors: those of ReadMesh;
/// kInvalidInput for options that contradict each other; kDegenerate for a mesh without area or one
/// that cannot be decimated.
Result<BuiltModel> BuildModel(const std::filesystem::path& mesh_file,
                              const ModelBuildOptions& options);

/// The same for a mesh in memory that is called `name` and was taken from `source`, beside which
/// the file of its texture is, if it has one. Errors: as of BuildModel, without those of reading.
Result<BuiltModel> BuildModelFrom(const TexturedMesh& mesh, const std::string& name,
                                  const std::filesystem::path& source,
                                  const ModelBuildOptions& options);

/// Writes the mesh as PLY (and its texture) into the folder and enters it in models.json, which is
/// replaced atomically; a model of the same name is replaced, other entries and unknown keys stay.
/// Errors: kIo, kCorrupt.
Status StoreModel(const BuiltModel& built, const std::filesystem::path& folder);

}  // namespace plumbline
