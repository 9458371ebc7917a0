// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/bop_files.h"

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <set>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/diameter.h"
#include "engine/render/renderer.h"
#include "engine/sensor/camera.h"

namespace plumbline {
namespace {

constexpr double kMillimetres = 1000;

nlohmann::json Rows(const Eigen::Matrix3d& m) {
  nlohmann::json list = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) list.push_back(m(r, c));
  }
  return list;
}

nlohmann::json InMillimetres(const Eigen::Vector3d& v) {
  return {kMillimetres * v.x(), kMillimetres * v.y(), kMillimetres * v.z()};
}

std::string Numbered(const char* format, int a, int b = 0) {
  char text[32];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, "cannot make '" + folder.string() + "': " + error.message()};
}

nlohmann::json ModelInfo(const CadModel& model) {
  const Eigen::Vector3d center = model.center(), size = model.bounds.sizes().cast<double>();
  nlohmann::json info = {{"diameter", kMillimetres * Diameter(model.mesh)}};
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    info[std::string("min_") + axes[i]] = -0.5 * kMillimetres * size[i];
    info[std::string("size_") + axes[i]] = kMillimetres * size[i];
  }
  const Symmetry& symmetry = model.symmetry;
  if (symmetry.order == 0) {
    info["symmetries_continuous"] = {
        {{"axis", {symmetry.axis.x(), symmetry.axis.y(), symmetry.axis.z()}},
         {"offset", InMillimetres(-center)}}};
  }
  for (int i = 1; i < symmetry.order; ++i) {
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    turn.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(2 * std::numbers::pi * i / symmetry.order, symmetry.axis.normalized())
            .toRotationMatrix();
    turn.topRightCorner<3, 1>() = kMillimetres * (turn.topLeftCorner<3, 3>() * center - center);
    nlohmann::json rows = nlohmann::json::array();
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) rows.push_back(turn(r, c));
    }
    info["symmetries_discrete"].push_back(rows);
  }
  return info;
}

/// Ascii, millimetres, origin in the middle of the box, with normals.
std::string PlyText(const CadModel& model) {
  TriangleMesh mesh = model.mesh;
  if (mesh.normals.empty()) ComputeNormals(mesh);
  std::string text = "ply\nformat ascii 1.0\ncomment millimetres\nelement vertex " +
                     std::to_string(mesh.vertices.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                     "property float ny\nproperty float nz\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  char line[160];
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d v = kMillimetres * (mesh.vertices[i].cast<double>() - model.center());
    const Eigen::Vector3f& n = mesh.normals[i];
    std::snprintf(line, sizeof(line), "%.6g %.6g %.6g %.5g %.5g %.5g\n", v.x(), v.y(), v.z(), n.x(),
                  n.y(), n.z());
    text += line;
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    std::snprintf(line, sizeof(line), "3 %d %d %d\n", t.x(), t.y(), t.z());
    text += line;
  }
  return text;
}

Status WriteModels(const ModelDatabase& models, const std::set<int>& used,
                   const std::filesystem::path& folder) {
  if (const Status made = MakeFolder(folder); !made.ok()) return made;
  nlohmann::json infos = nlohmann::json::object(), names = nlohmann::json::object();
  for (const int i : used) {
    const CadModel& model = models.model(ModelId{i});
    const std::string id = std::to_string(i + 1);
    infos[id] = ModelInfo(model);
    const Eigen::Vector3d center = model.center();
    names[id] = {{"name", model.name},
                 {"category", model.category},
                 {"center_m", {center.x(), center.y(), center.z()}}};
    const Status written =
        WriteFileAtomically(folder / (Numbered("obj_%06d", i + 1) + ".ply"), PlyText(model));
    if (!written.ok()) return written;
  }
  const Status written = WriteJson(folder / "models_info.json", infos);
  return written.ok() ? WriteJson(folder / "plumbline_models.json", names) : written;
}

nlohmann::json BoxOf(const cv::Mat& mask) {
  const cv::Rect box =
      cv::countNonZero(mask) > 0 ? cv::boundingRect(mask) : cv::Rect(-1, -1, -1, -1);
  return {box.x, box.y, box.width, box.height};
}

/// One image of the scene.
class BopImage {
 public:
  BopImage(const AnnotationDocument& document, const ExchangeInputs& inputs,
           const Eigen::Isometry3d& scan_from_cam)
      : camera_(inputs.sequence->camera()) {
    const Eigen::Isometry3d cam_from_scan = scan_from_cam.inverse();
    for (const AnnotatedInstance& instance : document.instances) {
      const CadModel& model = inputs.models->model(*inputs.models->Find(instance.model));
      const Eigen::Isometry3d cam_from_object = cam_from_scan * instance.scan_from_object;
      const int number = static_cast<int>(meshes_.size());
      meshes_.push_back(&model.mesh);
      instances_.push_back({number, cam_from_object, number + 1});
      truth_.push_back({{"obj_id", model.id.value + 1},
                        {"cam_R_m2c", Rows(cam_from_object.linear())},
                        {"cam_t_m2c", InMillimetres(cam_from_object * model.center())}});
    }
  }

  const nlohmann::json& truth() const { return truth_; }
  /// Place of the instance that shows + 1, CV_16U.
  cv::Mat Visible() const { return RayCast(camera_, meshes_, instances_, {}).id; }

