// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/scan_actor.h"

#include <algorithm>
#include <utility>

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include "engine/geometry/gravity.h"
#include "ui/framework/pictures.h"
#include "ui/framework/theme.h"
#include "ui/scene/vtk_helpers.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kLight = 0.72;  ///< Of its own colours.
constexpr double kClearMajority =
    0.3;  ///< Mean of +1 (towards the cameras) and -1 that settles the sides.

using Rgb = std::array<std::uint8_t, 3>;

Rgb Dimmed(double red, double green, double blue) {
  const auto of = [](double value) { return static_cast<std::uint8_t>(kLight * value); };
  return {of(red), of(green), of(blue)};
}

/// Of its lowest and highest hundredth.
std::pair<double, double> HeightsOf(const TriangleMesh& scan, const Vector3d& up) {
  std::vector<double> heights;
  const std::size_t stride = std::max<std::size_t>(1, scan.vertices.size() / 20000);
  for (std::size_t i = 0; i < scan.vertices.size(); i += stride)
    heights.push_back(scan.vertices[i].cast<double>().dot(up));
  if (heights.empty()) return {0, 1};
  std::sort(heights.begin(), heights.end());
  const double low = heights[heights.size() / 100],
               high = heights[heights.size() - 1 - heights.size() / 100];
  return {low, std::max(high, low + 0.01)};
}

std::vector<Rgb> ByHeight(const TriangleMesh& scan, const Vector3d& up) {
  const auto [low, high] = HeightsOf(scan, up);
  std::vector<Rgb> colors;
  colors.reserve(scan.vertices.size());
  for (const Eigen::Vector3f& vertex : scan.vertices) {
    const double below_top = std::clamp(high - vertex.cast<double>().dot(up), 0.0, high - low);
    const cv::Vec3b bgr = BgrOf(DepthColor(below_top, {0, high - low}));
    colors.push_back(Dimmed(bgr[2], bgr[1], bgr[0]));
  }
  return colors;
}

std::vector<Rgb> ByNormal(const TriangleMesh& scan, const Vector3d& up) {
  TriangleMesh computed;
  const bool known = scan.normals.size() == scan.vertices.size();
  if (!known) {
    computed.vertices = scan.vertices;
    computed.triangles = scan.triangles;
    ComputeNormals(computed);
  }
  const auto& normals = known ? scan.normals : computed.normals;
  const Eigen::Matrix3d upright_from_scan = UprightFrame(-up).upright_rotation().transpose();
  std::vector<Rgb> colors;
  colors.reserve(normals.size());
  for (const Eigen::Vector3f& normal : normals) {
    // Both sides of a surface look the same: which one a scan's triangles turn outwards varies.
    const Vector3d turned = (upright_from_scan * normal.cast<double>()).cwiseAbs();
    colors.push_back(Dimmed(60 + 195 * turned.x(), 60 + 195 * turned.y(), 60 + 195 * turned.z()));
  }
  return colors;
}

}  // namespace

bool HasColors(const TriangleMesh& scan) {
  return !scan.empty() && scan.colors.size() == scan.vertices.size();
}

bool HasNormals(const TriangleMesh& scan) {
  return !scan.triangles.empty() || (!scan.empty() && scan.normals.size() == scan.vertices.size());
}

std::vector<Rgb> ScanColors(const TriangleMesh& scan, const Vector3d& up,
                            std::optional<ScanColoring> coloring) {
  if (coloring == ScanColoring::kNormal && HasNormals(scan)) return ByNormal(scan, up);
  const bool own = HasColors(scan);
  if (coloring && (!own || *coloring != ScanColoring::kOwn)) return ByHeight(scan, up);
  std::vector<Rgb> colors;
  colors.reserve(scan.vertices.size());
  for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
    const double height = scan.vertices[i].cast<double>().dot(up);
    const double grey = 120 + 60 * std::clamp(height / 2.5, 0.0, 1.0);
    colors.push_back(own ? Dimmed(scan.colors[i][0], scan.colors[i][1], scan.colors[i][2])
                         : Dimmed(grey, grey, grey));
  }
  return colors;
}

void ColorScan(vtkActor& actor, const std::vector<Rgb>& colors) {
  vtkNew<vtkUnsignedCharArray> rgb;
  rgb->SetNumberOfComponents(3);
  rgb->SetNumberOfTuples(static_cast<vtkIdType>(colors.size()));
  for (std::size_t i = 0; i < colors.size(); ++i)
    rgb->SetTypedTuple(static_cast<vtkIdType>(i), colors[i].data());
  vtkPolyDataMapper::SafeDownCast(actor.GetMapper())->GetInput()->GetPointData()->SetScalars(rgb);
}

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
  auto actor = LineActorOf(data, IM_COL32_WHITE, 0.75);
  ColorScan(*actor, ScanColors(scan, up_in_scan, std::nullopt));
  const int side = scan.triangles.empty() || !eye ? 0 : SideTowards(scan, *eye);
  actor->GetProperty()->SetBackfaceCulling(side > 0);
  actor->GetProperty()->SetFrontfaceCulling(side < 0);
  return actor;
}

}  // namespace plumbline
