// SPDX-License-Identifier: Apache-2.0
#include "tests/support/drawn_sequence.h"

#include <iomanip>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "engine/models/mesh_file.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

constexpr double kRateHz = 10;

Eigen::Isometry3d CameraAt(double time_s) {
  const double angle = (-70 + 18 * time_s) * std::numbers::pi / 180;
  return LookAt({2.5 * std::cos(angle), 2.5 * std::sin(angle), 1.5 + 0.1 * std::sin(2 * time_s)},
                {0.1 * std::sin(time_s), 0, 0.45});
}

void WriteModels(const std::filesystem::path& folder) {
  nlohmann::json models;
  for (const CadModel& model : MappingScene::Get().database()->models()) {
    if (model.name != "chair" && model.name != "table") continue;
    std::filesystem::create_directories(folder);
    if (!WritePly(folder / (model.name + ".ply"), model.mesh).ok())
      throw std::runtime_error("cannot write a model");
    models.push_back({{"name", model.name},
                      {"file", model.name + ".ply"},
                      {"category", model.category},
                      {"symmetry", {{"axis", {0, 0, 1}}, {"order", model.symmetry.order}}},
                      {"support", "floor"}});
  }
  WriteText(folder / "models.json", nlohmann::json{{"units", "m"}, {"models", models}}.dump());
}

void WriteFrame(const std::filesystem::path& folder, int frame, bool boxes) {
  MappingScene& scene = MappingScene::Get();
  const std::vector<PlacedModel> objects = DrawnObjects();
  const Eigen::Isometry3d world_from_cam = CameraAt(frame / kRateHz);
  const std::string name = FrameName(frame);
  const RenderedMaps maps = scene.Draw(world_from_cam, objects);
  cv::Mat image;
  maps.depth.convertTo(image, CV_8U, 60);
  cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  cv::imwrite((folder / "color" / (name + ".jpg")).string(), image);
  const EdgeMap edges = EdgesOfContour(maps.contour);
  cv::imwrite((folder / "edges" / (name + ".png")).string(), edges.probability);
  cv::imwrite((folder / "edges" / (name + "_angle.png")).string(), edges.angle);
  nlohmann::json list = nlohmann::json::array();
  if (boxes) {
    for (const Detection& box : scene.Boxes(world_from_cam, objects)) {
      list.push_back({{"x0", box.box.x0},
                      {"y0", box.box.y0},
                      {"x1", box.box.x1},
                      {"y1", box.box.y1},
                      {"category", box.category},
                      {"score", box.score}});
    }
  }
  WriteText(folder / "proposals" / (name + ".json"),
            nlohmann::json{{{"image", name + ".jpg"}, {"boxes", list}}}.dump());
}

}  // namespace

std::vector<PlacedModel> DrawnObjects() {
  const MappingScene& scene = MappingScene::Get();
  return {scene.Place("table", 0, 0, 90, 1), scene.Place("chair", 0.85, 0.1, 180, 2),
          scene.Place("chair", -0.1, -1.15, 75, 3)};
}

void WriteDrawnSequence(const std::filesystem::path& folder, const DrawnSequenceOptions& options) {
  for (const char* part : {"color", "edges"}) std::filesystem::create_directories(folder / part);
  Camera camera;
  camera.pinhole = MappingScene::Get().camera();
  camera.rate_hz = kRateHz;
  WriteText(folder / "camera.json", CameraToJson(camera).dump());
  WriteText(folder / "gravity.json", R"({"gravity": [0, 0, -9.81], "floor": [0, 0, 1, 0]})");
  WriteModels(folder / "models");
  std::ostringstream trajectory;
  trajectory << std::setprecision(12) << "# t tx ty tz qx qy qz qw\n";
  for (int frame = 0; frame < options.frames; ++frame) {
    const Eigen::Isometry3d pose = CameraAt(frame / kRateHz);
    const Eigen::Quaterniond q(pose.linear());
    trajectory << frame / kRateHz << ' ' << pose.translation().transpose() << ' ' << q.x() << ' '
               << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
    WriteFrame(folder, frame, frame < options.boxes_until);
  }
  WriteText(folder / "trajectory.txt", trajectory.str());
}

}  // namespace plumbline
