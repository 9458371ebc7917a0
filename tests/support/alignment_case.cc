// SPDX-License-Identifier: Apache-2.0
#include "tests/support/alignment_case.h"

#include <numbers>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/random_vector.h"
#include "engine/render/renderer.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

Eigen::Isometry3d Upright(double azimuth, const Eigen::Vector3d& at) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = at;
  return pose;
}

Eigen::Isometry3d LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d z = (to - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  world_from_cam.linear() << x, z.cross(x), z;
  world_from_cam.translation() = from;
  return world_from_cam;
}

struct Placed {
  TriangleMesh mesh;
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
};

std::vector<Placed> Clutter(const ModelDatabase& models, const Eigen::AlignedBox3f& bounds,
                            double toward_cameras, Random& random) {
  std::vector<Placed> placed;
  const double radius = 0.5 * bounds.sizes().head<2>().norm();
  // Two neighbours that do not touch, and a box that does.
  double direction = random.Uniform(0, 2 * std::numbers::pi);
  for (int i = 0; i < 2; ++i, direction += random.Uniform(1.5, 3)) {
    const CadModel& other =
        models.models()[random.Index(static_cast<std::uint32_t>(models.models().size()))];
    const double distance =
        radius + 0.5 * other.bounds.sizes().head<2>().norm() + random.Uniform(0.02, 0.2);
    placed.push_back(
        {other.mesh, Upright(random.Uniform(0, 6),
                             {distance * std::cos(direction), distance * std::sin(direction), 0})});
  }
  const auto side = static_cast<float>(random.Uniform(0.15, 0.35));
  const double at = random.Uniform(0, 2 * std::numbers::pi);
  placed.push_back({MakeBox({-side / 2, -side / 2, 0}, {side / 2, side / 2, side}),
                    Upright(random.Uniform(0, 6), {(radius + 0.3 * side) * std::cos(at),
                                                   (radius + 0.3 * side) * std::sin(at), 0})});
  const double behind = radius + random.Uniform(0.3, 0.8),
               turned = toward_cameras + std::numbers::pi / 2 + random.Uniform(-0.4, 0.4);
  placed.push_back({MakeParallelogram({-3, 0, 0}, {6, 0, 0}, {0, 0, 2.5}),
                    Upright(turned, {0, 0, 0}) * Eigen::Translation3d(0, behind, 0)});
  return placed;
}

/// Points that the camera sees.
void Scan(const std::vector<Placed>& scene, const Eigen::Isometry3d& world_from_cam, double noise_m,
          Random& random, TriangleMesh& scan) {
  const PinholeCamera camera{320, 240, 300, 300, 159.5, 119.5};
  std::vector<const TriangleMesh*> meshes;
  std::vector<RenderInstance> instances;
  for (const Placed& placed : scene) {
    const int i = static_cast<int>(meshes.size());
    meshes.push_back(&placed.mesh);
    instances.push_back({i, world_from_cam.inverse() * placed.world_from_object, i + 1});
  }
  const RenderedMaps maps = RayCast(camera, meshes, instances, {});
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double depth = maps.depth.at<float>(y, x);
      if (depth <= 0 || depth > 5) continue;
      const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const Eigen::Vector3d noise = noise_m * GaussianVector<3>(random);
      scan.vertices.push_back((world_from_cam * (depth * ray) + noise).cast<float>());
    }
  }
}

}  // namespace

AlignmentCase MakeAlignmentCase(const ModelDatabase& models, ModelId model, std::uint64_t seed,
                                const AlignmentCaseOptions& options) {
  Random random({.seed = seed, .object = static_cast<std::uint32_t>(model.value)});
  const CadModel& shape = models.model(model);
  const Eigen::Isometry3d world_from_model =
      Upright(random.Uniform(-std::numbers::pi, std::numbers::pi), {0, 0, 0});
  std::vector<Placed> scene{
      {shape.mesh, world_from_model},
      {MakeParallelogram({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), Eigen::Isometry3d::Identity()}};
  constexpr double kBetweenCameras = std::numbers::pi / 3;
  double direction = random.Uniform(0, 2 * std::numbers::pi);
  if (options.under_table) {
    const double azimuth =
        std::atan2(world_from_model.linear()(1, 0), world_from_model.linear()(0, 0));
    constexpr double kTableAway_m = 0.3;  // Its edge is over the seat.
    const CadModel& table = models.model(*models.Find("table"));
    scene.push_back(
        {table.mesh, world_from_model * Upright(std::numbers::pi / 2, {kTableAway_m, 0, 0})});
    direction = azimuth + random.Uniform(-0.3, 0.3) - 0.5 * kBetweenCameras;
  } else if (options.clutter) {
    const double middle = direction + 0.5 * kBetweenCameras * (options.cameras - 1);
    for (Placed& placed : Clutter(models, shape.bounds, middle, random)) {
      scene.push_back(std::move(placed));
    }
  }
  AlignmentCase result;
  for (int i = 0; i < options.cameras; ++i, direction += kBetweenCameras) {
    const Eigen::Vector3d from(1.8 * std::cos(direction), 1.8 * std::sin(direction),
                               random.Uniform(1.2, 1.7));
    result.camera_centers.push_back(from);
    Scan(scene, LookAt(from, {0, 0, 0.4}), options.noise_m, random, result.scan);
  }
  Eigen::Isometry3d scan_from_world = Eigen::Isometry3d::Identity();
  if (options.tilted_scan) {
    const Eigen::Vector4d q = GaussianVector<4>(random);
    scan_from_world.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    const double y = random.Uniform(-3, 3), x = random.Uniform(-3, 3);
    scan_from_world.translation() = Eigen::Vector3d(x, y, 1);
  }
  const double turn = random.Uniform(-options.azimuth_rad, options.azimuth_rad);
  Eigen::Vector3d offset;
  do {
    offset = {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)};
  } while (offset.norm() > 1);
  Eigen::Isometry3d start = Upright(turn, {0, 0, 0}) * world_from_model;
  start.translation() = options.offset_m * offset;
  for (Eigen::Vector3d& center : result.camera_centers) center = scan_from_world * center;
  result.scan = Transformed(std::move(result.scan), scan_from_world);
  result.scan_from_model = scan_from_world * world_from_model;
  result.start = scan_from_world * start;
  result.up_in_scan = scan_from_world.linear().col(2);
  return result;
}

}  // namespace plumbline
