// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/placement_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr std::size_t kGridSamples = 150;
constexpr double kBlur_m = 0.06;

Eigen::Vector3d AxisOf(int direction) {
  if (direction < 2) return {0, 0, direction == 0 ? 1.0 : -1.0};
  const double angle = (direction - 2) * std::numbers::pi / 4;
  return {std::cos(angle), std::sin(angle), 0};
}

}  // namespace

PlacementGrid::PlacementGrid(const AlignmentCrop& crop, const ModelSurface& model,
                             const Eigen::Isometry3d& scan_from_model,
                             const Eigen::Vector3d& up_in_scan, double search_m, FreeMotion motion)
    : model_(model),
      start_(scan_from_model),
      up_(up_in_scan),
      grid_from_scan_(UprightFrame(-up_in_scan).upright_rotation().transpose()),
      search_m_(search_m),
      motion_(motion) {
  double radius = 0, lowest = 1e30, highest = -1e30;
  for (const Eigen::Vector3f& point : model.samples().points) {
    const Eigen::Vector3d p = grid_from_scan_ * scan_from_model.linear() * point.cast<double>();
    radius = std::max(radius, p.head<2>().norm());
    lowest = std::min(lowest, p.z());
    highest = std::max(highest, p.z());
  }
  const double margin = search_m + 2 * kCell_m;
  corner_ = {-radius - margin, -radius - margin, lowest - margin};
  const Eigen::Vector3d extent(2 * (radius + margin), 2 * (radius + margin),
                               highest - lowest + 2 * margin);
  size_ = (extent / kCell_m).array().ceil().cast<int>() + 1;
  cells_.assign(static_cast<std::size_t>(size_.prod()) * kDirections, 0);
  for (std::size_t i = 0; i < crop.fine.points.size(); ++i) {
    Splat(grid_from_scan_ * (crop.fine.points[i].cast<double>() - start_.translation()),
          grid_from_scan_ * crop.fine.normals[i].cast<double>(), !crop.normals_face_out);
  }
}

void PlacementGrid::Splat(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                          bool two_sided) {
  const Eigen::Vector3d place = (point - corner_) / kCell_m;
  const Eigen::Vector3i middle = place.array().round().cast<int>();
  if ((middle.array() < 1).any() || (middle.array() >= size_.array() - 1).any()) return;
  double agreement[kDirections];
  for (int d = 0; d < kDirections; ++d) {
    const double cosine = normal.dot(AxisOf(d));
    agreement[d] = std::max(0.0, two_sided ? std::abs(cosine) : cosine);
  }
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector3i cell = middle + Eigen::Vector3i(dx, dy, dz);
        const double squared = (cell.cast<double>() - place).squaredNorm() * kCell_m * kCell_m;
        const double near = 1 - squared / (kBlur_m * kBlur_m);
        if (near <= 0) continue;
        const int index = (cell.z() * size_.y() + cell.y()) * size_.x() + cell.x();
        for (int d = 0; d < kDirections; ++d) {
          if (agreement[d] < 0.6) continue;
          std::uint8_t& value = cells_[static_cast<std::size_t>(d * size_.prod() + index)];
          value = std::max(value, static_cast<std::uint8_t>(255 * near * agreement[d]));
        }
      }
    }
  }
}

int PlacementGrid::Direction(const Eigen::Vector3d& normal) const {
  int best = 0;
  double most = -2;
  for (int d = 0; d < kDirections; ++d) {
    const double agreement = normal.dot(AxisOf(d));
    if (agreement > most) {
      most = agreement;
      best = d;
    }
  }
  return best;
}

Eigen::Isometry3d PlacementGrid::BestPlacement(double turn_rad,
                                               std::optional<double> rise_m) const {
  Eigen::Isometry3d best = start_;
  best.linear() = Eigen::AngleAxisd(turn_rad, up_) * start_.linear();
  if (motion_ == FreeMotion::kAzimuth) return best;
  if (rise_m) best.translation() += *rise_m * up_;
  const Eigen::Matrix3d grid_from_model = grid_from_scan_ * best.linear();
  const Eigen::Vector3d lift(0, 0, rise_m.value_or(0));
  std::vector<int> places;
  const auto& samples = model_.samples();
  const std::size_t step = std::max<std::size_t>(1, samples.points.size() / kGridSamples);
  for (std::size_t i = 0; i < samples.points.size(); i += step) {
    const Eigen::Vector3d p = grid_from_model * samples.points[i].cast<double>() + lift;
    const Eigen::Vector3i cell = ((p - corner_) / kCell_m).array().round().cast<int>();
    const int index = (cell.z() * size_.y() + cell.y()) * size_.x() + cell.x();
    const Eigen::Vector3d normal = grid_from_model * samples.normals[i].cast<double>();
    places.push_back(Direction(normal) * size_.prod() + index);
    if (model_.two_sided()[i]) places.push_back(Direction(-normal) * size_.prod() + index);
  }
  const int reach = static_cast<int>(search_m_ / kCell_m);
  const bool level = rise_m || motion_ == FreeMotion::kAzimuthAndHorizontal;
  const int reach_up = level ? 0 : reach;
  int most = -1;
  Eigen::Vector3i moved(0, 0, 0);
  for (int z = -reach_up; z <= reach_up; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (x * x + y * y + z * z > reach * reach) continue;
        const std::uint8_t* shifted = cells_.data() + ((z * size_.y() + y) * size_.x() + x);
        int sum = 0;
        for (const int place : places) sum += shifted[place];
        if (sum > most) {
          most = sum;
          moved = {x, y, z};
        }
      }
    }
  }
  best.translation() += grid_from_scan_.transpose() * (moved.cast<double>() * kCell_m);
  return best;
}

}  // namespace plumbline
