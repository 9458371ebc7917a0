// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/scan2cad_files.h"

#include <cctype>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "engine/annotation/y_up_models.h"
#include "engine/base/files.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

nlohmann::json Triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Translation, rotation (w first) and scale, applied from right to left.
nlohmann::json TrsOf(const Eigen::Isometry3d& pose, double scale) {
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  return {{"translation", Triple(pose.translation())},
          {"rotation", {q.w(), q.x(), q.y(), q.z()}},
          {"scale", Triple(Eigen::Vector3d::Constant(scale))}};
}

/// The nearest that Scan2CAD has a word for: never more symmetric than it is.
const char* SymmetryName(const Symmetry& symmetry) {
  const bool upright = std::abs(symmetry.axis.normalized().z()) > 0.999;
  if (!upright || symmetry.order % 2 == 1) return "__SYM_NONE";
  if (symmetry.order == 0) return "__SYM_ROTATE_UP_INF";
  return symmetry.order % 4 == 0 ? "__SYM_ROTATE_UP_4" : "__SYM_ROTATE_UP_2";
}

/// A name of a folder: letters, digits, - and _.
std::string FolderName(std::string name) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
  }
  return name.empty() || name.front() == '.' ? "_" + name : name;
}

Status MakeParent(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (!error) return {};
  return Error{ErrorCode::kIo,
               "cannot make '" + file.parent_path().string() + "': " + error.message()};
}

nlohmann::json AlignedModel(const AnnotatedInstance& instance, const CadModel& model,
                            const Eigen::Isometry3d& world_from_scan) {
  const Eigen::Isometry3d y_up_from_object = ObjectFromYUp().inverse();
  const Eigen::Vector3d half = 0.5 * model.bounds.sizes().cast<double>();
  const nlohmann::json no_points = {{"n_keypoints", 0}, {"position", nlohmann::json::array()}};
  return {
      {"catid_cad", FolderName(instance.category)},
      {"id_cad", FolderName(instance.model)},
      {"sym", SymmetryName(model.symmetry)},
      // In the model's own frame; `bbox` is half of its size.
      {"center", Triple(y_up_from_object * model.center())},
      {"bbox", Triple({half.x(), half.z(), half.y()})},
      {"trs", TrsOf(world_from_scan * instance.scan_from_object * ObjectFromYUp(), instance.scale)},
      {"keypoints_scan", no_points},
      {"keypoints_cad", no_points},
      {"instance", instance.id},
      {"quality", instance.fine ? "fine" : "coarse"}};
}

}  // namespace

Status WriteScan2Cad(const AnnotationDocument& document, const ModelDatabase* models,
                     const TriangleMesh* scan, const std::string& id_scan,
                     const std::filesystem::path& folder) {
  if (models == nullptr) {
    return Error{ErrorCode::kInvalidInput,
                 "Scan2CAD's format needs a model database; name it in the project (edit "
                 "'inputs')"};
  }
  const Eigen::Isometry3d world_from_scan = ObjectFromYUp().inverse() * document.LevelFromScan();
  nlohmann::json aligned = nlohmann::json::array();
  std::map<std::string, int> appearances;
  Status status;
  for (const AnnotatedInstance& instance : document.instances) {
    const auto id = models->Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    const CadModel& model = models->model(*id);
    aligned.push_back(AlignedModel(instance, model, world_from_scan));
    const std::string category = aligned.back()["catid_cad"], name = aligned.back()["id_cad"];
    if (appearances[category + "_" + name]++ > 0) continue;
    const std::filesystem::path file =
        folder / "shapenet" / category / name / "models" / "model_normalized.obj";
    status = MakeParent(file);
    if (status.ok()) status = WriteFileAtomically(file, YUpObj(model.mesh));
    if (!status.ok()) return status;
  }
  if (scan != nullptr) {
    const std::filesystem::path file =
        folder / "scannet" / FolderName(id_scan) / (FolderName(id_scan) + "_vh_clean_2.ply");
    status = MakeParent(file);
    if (status.ok()) status = WritePly(file, *scan);
  } else {
    status = MakeParent(folder / "full_annotations.json");
  }
  if (status.ok()) {
    status = WriteJson(folder / "cad_appearances.json", {{FolderName(id_scan), appearances}});
  }
  if (!status.ok()) return status;
  const nlohmann::json annotation = {{"id_scan", FolderName(id_scan)},
                                     {"trs", TrsOf(world_from_scan, 1)},
                                     {"n_aligned_models", aligned.size()},
                                     {"aligned_models", std::move(aligned)}};
  return WriteJson(folder / "full_annotations.json", nlohmann::json::array({annotation}));
}

}  // namespace plumbline
