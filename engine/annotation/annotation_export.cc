// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_export.h"

#include <utility>

#include "engine/annotation/bop_files.h"
#include "engine/annotation/coco_files.h"
#include "engine/annotation/scaled_models.h"
#include "engine/annotation/scan2cad_files.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_texture.h"

namespace plumbline {
namespace {

/// How near a model the points of its fragment are.
constexpr double kFragmentReach_m = 0.03;

Eigen::Vector4d Moved(const Eigen::Vector4d& plane, const Eigen::Isometry3d& to_from_from) {
  const Eigen::Vector3d normal = to_from_from.linear() * plane.head<3>();
  Eigen::Vector4d moved;
  moved << normal, plane[3] - normal.dot(to_from_from.translation());
  return moved;
}

void Move(Crop& crop, const Eigen::Isometry3d& to_from_from) {
  if (auto* box = std::get_if<CropBox>(&crop.region)) {
    box->center_in_scan = to_from_from * box->center_in_scan;
  } else {
    auto& lasso = std::get<CropLasso>(crop.region);
    lasso.scan_from_cam = to_from_from * lasso.scan_from_cam;
  }
  if (crop.up_in_scan) crop.up_in_scan = to_from_from.linear() * *crop.up_in_scan;
  if (crop.support_in_scan) crop.support_in_scan = Moved(*crop.support_in_scan, to_from_from);
}

/// The scan, in the frame that is written. Errors: of ReadMesh.
Result<TriangleMesh> ScanIn(const std::filesystem::path& scan_file,
                            const Eigen::Isometry3d& target_from_scan) {
  Result<TriangleMesh> scan = ReadMesh(scan_file);
  const bool moves = target_from_scan.matrix() != Eigen::Matrix4d::Identity();
  if (scan.ok() && moves) *scan = Transformed(std::move(*scan), target_from_scan);
  return scan;
}

/// VISMA's folder, with its scene where there are both scan and models.
Status WriteVismaFolder(const AnnotationDocument& document, const ModelDatabase* models,
                        const std::filesystem::path& scan_file,
                        const Eigen::Isometry3d& target_from_scan,
                        const std::filesystem::path& folder) {
  const Status written = WriteVisma(document, models, folder);
  if (!written.ok() || !models || scan_file.empty()) return written;
  const Result<TriangleMesh> scan = ScanIn(scan_file, target_from_scan);
  if (!scan) return scan.error();
  return WriteVismaScene(document, *models, *scan, kFragmentReach_m, folder);
}

Status WriteScan2CadFolder(const AnnotationDocument& document, const ExchangeInputs& inputs,
                           const std::filesystem::path& scan_file,
                           const std::filesystem::path& folder) {
  if (scan_file.empty()) {
    const std::string name = inputs.sequence ? inputs.sequence->path().filename().string() : "";
    return WriteScan2Cad(document, inputs.models, nullptr, name.empty() ? "room" : name, folder);
  }
  const Result<TriangleMesh> scan = ReadMesh(scan_file);
  if (!scan) return scan.error();
  return WriteScan2Cad(document, inputs.models, &*scan, scan_file.stem().string(), folder);
}

/// The room turned z up about the scan's origin, or with its floor at 0.
Status WriteRoom(const AnnotationDocument& document, const ModelDatabase* models,
                 const ExportRequest& request) {
  if (models == nullptr) {
    return InvalidInput(
        "glTF holds the models: the project needs a model database (edit "
        "'inputs')");
  }
  Eigen::Isometry3d room_from_scan = document.LevelFromScan();
  if (request.frame != PoseFrame::kLevel) room_from_scan.translation().setZero();
  std::vector<GltfObject> objects;
  for (const AnnotatedInstance& instance : document.instances) {
    const auto id = models->Find(instance.model);
    if (!id) {
      return InvalidInput("the model '" + instance.model + "' of '" + instance.id +
                          "' is not in the database");
    }
    const CadModel& model = models->model(*id);
    GltfObject object{instance.id,
                      &model,
                      room_from_scan * instance.scan_from_object,
                      instance.scale,
                      TextureOf(*models, model),
                      {}};
    object.extras["quality"] = instance.fine ? "fine" : "coarse";
    if (!instance.note.empty()) object.extras["note"] = instance.note;
    objects.push_back(std::move(object));
  }
  return WriteGltf(request.out, objects, request.up);
}

}  // namespace

AnnotationDocument InFrame(const AnnotationDocument& document,
                           const Eigen::Isometry3d& target_from_scan) {
  AnnotationDocument moved = document;
  moved.gravity_in_scan = target_from_scan.linear() * document.gravity_in_scan;
  if (moved.floor_in_scan) moved.floor_in_scan = Moved(*moved.floor_in_scan, target_from_scan);
  // What shared the scan's frame does not any more.
  moved.scan_from_world =
      target_from_scan * document.scan_from_world.value_or(Eigen::Isometry3d::Identity());
  for (AnnotatedInstance& instance : moved.instances) {
    instance.scan_from_object = target_from_scan * instance.scan_from_object;
  }
  for (AcceptedFinding& accepted : moved.accepted) {
    for (AcceptedFinding::Object& object : accepted.objects) {
      object.scan_from_object = target_from_scan * object.scan_from_object;
    }
  }
  for (Crop& crop : moved.crops) Move(crop, target_from_scan);
  for (FramePick& pair : moved.pairs) pair.in_scan = target_from_scan * pair.in_scan;
  return moved;
}

Status ExportAnnotation(const AnnotationDocument& document, const ExchangeInputs& inputs,
                        const std::filesystem::path& scan_file, const ExportRequest& request,
                        const WorkContext& work) {
  if (request.out.empty()) return InvalidInput("an export needs the name of a file or a folder");
  std::error_code ignored;  // a folder that cannot be made is found out when the file is written
  if (request.out.has_parent_path()) {
    std::filesystem::create_directories(request.out.parent_path(), ignored);
  }
  if (request.format == "ground_truth") {
    GroundTruth truth = GroundTruthOf(document, request.frame);
    for (GroundTruthInstance& instance : truth.instances) {
      const auto known = request.deviations.find(instance.id);
      if (known == request.deviations.end()) continue;
      instance.position_std_m = known->second.position_std_m;
      instance.azimuth_std_rad = known->second.azimuth_std_rad;
    }
    return WriteGroundTruth(request.out, truth);
  }
  if (request.format == "poses") return WriteFramePoses(document, inputs, request.out);
  if (request.format == "coco") return WriteCoco(document, inputs, request.out, work);
  if (request.format == "scan2cad") {
    return WriteScan2CadFolder(document, inputs, scan_file, request.out);
  }
  const bool known = request.format == "gltf" || request.format == "labelfusion" ||
                     request.format == "visma" || request.format == "bop";
  if (!known) return InvalidInput("there is no format '" + request.format + "'");
  if (request.frame == PoseFrame::kWorld) {
    return InvalidInput(
        "'" + request.format +
        "' is written in the frame of the scan, or of the level scan, and not in that "
        "of the sequence");
  }
  if (request.format == "gltf") return WriteRoom(document, inputs.models, request);
  const bool level = request.frame == PoseFrame::kLevel;
  const Eigen::Isometry3d target_from_scan =
      level ? document.LevelFromScan() : Eigen::Isometry3d::Identity();
  // Their poses are rigid: what is scaled is an object of its own, with its own model.
  const UnscaledAnnotations sized =
      WithScaledModels(level ? InFrame(document, target_from_scan) : document, inputs.models);
  ExchangeInputs as_written = inputs;
  if (sized.models != nullptr) as_written.models = sized.models.get();
  if (request.format == "bop") return WriteBop(sized.document, as_written, request.out, work);
  if (request.format == "labelfusion")
    return WriteLabelFusion(sized.document, as_written, request.out);
  return WriteVismaFolder(sized.document, as_written.models, scan_file, target_from_scan,
                          request.out);
}

}  // namespace plumbline
