// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "engine/annotation/annotation_edit.h"
#include "engine/geometry/mesh.h"
#include "engine/models/model_builder.h"

namespace plumbline {

/// The points of the scan inside the crop's region, support included, in rising order: what a
/// window paints while the region is drawn. Needs `up_in_scan` for a box.
std::vector<int> PointsInRegion(const TriangleMesh& scan, const Crop& crop);

/// The crop with up from the document and, where the support is to be left out and not given, with
/// the widest level surface in the lower third of the region, else with the document's floor.
/// Errors: kInvalidInput (neither is known; see CheckCrop).
Result<Crop> CompletedCrop(Crop crop, const TriangleMesh& scan, const AnnotationDocument& document);

/// What a complete crop holds of the scan, in the scan's frame: its points, and the triangles that
/// have all corners in it. Errors: kInvalidInput, kDegenerate (fewer than 30 points).
Result<TriangleMesh> CutOut(const TriangleMesh& scan, const Crop& crop);

/// A crop as a shape of the model database, and where it stands.
struct CroppedModel {
  BuiltModel built;
  Eigen::Isometry3d scan_from_model = Eigen::Isometry3d::Identity();
  int pieces_dropped = 0;  ///< Loose ones under a fiftieth of the largest: noise of the scan.
};

/// Cleaned, decimated and brought into the canonical frame: +z the crop's up, +x its front, the
/// origin on the support. `scan_file` names the source and where its texture is. Errors: as of
/// CutOut and BuildModel; kDegenerate for a scan without triangles.
Result<CroppedModel> ModelOfCrop(const TriangleMesh& scan, const std::filesystem::path& scan_file,
                                 const Crop& crop, int faces = 5000);

/// What accepting a crop takes: the model, if any, is staged (StageCropModel), the edit applied,
/// then the database brought in step (SyncCropModels).
struct PreparedCrop {
  EditGroup edit;
  std::optional<CroppedModel> model;
};

/// Completes the crop and, for a model, makes it. The edit, one step to undo, adds the crop and for
/// a model an instance of it where it stands; it fits the document that was given. Undoing it
/// forgets both. Nothing is written. Errors: kInvalidInput (also a crop, or
/// a model of `models_folder`, that has this name), kDegenerate.
Result<PreparedCrop> PrepareCrop(const TriangleMesh& scan, const std::filesystem::path& scan_file,
                                 Crop crop, const AnnotationDocument& document,
                                 const std::filesystem::path& models_folder);

}  // namespace plumbline
