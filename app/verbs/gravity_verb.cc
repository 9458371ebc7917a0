// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/verbs/vector_argument.h"
#include "app/verbs/verb.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/trajectory.h"
#include "engine/models/mesh_file.h"
#include "engine/registration/floor.h"

namespace plumbline {
namespace {

struct GravityArguments {
  std::string scan, near, up, trajectory, json;
  FloorOptions options;
};

Result<FloorHints> ReadHints(const GravityArguments& arguments) {
  FloorHints hints;
  if (!arguments.trajectory.empty()) {
    const Result<Trajectory> trajectory = ReadTrajectory(arguments.trajectory, std::nullopt);
    if (!trajectory) return trajectory.error();
    std::vector<Eigen::Isometry3d> poses;
    for (const StampedPose& pose : trajectory->poses) {
      poses.push_back(pose.world_from_cam);
      hints.camera_centers.push_back(pose.world_from_cam.translation());
    }
    hints.up_in_scan = UpOfCameras(poses);
  }
  if (!arguments.up.empty()) {
    const Result<Eigen::Vector3d> up = ParseDirection(arguments.up, "--up");
    if (!up) return up.error();
    hints.up_in_scan = *up;
  }
  return hints;
}

nlohmann::json ToJson(const FloorPlane& floor) {
  const Eigen::Vector3d& up = floor.up_in_scan;
  return {{"gravity", {-up.x(), -up.y(), -up.z()}},
          {"floor", {up.x(), up.y(), up.z(), floor.offset_m}},
          {"world_from_scan", IsometryToJson(floor.WorldFromScan())},
          {"inliers", floor.inliers.size()},
          {"rmse_m", floor.rmse_m},
          {"guessed", floor.guessed},
          {"rival", floor.rival},
          {"normal_std_deg", floor.normal_std_rad * 180 / std::numbers::pi}};
}

Status FindGravity(const GravityArguments& arguments) {
  const Result<FloorHints> hints = ReadHints(arguments);
  if (!hints) return hints.error();
  std::optional<Eigen::Vector3d> seed;
  if (!arguments.near.empty()) {
    const Result<Eigen::VectorXd> near = ParseNumbers(arguments.near, "--near", 3, 3);
    if (!near) return near.error();
    seed = *near;
  }
  const Result<TriangleMesh> scan = ReadMesh(arguments.scan);
  if (!scan) return scan.error();
  const auto target = ScanTarget::Prepare(*scan, hints->camera_centers);
  if (!target) return Error{target.error().code, arguments.scan + ": " + target.error().message};
  const Result<FloorPlane> floor = seed ? FitFloorFrom(**target, *seed, *hints, arguments.options)
                                        : FindFloor(**target, *hints, arguments.options);
  if (!floor) return Error{floor.error().code, arguments.scan + ": " + floor.error().message};
  if (arguments.json != "-") {
    const Eigen::Vector3d gravity = -floor->up_in_scan;
    std::printf("gravity %.6f,%.6f,%.6f   floor at %.4f m along up   %zu points, %.1f mm rms\n",
                gravity.x(), gravity.y(), gravity.z(), -floor->offset_m, floor->inliers.size(),
                1e3 * floor->rmse_m);
    if (floor->guessed) {
      std::printf(
          "Guessed from the surfaces alone (evidence for another direction: %.0f %%): look "
          "at it, or give --near, --up or --trajectory.\n",
          100 * floor->rival);
    }
  }
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, ToJson(*floor));
}

}  // namespace

void AddGravityVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<GravityArguments>();
  CLI::App* verb =
      app.add_subcommand("gravity", "Find the floor of a scan and the direction of gravity");
  verb->add_option("scan", arguments->scan, "The scan, metres: a mesh or a point cloud")
      ->required()
      ->type_name("SCAN.ply");
  verb->add_option("--near", arguments->near,
                   "A point on the floor to grow it from; without one the widest plane with the "
                   "scene on one side is taken, to which the other surfaces stand square")
      ->type_name("x,y,z");
  verb->add_option("--trajectory", arguments->trajectory,
                   "Camera poses in the scan's frame (TUM): cameras are above the floor and held "
                   "roughly upright")
      ->type_name("FILE");
  verb->add_option("--up", arguments->up, "Approximate direction of up, within 45 degrees")
      ->type_name("x,y,z");
  verb->add_option("--thickness", arguments->options.thickness_m,
                   "Points within this of the plane belong to it [m]")
      ->check(CLI::Range(0.002, 0.2))
      ->capture_default_str();
  verb->add_option("--json", arguments->json, "Write the results as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback(
      [arguments, &chosen] { chosen = [arguments] { return FindGravity(*arguments); }; });
}

}  // namespace plumbline
