// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/bop_files.h"

#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/annotation/bop_models.h"
#include "engine/annotation/instance_masks.h"
#include "engine/base/files.h"
#include "engine/sensor/camera.h"

namespace plumbline {
namespace {

/// BOP evaluates what shows at least this much.
constexpr double kLeastVisible = 0.1;

nlohmann::json Rows(const Eigen::Matrix3d& m) {
  nlohmann::json list = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) list.push_back(m(r, c));
  }
  return list;
}

Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, "cannot make '" + folder.string() + "': " + error.message()};
}

Status WriteImage(const std::filesystem::path& file, const cv::Mat& image) {
  if (cv::imwrite(file.string(), image)) return {};
  return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'"};
}

/// As bop_toolkit has boxes: width and height are those between the outermost pixels' centres.
nlohmann::json BoxToJson(const cv::Rect& box) {
  if (box.empty()) return {-1, -1, -1, -1};
  return {box.x, box.y, box.width - 1, box.height - 1};
}

/// An entry of scene_gt_info.
nlohmann::json InfoOf(const InstanceMask& mask) {
  const int seen = cv::countNonZero(mask.visible);
  const cv::Rect none;
  return {{"bbox_obj", BoxToJson(seen > 0 ? mask.box_all : none)},
          {"bbox_visib", BoxToJson(seen > 0 ? cv::boundingRect(mask.visible) : none)},
          {"px_count_all", mask.px_all},
          {"px_count_valid", mask.px_valid},
          {"px_count_visib", seen},
          {"visib_fract", mask.px_all > 0 ? static_cast<double>(seen) / mask.px_all : 0.0}};
}

/// The scene as it grows, image by image.
class BopScene {
 public:
  BopScene(const AnnotationDocument& document, const ExchangeInputs& inputs,
           std::filesystem::path folder)
      : document_(document), inputs_(inputs), folder_(std::move(folder)) {}

  /// Frames without a pose or a readable image are left out. Errors: kIo, kCorrupt.
  Status Add(int frame) {
    const auto scan_from_cam = ScanFromCam(document_, *inputs_.sequence, frame);
    const Result<Frame> image = inputs_.sequence->ReadFrame(frame);
    if (!scan_from_cam || !image.ok()) return {};
    const Result<cv::Mat> depth = DepthOrNothing(*inputs_.sequence, frame);
    if (!depth) return depth.error();
    const std::string id = std::to_string(frame);
    AddPoses(id, scan_from_cam->inverse());
    const std::string name = fmt::format("{:06d}.png", frame);
    Status status = WriteImage(folder_ / "rgb" / name, image->image);
    if (status.ok() && !depth->empty()) {
      status = MakeFolder(folder_ / "depth");
      if (status.ok()) status = WriteImage(folder_ / "depth" / name, *depth);
    }
    const FrameMasks masks = MasksOfFrame(document_, *inputs_.models, inputs_.sequence->camera(),
                                          *scan_from_cam, *depth);
    infos_[id] = nlohmann::json::array();
    std::map<int, int> shown;  // of each model
    for (std::size_t i = 0; status.ok() && i < masks.instances.size(); ++i) {
      const InstanceMask& mask = masks.instances[i];
      infos_[id].push_back(InfoOf(mask));
      const int obj_id = truth_[id][i]["obj_id"];
      if (infos_[id].back()["visib_fract"].get<double>() >= kLeastVisible) ++shown[obj_id];
      const std::string mask_name = fmt::format("{:06d}_{:06d}.png", frame, i);
      status = WriteImage(folder_ / "mask" / mask_name, mask.mask);
      if (status.ok()) status = WriteImage(folder_ / "mask_visib" / mask_name, mask.visible);
    }
    for (const auto& [obj_id, count] : shown) {
      targets_.push_back(
          {{"scene_id", 0}, {"im_id", frame}, {"obj_id", obj_id}, {"inst_count", count}});
    }
    return status;
  }

  Status WriteTables(const std::filesystem::path& dataset) const {
    Status status = WriteJson(folder_ / "scene_gt.json", truth_);
    if (status.ok()) status = WriteJson(folder_ / "scene_camera.json", cameras_);
    if (status.ok()) status = WriteJson(folder_ / "scene_gt_info.json", infos_);
    return status.ok() ? WriteJson(dataset / "test_targets_bop19.json", targets_) : status;
  }

 private:
  void AddPoses(const std::string& id, const Eigen::Isometry3d& cam_from_scan) {
    const PinholeCamera& c = inputs_.sequence->camera();
    cameras_[id] = {{"cam_K", {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}},
                    {"depth_scale", 1.0},
                    {"cam_R_w2c", Rows(cam_from_scan.linear())},
                    {"cam_t_w2c", BopVector(cam_from_scan.translation())}};
    truth_[id] = nlohmann::json::array();
    for (const AnnotatedInstance& instance : document_.instances) {
      const CadModel& model = inputs_.models->model(*inputs_.models->Find(instance.model));
      const Eigen::Isometry3d cam_from_object = cam_from_scan * instance.scan_from_object;
      truth_[id].push_back({{"obj_id", model.id.value + 1},
                            {"cam_R_m2c", Rows(cam_from_object.linear())},
                            {"cam_t_m2c", BopVector(cam_from_object * model.center())}});
    }
  }

  const AnnotationDocument& document_;
  const ExchangeInputs& inputs_;
  std::filesystem::path folder_;
  nlohmann::json truth_ = nlohmann::json::object(), cameras_ = nlohmann::json::object(),
                 infos_ = nlohmann::json::object(), targets_ = nlohmann::json::array();
};

}  // namespace

Status WriteBop(const AnnotationDocument& document, const ExchangeInputs& inputs,
                const std::filesystem::path& folder, const WorkContext& context) {
  const Result<std::set<int>> used = UsedModels(document, inputs, "a BOP dataset");
  if (!used) return used.error();
  const std::filesystem::path scene_folder = folder / "test" / "000000";
  for (const char* part : {"rgb", "mask", "mask_visib"}) {
    if (const Status made = MakeFolder(scene_folder / part); !made.ok()) return made;
  }
  Status status = WriteBopModels(*inputs.models, *used, folder / "models");
  BopScene scene(document, inputs, scene_folder);
  int done = 0;
  for (const int frame : inputs.frames) {
    if (!status.ok()) return status;
    context.report({"frames", done++, static_cast<int>(inputs.frames.size())});
    if (context.stop.stop_requested())
      return Error{ErrorCode::kCancelled, "the export was stopped"};
    status = scene.Add(frame);
  }
  if (status.ok()) status = scene.WriteTables(folder);
  nlohmann::json intrinsics = IntrinsicsToJson(inputs.sequence->camera());
  intrinsics["depth_scale"] = 1.0;
  return status.ok() ? WriteJson(folder / "camera.json", intrinsics) : status;
}

}  // namespace plumbline
