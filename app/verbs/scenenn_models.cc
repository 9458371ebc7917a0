// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/scenenn_models.h"

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/scenenn_sequence.h"
#include "engine/models/instance_crop.h"
#include "engine/models/mesh_file.h"
#include "engine/registration/floor.h"
#include "engine/registration/scan_target.h"

namespace plumbline {
namespace {

constexpr std::size_t kFewestTriangles = 50;  ///< Less is a scrap.

Result<FloorPlane> FloorOfScene(const Sequence& sequence, const TriangleMesh& scan) {
  FloorHints hints;
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < sequence.num_frames(); ++i) {
    const auto pose = sequence.world_from_cam(i);
    if (!pose) continue;
    poses.push_back(*pose);
    hints.camera_centers.push_back(pose->translation());
  }
  hints.up_in_scan = UpOfCameras(poses);
  const auto target = ScanTarget::Prepare(scan, hints.camera_centers);
  if (!target.ok()) return target.error();
  return FindFloor(**target, hints);
}

}  // namespace

Status CropSceneNnModels(const Sequence& sequence, const std::filesystem::path& folder,
                         std::vector<std::string>& warnings) {
  const auto annotation = SceneNnAnnotation(sequence.path());
  const auto scan_file = sequence.scene_file();
  if (ProbeSceneNn(sequence.path()) == Likeness::kNone || !annotation || !scan_file) return {};
  const Result<std::vector<SceneNnLabel>> labels = ReadSceneNnLabels(*annotation);
  if (!labels.ok()) return labels.error();
  const Result<LabelledMesh> scan = ReadLabelledMesh(*scan_file);
  if (!scan.ok()) return scan.error();
  const Result<FloorPlane> floor = FloorOfScene(sequence, scan->mesh);
  if (!floor.ok())
    return Error{floor.error().code,
                 "'" + scan_file->string() + "' shows no floor: " + floor.error().message};
  const Eigen::Vector3d& up = floor->up_in_scan;
  GroundTruth truth;
  truth.gravity_in_world = -up;
  nlohmann::json models = nlohmann::json::array();
  std::error_code ignored;
  std::filesystem::create_directories(folder / "models", ignored);
  for (const SceneNnLabel& label : *labels) {
    const auto category = CategoryOfNyu(label.nyu_class);
    if (!category) continue;
    const std::string name = label.nyu_class + "_" + std::to_string(label.id);
    const TriangleMesh crop = CropByLabel(*scan, label.id);
    if (crop.triangles.size() < kFewestTriangles) {
      warnings.push_back("'" + scan_file->string() + "' has less than 50 triangles of '" + name +
                         "'; left out");
      continue;
    }
    const UprightCrop model = UprightModel(crop, truth.gravity_in_world);
    if (Status written = WritePly(folder / "models" / (name + ".ply"), model.mesh); !written.ok())
      return written;
    models.push_back({{"name", name},
                      {"file", name + ".ply"},
                      {"category", *category},
                      {"note", "cut out of " + scan_file->filename().string()}});
    GroundTruthInstance instance;
    instance.id = instance.model = name;
    instance.category = *category;
    instance.world_from_object = model.scan_from_object;
    truth.instances.push_back(std::move(instance));
  }
  if (models.empty())
    warnings.push_back("'" + annotation->string() +
                       "' labels nothing of a category that is mapped; there are no models");
  Status status =
      WriteJson(folder / "models" / "models.json", {{"units", "m"}, {"models", models}});
  if (status.ok()) status = WriteGroundTruth(folder / "ground_truth.json", truth);
  if (status.ok())
    status =
        WriteJson(folder / "gravity.json", {{"gravity", {-up.x(), -up.y(), -up.z()}},
                                            {"floor", {up.x(), up.y(), up.z(), floor->offset_m}}});
  return status;
}

}  // namespace plumbline
