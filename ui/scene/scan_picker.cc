// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/scan_picker.h"

#include <cmath>
#include <limits>
#include <utility>

#include <vtkCellArray.h>
#include <vtkGenericCell.h>
#include <vtkPoints.h>

namespace plumbline {
namespace {
using Eigen::Vector3d;
constexpr double kFarthest_m = 200, kStep_m = 1e-4;
constexpr int kMostHits = 100;
}  // namespace

ScanPicker::ScanPicker(std::shared_ptr<const TriangleMesh> scan, int side)
    : scan_(std::move(scan)), side_(side) {
  if (scan_->triangles.empty()) return;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  for (const Eigen::Vector3f& v : scan_->vertices) points->InsertNextPoint(v.data());
  vtkNew<vtkCellArray> cells;
  for (const Eigen::Vector3i& t : scan_->triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, ids);
  }
  data_->SetPoints(points);
  data_->SetPolys(cells);
  locator_->SetDataSet(data_);
  locator_->BuildLocator();
}

std::optional<Vector3d> ScanPicker::Pick(const Vector3d& eye_in_scan,
                                         const Vector3d& direction_in_scan, double cone_rad) const {
  return scan_->triangles.empty() ? PickCloud(eye_in_scan, direction_in_scan, cone_rad)
                                  : PickSurface(eye_in_scan, direction_in_scan);
}

std::optional<Vector3d> ScanPicker::PickSurface(const Vector3d& eye,
                                                const Vector3d& direction) const {
  const Vector3d end = eye + kFarthest_m * direction;
  Vector3d start = eye;
  vtkNew<vtkGenericCell> cell;
  for (int hit = 0; hit < kMostHits; ++hit) {
    double t = 0, point[3], parameters[3];
    int part = 0;
    vtkIdType id = -1;
    if (locator_->IntersectWithLine(start.data(), end.data(), 1e-9, t, point, parameters, part, id,
                                    cell) == 0) {
      return std::nullopt;
    }
    const Eigen::Vector3i& corners = scan_->triangles[static_cast<std::size_t>(id)];
    const auto at = [&](int k) {
      return Vector3d(scan_->vertices[static_cast<std::size_t>(corners[k])].cast<double>());
    };
    const double facing = (at(1) - at(0)).cross(at(2) - at(0)).dot(-direction);
    if (side_ * facing >= 0) return Vector3d(point);
    start = Vector3d(point) + kStep_m * direction;  // through the side that is not drawn
  }
  return std::nullopt;
}

std::optional<Vector3d> ScanPicker::PickCloud(const Vector3d& eye, const Vector3d& direction,
                                              double cone_rad) const {
  const Eigen::Vector3f e = eye.cast<float>(), d = direction.cast<float>();
  const auto tan2 = static_cast<float>(std::tan(cone_rad) * std::tan(cone_rad));
  float nearest = std::numeric_limits<float>::infinity();
  std::optional<Vector3d> found;
  for (const Eigen::Vector3f& vertex : scan_->vertices) {
    const Eigen::Vector3f to = vertex - e;
    const float along = to.dot(d);
    if (along <= 0.05f || along >= nearest) continue;
    if (to.squaredNorm() - along * along > tan2 * along * along) continue;
    nearest = along;
    found = vertex.cast<double>();
  }
  return found;
}

}  // namespace plumbline
