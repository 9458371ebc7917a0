// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/bop_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr double kBopRate_hz = 30;
constexpr double kSameBopObject_m = 0.05;

struct BopImage {
  int number = 0;
  std::string name;  ///< Of the file.
  double depth_scale = 1;
  std::optional<Eigen::Isometry3d> world_from_cam;
};

fs::path BopImages(const fs::path& scene) {
  return scene / (IsThere(scene / "rgb") ? "rgb" : "gray");
}

/// Nine numbers row by row and three in millimetres.
std::optional<Eigen::Isometry3d> BopRigid(const nlohmann::json& json, const char* rotation,
                                          const char* translation) {
  if (!json.contains(rotation) || !json.contains(translation)) return std::nullopt;
  const auto r = VectorFromJson(json[rotation], 9), t = VectorFromJson(json[translation], 3);
  if (!r || !t) return std::nullopt;
  std::vector<double> rows;
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) rows.push_back((*r)[3 * i + c]);
    rows.push_back((*t)[i] / 1000);
  }
  return RigidFromRows(rows);
}

/// What scene_camera.json says of one image, or what is wrong with it.
Result<BopImage> BopImageFrom(const nlohmann::json& json, Eigen::VectorXd& k) {
  const auto bad = [](const char* what) { return Error{ErrorCode::kInvalidInput, what}; };
  if (!json.is_object()) return bad("is no object");
  if (json.contains("cam_K") && json.contains("cam_model"))
    return bad("has both cam_K and cam_model");
  if (json.contains("cam_model"))
    return Error{ErrorCode::kUnsupported, "has a cam_model, which this version does not read"};
  const auto matrix = json.contains("cam_K") ? VectorFromJson(json["cam_K"], 9) : std::nullopt;
  if (!matrix) return bad("has no cam_K of nine numbers");
  k = *matrix;
  BopImage image;
  if (json.contains("depth_scale")) {
    if (!json["depth_scale"].is_number() || !(json["depth_scale"].get<double>() > 1e-6) ||
        !(json["depth_scale"].get<double>() < 1e6))
      return bad("has a depth_scale that is no scale");
    image.depth_scale = json["depth_scale"];
  }
  if (const auto cam_from_world = BopRigid(json, "cam_R_w2c", "cam_t_w2c"))
    image.world_from_cam = cam_from_world->inverse();
  return image;
}

/// models_info.json of the data set; nothing where there is none.
nlohmann::json BopModelsInfo(const fs::path& scene) {
  fs::path whole = fs::absolute(scene).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  const fs::path dataset = whole.parent_path().parent_path();
  for (const char* folder : {"models", "models_eval"}) {
    const fs::path file = dataset / folder / "models_info.json";
    if (!IsThere(file)) continue;
    if (Result<nlohmann::json> json = ReadJson(file); json.ok() && json->is_object())
      return std::move(*json);
  }
  return nlohmann::json::object();
}

/// The model's box [m] from models_info.json.
struct BopBox {
  Eigen::Vector3d min{0, 0, 0}, size{0, 0, 0};
};
std::optional<BopBox> BopBoxOf(const nlohmann::json& info, int object) {
  const auto entry = info.find(std::to_string(object));
  if (entry == info.end() || !entry->is_object()) return std::nullopt;
  BopBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string letter(1, static_cast<char>('x' + axis));
    const auto min = entry->find("min_" + letter), size = entry->find("size_" + letter);
    if (min == entry->end() || size == entry->end() || !min->is_number() || !size->is_number())
      return std::nullopt;
    box.min[axis] = min->get<double>() / 1000;
    box.size[axis] = size->get<double>() / 1000;
  }
  if (!(box.size.minCoeff() > 0 && box.size.maxCoeff() < 100 && box.min.norm() < 100))
    return std::nullopt;
  return box;
}

struct BopView {
  int object = 0;
  double distance_m = 0;
  Eigen::Isometry3d world_from_model = Eigen::Isometry3d::Identity();
};

/// Keeps of views of one object in one place the nearest.
void MergeView(const BopView& view, std::vector<BopView>& views) {
  for (BopView& other : views) {
    if (other.object != view.object ||
        (other.world_from_model.translation() - view.world_from_model.translation()).norm() >
            kSameBopObject_m)
      continue;
    if (view.distance_m < other.distance_m) other = view;
    return;
  }
  views.push_back(view);
}

GroundTruthInstance BopInstance(const BopView& view, std::size_t number, const nlohmann::json& info,
                                const ModelFrames& models, std::vector<std::string>& warnings) {
  char name[40];
  std::snprintf(name, sizeof name, "obj_%06d", view.object);
  GroundTruthInstance instance;
  instance.model = instance.category = name;
  instance.id = instance.model + "_" + std::to_string(number);
  instance.world_from_object = view.world_from_model;
  if (const auto box = BopBoxOf(info, view.object)) {
    Eigen::Vector3d foot = box->min + 0.5 * box->size;
    foot.z() = box->min.z();
    instance.world_from_object = view.world_from_model * Eigen::Translation3d(foot);
    instance.size_m = box->size;
  }
  if (const Eigen::Isometry3d* built = FindModelFrame(models, instance.model, warnings)) {
    instance.world_from_object = view.world_from_model * built->inverse();
    if (instance.size_m) instance.size_m = (built->linear() * *instance.size_m).cwiseAbs();
  }
  return instance;
}

}  // namespace

