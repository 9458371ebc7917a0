// SPDX-License-Identifier: Apache-2.0
#include "tests/support/annotation_walk.h"

#include <iomanip>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include <nlohmann/json.hpp>

#include "engine/annotation/outline_model.h"
#include "engine/base/check.h"
#include "engine/sensor/camera.h"
#include "tests/engine/annotation/checked_room.h"
#include "tests/support/furniture_models.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {

void WriteAnnotationWalk(const AnnotationScene& scene, const std::filesystem::path& folder,
                         const Eigen::Isometry3d& world_from_scan) {
  constexpr int kFrames = 24;
  for (const char* part : {"color", "edges"}) std::filesystem::create_directories(folder / part);
  Camera camera;
  camera.pinhole = TestCamera();
  camera.rate_hz = 10;
  WriteText(folder / "camera.json", CameraToJson(camera).dump());
  const Eigen::Vector3d down = -9.81 * (world_from_scan.linear() * scene.up_in_scan);
  WriteText(folder / "gravity.json",
            nlohmann::json{{"gravity", {down.x(), down.y(), down.z()}}}.dump());
  const auto database = MakeFurnitureDatabase();
  const auto model =
      OutlineModel::Prepare(database->model(*database->Find("armchair")).mesh).value();
  std::ostringstream trajectory;
  trajectory << std::setprecision(17) << "# t tx ty tz qx qy qz qw\n";
  for (int i = 0; i < kFrames; ++i) {
    const double angle = 2 * std::numbers::pi * i / kFrames;
    const Eigen::Isometry3d scan_from_cam =
        scene.scan_from_armchair *
        LookAt({2.2 * std::cos(angle), 2.2 * std::sin(angle), 1.5}, {0, 0, 0.4});
    const AnnotationImage drawn = DrawnImage(i, *model, scene.scan_from_armchair, scan_from_cam);
    cv::Mat image;
    cv::cvtColor(128 - 0.4 * drawn.edges.probability, image, cv::COLOR_GRAY2BGR);
    PLB_CHECK(cv::imwrite((folder / "color" / (FrameName(i) + ".jpg")).string(), image));
    cv::imwrite((folder / "edges" / (FrameName(i) + ".png")).string(), drawn.edges.probability);
    cv::imwrite((folder / "edges" / (FrameName(i) + "_angle.png")).string(), drawn.edges.angle);
    const Eigen::Isometry3d pose = world_from_scan * scan_from_cam;
    const Eigen::Quaterniond q(pose.linear());
    trajectory << 0.1 * i << ' ' << pose.translation().transpose() << ' ' << q.x() << ' ' << q.y()
               << ' ' << q.z() << ' ' << q.w() << '\n';
  }
  WriteText(folder / "trajectory.txt", trajectory.str());
}

}  // namespace plumbline