  /// Writes the masks and returns what scene_gt_info says.
  Result<nlohmann::json> WriteMasks(const std::filesystem::path& scene, int frame) const {
    const RenderedMaps all = RayCast(camera_, meshes_, instances_, {});
    nlohmann::json infos = nlohmann::json::array();
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      const RenderedMaps alone = RayCast(camera_, meshes_, std::span(&instances_[i], 1), {});
      const cv::Mat whole = alone.id > 0, visible = all.id == instances_[i].id;
      const int all_pixels = cv::countNonZero(whole), seen = cv::countNonZero(visible);
      infos.push_back(
          {{"bbox_obj", BoxOf(whole)},
           {"bbox_visib", BoxOf(visible)},
           {"px_count_all", all_pixels},
           {"px_count_valid", all_pixels},
           {"px_count_visib", seen},
           {"visib_fract", all_pixels > 0 ? static_cast<double>(seen) / all_pixels : 0}});
      const std::string name = Numbered("%06d_%06d.png", frame, static_cast<int>(i));
      if (!cv::imwrite((scene / "mask" / name).string(), whole) ||
          !cv::imwrite((scene / "mask_visib" / name).string(), visible)) {
        return Error{ErrorCode::kIo, "cannot write the masks in '" + scene.string() + "'"};
      }
    }
    return infos;
  }

 private:
  PinholeCamera camera_;
  std::vector<const TriangleMesh*> meshes_;
  std::vector<RenderInstance> instances_;
  nlohmann::json truth_ = nlohmann::json::array();
};

nlohmann::json CameraMatrix(const PinholeCamera& c) {
  return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1};
}

Result<std::set<int>> UsedModels(const AnnotationDocument& document, const ExchangeInputs& inputs) {
  if (!inputs.sequence || !inputs.models) {
    return Error{ErrorCode::kInvalidInput,
                 "a BOP dataset needs a sequence with camera poses and a model database; name them "
                 "in the project (edit 'inputs')"};
  }
  std::set<int> used;
  for (const AnnotatedInstance& instance : document.instances) {
    const auto id = inputs.models->Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    used.insert(id->value);
  }
  return used;
}

}  // namespace

Result<cv::Mat> VisibleInstances(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 int frame) {
  const Result<std::set<int>> used = UsedModels(document, inputs);
  if (!used) return used.error();
  const auto scan_from_cam = ScanFromCam(document, *inputs.sequence, frame);
  if (!scan_from_cam) {
    return Error{ErrorCode::kNotFound,
                 "frame " + std::to_string(frame) + " of the sequence has no camera pose"};
  }
  return BopImage(document, inputs, *scan_from_cam).Visible();
}

Status WriteBop(const AnnotationDocument& document, const ExchangeInputs& inputs,
                const std::filesystem::path& folder, const WorkContext& context) {
  const Result<std::set<int>> used = UsedModels(document, inputs);
  if (!used) return used.error();
  const std::filesystem::path scene = folder / "test" / "000000";
  for (const char* part : {"rgb", "mask", "mask_visib"}) {
    if (const Status made = MakeFolder(scene / part); !made.ok()) return made;
  }
  if (const Status written = WriteModels(*inputs.models, *used, folder / "models"); !written.ok()) {
    return written;
  }
  const PinholeCamera& camera = inputs.sequence->camera();
  nlohmann::json truth = nlohmann::json::object(), cameras = nlohmann::json::object(),
                 infos = nlohmann::json::object();
  int done = 0;
  for (const int frame : inputs.frames) {
    context.report({"frames", done++, static_cast<int>(inputs.frames.size())});
    if (context.stop.stop_requested())
      return Error{ErrorCode::kCancelled, "the export was stopped"};
    const auto scan_from_cam = ScanFromCam(document, *inputs.sequence, frame);
    const Result<Frame> image = inputs.sequence->ReadFrame(frame);
    if (!scan_from_cam || !image.ok()) continue;
    const Eigen::Isometry3d cam_from_scan = scan_from_cam->inverse();
    const BopImage shown(document, inputs, *scan_from_cam);
    const std::string id = std::to_string(frame);
    truth[id] = shown.truth();
    cameras[id] = {{"cam_K", CameraMatrix(camera)},
                   {"depth_scale", 1.0},
                   {"cam_R_w2c", Rows(cam_from_scan.linear())},
                   {"cam_t_w2c", InMillimetres(cam_from_scan.translation())}};
    Result<nlohmann::json> info = shown.WriteMasks(scene, frame);
    if (!info) return info.error();
    infos[id] = std::move(*info);
    const std::filesystem::path file = scene / "rgb" / Numbered("%06d.png", frame);
    if (!cv::imwrite(file.string(), image->image)) {
      return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'"};
    }
  }
  nlohmann::json intrinsics = IntrinsicsToJson(camera);
  intrinsics["depth_scale"] = 1.0;
  Status status = WriteJson(folder / "camera.json", intrinsics);
  if (status.ok()) status = WriteJson(scene / "scene_gt.json", truth);
  if (status.ok()) status = WriteJson(scene / "scene_camera.json", cameras);
  if (status.ok()) status = WriteJson(scene / "scene_gt_info.json", infos);
  return status;
}

}  // namespace plumbline