Likeness ProbeBop(const fs::path& path) {
  return IsThere(path / "scene_camera.json") && IsThere(BopImages(path)) ? Likeness::kCertain
                                                                         : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenBop(const fs::path& folder,
                                                const SequenceOptions& options) {
  const fs::path file = folder / "scene_camera.json", image_folder = BopImages(folder);
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  if (!json->is_object())
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' is no object"};
  Recording recording;
  recording.path = folder;
  std::vector<BopImage> images;
  std::optional<Eigen::VectorXd> first_k;
  int others = 0, untold = 0;
  for (const std::string& name : NamesIn(image_folder)) {
    std::optional<int> number;
    for (const char* ending : {".png", ".jpg"}) {
      if (!number) number = NumberInName(name, "", ending);
    }
    if (!number) continue;
    const auto entry = json->find(std::to_string(*number));
    untold += entry == json->end();
    if (entry == json->end()) continue;
    Eigen::VectorXd k;
    Result<BopImage> image = BopImageFrom(*entry, k);
    if (!image.ok())
      return Error{image.error().code, "'" + file.string() + "': image " + std::to_string(*number) +
                                           " " + image.error().message};
    if (!first_k) first_k = k;
    const bool same = (k - *first_k).cwiseAbs().maxCoeff() < 1e-6;
    others += !same;
    if (!same) continue;
    image->number = *number;
    image->name = name;
    images.push_back(std::move(*image));
  }
  if (images.empty())
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' describes no image of '" + image_folder.string() + "'"};
  if (others > 0)
    recording.warnings.push_back("'" + file.string() + "' has " + std::to_string(others) +
                                 " images of another camera (cam_K) than the first; left out");
  if (untold > 0)
    recording.warnings.push_back("'" + file.string() + "' does not describe " +
                                 std::to_string(untold) + " images; left out");
  const Result<cv::Mat> first = ReadImage(image_folder / images.front().name, ImageKind::kColor);
  if (!first.ok()) return first.error();
  const Eigen::VectorXd& k = *first_k;
  const Result<Camera> camera =
      MakeCamera({first->cols, first->rows, k[0], k[4], k[2], k[5]}, kBopRate_hz, file);
  if (!camera.ok()) return camera.error();
  recording.calibration.cameras = {{"cam", *camera}};
  for (std::size_t i = 0; i < images.size(); ++i)
    recording.frames.push_back(
        {std::llround(images[i].number * (1e9 / kBopRate_hz)), i, images[i].world_from_cam});
  const cv::Size size = first->size();
  recording.read_image = [image_folder, images, size](std::size_t item) {
    return ReadImage(image_folder / images[item].name, ImageKind::kColor, size);
  };
  if (IsThere(folder / "depth")) {
    recording.read_depth = [folder, images,
                            size](std::size_t item) -> Result<std::optional<cv::Mat>> {
      const fs::path depth =
          folder / "depth" / fs::path(images[item].name).replace_extension(".png");
      if (!IsThere(depth)) return std::optional<cv::Mat>();
      Result<cv::Mat> read = DepthFromFile(depth, size, 1000 / images[item].depth_scale);
      if (!read.ok()) return read.error();
      return std::optional(std::move(*read));
    };
  }
  return MakeSequence(std::move(recording), options);
}

Result<std::optional<GroundTruth>> TruthOfBop(const Sequence& sequence, const ModelFrames& models,
                                              std::vector<std::string>& warnings) {
  const fs::path file = sequence.path() / "scene_gt.json";
  if (!IsThere(file)) return std::optional<GroundTruth>();
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json->is_object()) return bad("is no object");
  std::vector<BopView> views;
  for (int i = 0; i < sequence.num_frames(); ++i) {
    const auto pose = sequence.world_from_cam(i);
    const std::int64_t number =
        std::llround(static_cast<double>(sequence.stamp_ns(i)) * kBopRate_hz * 1e-9);
    const auto entry = json->find(std::to_string(number));
    if (!pose || entry == json->end()) continue;
    if (!entry->is_array()) return bad("has no list for image " + std::to_string(number));
    for (const nlohmann::json& object : *entry) {
      const auto cam_from_model =
          object.is_object() ? BopRigid(object, "cam_R_m2c", "cam_t_m2c") : std::nullopt;
      if (!cam_from_model || !object.contains("obj_id") || !object["obj_id"].is_number_integer() ||
          !(object["obj_id"] >= 0 && object["obj_id"] < 1000000))
        return bad("has an object without obj_id, cam_R_m2c or cam_t_m2c in image " +
                   std::to_string(number));
      MergeView({object["obj_id"].get<int>(), cam_from_model->translation().norm(),
                 *pose * *cam_from_model},
                views);
    }
  }
  if (views.empty()) {
    warnings.push_back("'" + file.string() +
                       "' tells poses in cameras whose own poses are not told (cam_R_w2c); there "
                       "is no ground truth in world");
    return std::optional<GroundTruth>();
  }
  GroundTruth truth;
  if (const auto gravity = sequence.gravity_in_world()) {
    truth.gravity_in_world = *gravity;
  } else {
    warnings.push_back("'" + sequence.path().string() +
                       "' does not tell gravity; the ground truth takes world's -z for it");
  }
  const nlohmann::json info = BopModelsInfo(sequence.path());
  for (std::size_t i = 0; i < views.size(); ++i)
    truth.instances.push_back(BopInstance(views[i], i, info, models, warnings));
  return std::optional(std::move(truth));
}

}  // namespace plumbline
