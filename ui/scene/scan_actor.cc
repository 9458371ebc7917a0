// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/scan_actor.h"

#include <algorithm>
#include <vector>

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include "ui/scene/vtk_helpers.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kLight = 0.72;  ///< Of its own colours.
constexpr double kClearMajority =
    0.3;  ///< Mean of +1 (towards the cameras) and -1 that settles the sides.

vtkSmartPointer<vtkUnsignedCharArray> ColorsOf(const TriangleMesh& scan, const Vector3d& up) {
  auto rgb = vtkSmartPointer<vtkUnsignedCharArray>::New();
  rgb->SetNumberOfComponents(3);
  rgb->SetNumberOfTuples(static_cast<vtkIdType>(scan.vertices.size()));
  const bool colored = scan.colors.size() == scan.vertices.size();
  for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
    std::uint8_t* color = rgb->GetPointer(3 * static_cast<vtkIdType>(i));
    const double height = scan.vertices[i].cast<double>().dot(up);
    const double grey = 120 + 60 * std::clamp(height / 2.5, 0.0, 1.0);
    for (std::size_t c = 0; c < 3; ++c) {
      color[c] = static_cast<std::uint8_t>(kLight * (colored ? scan.colors[i][c] : grey));
    }
  }
  return rgb;
}

}  // namespace

int SideTowards(const TriangleMesh& scan, const Vector3d& eye) {
  const std::size_t stride = std::max<std::size_t>(1, scan.triangles.size() / 5000);
  double votes = 0, count = 0;
  for (std::size_t i = 0; i < scan.triangles.size(); i += stride) {
    const Eigen::Vector3i& t = scan.triangles[i];
    const Vector3d a = scan.vertices[t[0]].cast<double>(), b = scan.vertices[t[1]].cast<double>();
    const Vector3d c = scan.vertices[t[2]].cast<double>();
    votes += (b - a).cross(c - a).dot(eye - a) > 0 ? 1 : -1;
    ++count;
  }
  return votes > kClearMajority * count ? 1 : votes < -kClearMajority * count ? -1 : 0;
}

vtkSmartPointer<vtkActor> ScanActor(const TriangleMesh& scan, const Vector3d& up_in_scan,
                                    const std::optional<Vector3d>& eye) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  for (const Eigen::Vector3f& v : scan.vertices) points->InsertNextPoint(v.data());
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  vtkNew<vtkCellArray> cells;
  if (scan.triangles.empty()) {
    std::vector<vtkIdType> ids(scan.vertices.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<vtkIdType>(i);
    if (!ids.empty()) cells->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
    data->SetVerts(cells);
  } else {
    for (const Eigen::Vector3i& t : scan.triangles) {
      const vtkIdType ids[3] = {t[0], t[1], t[2]};
      cells->InsertNextCell(3, ids);
    }
    data->SetPolys(cells);
  }
  data->GetPointData()->SetScalars(ColorsOf(scan, up_in_scan));
  auto actor = LineActorOf(data, IM_COL32_WHITE, 0.75);
  const int side = scan.triangles.empty() || !eye ? 0 : SideTowards(scan, *eye);
  actor->GetProperty()->SetBackfaceCulling(side > 0);
  actor->GetProperty()->SetFrontfaceCulling(side < 0);
  return actor;
}

}  // namespace plumbline
