// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_export.h"

#include <utility>

#include "engine/annotation/bop_files.h"
#include "engine/annotation/scaled_models.h"
#include "engine/models/mesh_file.h"

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

/// VISMA's folder, with its scene where there are both scan and models.
Status WriteVismaFolder(const AnnotationDocument& document, const ModelDatabase* models,
                        const std::filesystem::path& scan_file,
                        const Eigen::Isometry3d& target_from_scan,
                        const std::filesystem::path& folder) {
  const Status written = WriteVisma(document, models, folder);
  if (!written.ok() || !models || scan_file.empty()) return written;
  Result<TriangleMesh> scan = ReadMesh(scan_file);
  if (!scan) return scan.error();
  const bool moves = target_from_scan.matrix() != Eigen::Matrix4d::Identity();
  if (moves) *scan = Transformed(std::move(*scan), target_from_scan);
  return WriteVismaScene(document, *models, *scan, kFragmentReach_m, folder);
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
  if (request.format == "labelfusion") return WriteLabelFusion(document, inputs, request.out);
  if (request.format == "poses") return WriteFramePoses(document, inputs, request.out);
  if (request.format != "visma" && request.format != "bop") {
    return InvalidInput("there is no format '" + request.format + "'");
  }
  if (request.frame == PoseFrame::kWorld) {
    return InvalidInput(
        "'" + request.format +
        "' is written in the frame of the scan, or of the level scan, and not in that "
        "of the sequence");
  }
  const bool level = request.frame == PoseFrame::kLevel;
  const Eigen::Isometry3d target_from_scan =
      level ? document.LevelFromScan() : Eigen::Isometry3d::Identity();
  // Their poses are rigid: what is scaled is an object of its own, with its own model.
  const UnscaledAnnotations sized =
      WithScaledModels(level ? InFrame(document, target_from_scan) : document, inputs.models);
  ExchangeInputs as_written = inputs;
  if (sized.models != nullptr) as_written.models = sized.models.get();
  if (request.format == "bop") return WriteBop(sized.document, as_written, request.out, work);
  return WriteVismaFolder(sized.document, as_written.models, scan_file, target_from_scan,
                          request.out);
}

}  // namespace plumbline
