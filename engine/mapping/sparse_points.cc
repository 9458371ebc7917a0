// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/sparse_points.h"

#include <algorithm>
#include <array>

namespace plumbline {
namespace {

constexpr double kBeforeCamera_m = 0.1;
constexpr float kMiddle = 0.6;  ///< Of the sides of a box: near its border the background shows.
constexpr std::size_t kLeastPoints = 6;
constexpr int kCells = 6;
constexpr int kLeastInCell = 2;  ///< One point may be a wrong match.
/// Points err by a few per cent of their depth.
constexpr double kMargin_m = 0.1, kMarginOfDepth = 0.04;
constexpr float kInModel_m = 0.04;  ///< Beyond the bounds of a model that a point may lie.

}  // namespace

std::optional<DepthSpan> DepthsInside(const Box2& box,
                                      std::span<const Eigen::Vector3f> points_in_world,
                                      const PinholeCamera& camera,
                                      const Eigen::Isometry3d& cam_from_world) {
  const float dx = 0.5f * (1 - kMiddle) * box.width(), dy = 0.5f * (1 - kMiddle) * box.height();
  const Box2 middle{box.x0 + dx, box.y0 + dy, box.x1 - dx, box.y1 - dy};
  std::vector<double> depths;
  for (const Eigen::Vector3f& point : points_in_world) {
    const Eigen::Vector3d in_cam = cam_from_world * point.cast<double>();
    if (in_cam.z() < kBeforeCamera_m) continue;
    const Eigen::Vector2f pixel = camera.Project(in_cam).cast<float>();
    if (pixel.x() >= middle.x0 && pixel.x() <= middle.x1 && pixel.y() >= middle.y0 &&
        pixel.y() <= middle.y1)
      depths.push_back(in_cam.z());
  }
  if (depths.size() < kLeastPoints) return std::nullopt;
  std::sort(depths.begin(), depths.end());
  const std::size_t tenth = (depths.size() + 5) / 10;
  return DepthSpan{depths[tenth], depths[depths.size() - 1 - tenth]};
}

double ScreenedShare(const Box2& box, double depth_m,
                     std::span<const Eigen::Vector3f> points_in_world, const PinholeCamera& camera,
                     const Eigen::Isometry3d& cam_from_world, const ModelDatabase& database,
                     std::span<const PlacedModel> explained) {
  if (box.empty()) return 0;
  const double before = depth_m - std::max(kMargin_m, kMarginOfDepth * depth_m);
  std::array<int, kCells * kCells> cells{};
  for (const Eigen::Vector3f& point : points_in_world) {
    const Eigen::Vector3d in_cam = cam_from_world * point.cast<double>();
    if (in_cam.z() < kBeforeCamera_m || in_cam.z() > before) continue;
    const Eigen::Vector2f pixel = camera.Project(in_cam).cast<float>();
    const int column = static_cast<int>(kCells * (pixel.x() - box.x0) / box.width());
    const int row = static_cast<int>(kCells * (pixel.y() - box.y0) / box.height());
    if (pixel.x() < box.x0 || pixel.y() < box.y0 || column >= kCells || row >= kCells) continue;
    const bool known =
        std::any_of(explained.begin(), explained.end(), [&](const PlacedModel& placed) {
          const Eigen::AlignedBox3f& bounds = database.model(placed.label).bounds;
          const Eigen::Vector3f at =
              (placed.world_from_object.inverse() * point.cast<double>() / placed.scale)
                  .cast<float>();
          return bounds.squaredExteriorDistance(at) < kInModel_m * kInModel_m;
        });
    if (!known) ++cells[static_cast<std::size_t>(row * kCells + column)];
  }
  const auto screened =
      std::count_if(cells.begin(), cells.end(), [](int points) { return points >= kLeastInCell; });
  return static_cast<double>(screened) / (kCells * kCells);
}

}  // namespace plumbline
