// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/annotation/annotation_document.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// What a foreign format needs besides the document. Pointers may be null where a format can do
/// without; those that cannot say so.
struct ExchangeInputs {
  const ModelDatabase* models = nullptr;
  const Sequence* sequence = nullptr;
  std::vector<int> frames;  ///< Of the sequence.
  const TriangleMesh* scan = nullptr;
};

/// Poses read from a foreign format, in the frame of the scan.
struct ImportedPoses {
  std::vector<AnnotatedInstance> instances;
  std::optional<Eigen::Vector3d> gravity_in_scan;
  std::optional<Eigen::Isometry3d> scan_from_world;
  std::vector<std::string> warnings;
};

/// Where a frame's camera is in the scan; nothing for a frame without a pose.
std::optional<Eigen::Isometry3d> ScanFromCam(const AnnotationDocument& document,
                                             const Sequence& sequence, int frame);

/// A sentence if translations in metres look like millimetres: most are larger than 50 m.
std::optional<std::string> MetreWarning(const std::vector<Eigen::Vector3d>& translations,
                                        const std::string& file);

/// ground_truth.json. `frame`: in which frame the poses are written.
enum class PoseFrame { kScan, kLevel, kWorld };
Eigen::Isometry3d TargetFromScan(const AnnotationDocument& document, PoseFrame frame);
GroundTruth GroundTruthOf(const AnnotationDocument& document, PoseFrame frame);
Status WriteGroundTruthOf(const AnnotationDocument& document, PoseFrame frame,
                          const std::filesystem::path& file);
Result<ImportedPoses> ReadGroundTruthPoses(const std::filesystem::path& file);

/// A folder as VISMA has one for each sequence: fragments/objects.json (instances, and fragments
/// that wait for one), fragments/alignment.json (12 numbers, row-major 3x4, model to scan, metres),
/// result_alignment.json (T_ef_corvis: sequence to scan; the identity where both share a frame),
/// and the models as VISMA holds them, +y up, in CAD/. Poses are those of these y-up models: y-up
/// (x, y, z) is our (x, -z, y).
Status WriteVisma(const AnnotationDocument& document, const ModelDatabase* models,
                  const std::filesystem::path& folder);
/// @param folder  Such a folder, or its folder of fragments alone.
Result<ImportedPoses> ReadVisma(const std::filesystem::path& folder);
/// What VISMA's folder holds of the scan: test.klg.ply (the scan), `fragments/<name>_<N>.ply`, the
/// scan's points within `reach_m` of each posed model, floor.ply where the floor is known, and
/// augmented_scene.ply, the scan's points in its colours together with points sampled on the posed
/// models; all in the scan's frame. A crop into a fragment is written as it was cut, also in place
/// of what lies near a model of its name.
Status WriteVismaScene(const AnnotationDocument& document, const ModelDatabase& models,
                       const TriangleMesh& scan, double reach_m,
                       const std::filesystem::path& folder);

/// A folder with LabelFusion's registration_result.yaml (name to {filename, pose [[x, y, z],
/// [qw, qx, qy, qz]]}, model to the camera of the sequence's first frame with a pose, metres),
/// object_data.yaml (name to {mesh, label}: each instance is an object of its own), the meshes in
/// object-meshes/, and posegraph.posegraph with the cameras. Names have letters, digits and _
/// alone; `id` and `model` keep ours. Errors: kInvalidInput (no sequence, no models, an unknown
/// model, a name that ends in .yaml), kIo.
Status WriteLabelFusion(const AnnotationDocument& document, const ExchangeInputs& inputs,
                        const std::filesystem::path& folder);
/// @param file  registration_result.yaml, or its folder.
Result<ImportedPoses> ReadLabelFusion(const AnnotationDocument& document,
                                      const ExchangeInputs& inputs,
                                      const std::filesystem::path& file);

/// Our own per-frame poses, one JSON file. Errors: kInvalidInput without a sequence.
Status WriteFramePoses(const AnnotationDocument& document, const ExchangeInputs& inputs,
                       const std::filesystem::path& file);
/// One instance per id; frames that disagree by more than a millimetre are a warning.
Result<ImportedPoses> ReadFramePoses(const AnnotationDocument& document,
                                     const ExchangeInputs& inputs,
                                     const std::filesystem::path& file);

}  // namespace plumbline
