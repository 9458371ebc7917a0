// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_decimation.h"

#include <vtkCellArray.h>
#include <vtkDecimatePro.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_cleanup.h"

namespace plumbline {
namespace {

constexpr int kErrorSamples = 20000;
constexpr std::uint64_t kDecimationSeed = 1;

vtkNew<vtkPolyData> ToVtk(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Eigen::Vector3f& v : mesh.vertices) points->InsertNextPoint(v.x(), v.y(), v.z());
  vtkNew<vtkCellArray> cells;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const std::array<vtkIdType, 3> corners = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, corners.data());
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  return data;
}

TriangleMesh FromVtk(vtkPolyData* data) {
  TriangleMesh mesh;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    std::array<double, 3> point;
    data->GetPoint(i, point.data());
    mesh.vertices.push_back(Eigen::Vector3d(point.data()).cast<float>());
  }
  vtkNew<vtkIdList> corners;
  data->GetPolys()->InitTraversal();
  while (data->GetPolys()->GetNextCell(corners) != 0) {
    if (corners->GetNumberOfIds() != 3) continue;
    mesh.triangles.emplace_back(static_cast<int>(corners->GetId(0)),
                                static_cast<int>(corners->GetId(1)),
                                static_cast<int>(corners->GetId(2)));
  }
  return WeldedGeometry(mesh);
}

template <typename Filter>
TriangleMesh Reduced(const TriangleMesh& mesh, int faces, Filter& filter) {
  const vtkNew<vtkPolyData> data = ToVtk(mesh);
  filter.SetInputData(data);
  filter.SetTargetReduction(1.0 - static_cast<double>(faces) /
                                      static_cast<double>(mesh.triangles.size()));
  filter.Update();
  return FromVtk(filter.GetOutput());
}

/// The weights of a triangle's corners at a point of it.
Eigen::Vector3d Barycentric(const TriangleMesh& mesh, const Eigen::Vector3i& t,
                            const Eigen::Vector3d& point) {
  const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(t[0])].cast<double>();
  const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(t[1])].cast<double>() - a;
  const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(t[2])].cast<double>() - a;
  const Eigen::Vector3d normal = ab.cross(ac);
  const double doubled_area_squared = normal.squaredNorm();
  if (!(doubled_area_squared > 0)) return {1, 0, 0};
  const double b = normal.dot((point - a).cross(ac)) / doubled_area_squared;
  const double c = normal.dot(ab.cross(point - a)) / doubled_area_squared;
  Eigen::Vector3d weights(1 - b - c, b, c);
  weights = weights.cwiseMax(0.0);
  return weights / weights.sum();
}

Eigen::Vector3d ColorAt(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& point) {
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Eigen::Vector3d weights = Barycentric(mesh, t, point);
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const auto& corner = mesh.colors[static_cast<std::size_t>(t[c])];
    color += weights[c] * Eigen::Vector3d(corner[0], corner[1], corner[2]);
  }
  return color;
}

void TakeColors(const TriangleMesh& source, const ClosestTriangleSearch& surface,
                TriangleMesh& mesh) {
  mesh.colors.clear();
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const ClosestPoint closest = surface.Find(vertex.cast<double>());
    const Eigen::Vector3d color = ColorAt(source, closest.triangle, closest.point);
    mesh.colors.push_back({static_cast<std::uint8_t>(std::lround(color[0])),
                           static_cast<std::uint8_t>(std::lround(color[1])),
                           static_cast<std::uint8_t>(std::lround(color[2]))});
  }
}

/// The pieces of the texture: for every triangle the number of its connected component over shared
/// vertices.
std::vector<int> ChartOfTriangles(const TriangleMesh& mesh, int& count) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      i = parent[static_cast<std::size_t>(i)] =
          parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    }
    return i;
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    parent[static_cast<std::size_t>(root(t[1]))] = root(t[0]);
    parent[static_cast<std::size_t>(root(t[2]))] = root(t[0]);
  }
  std::map<int, int> number;
  std::vector<int> charts;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    charts.push_back(number.try_emplace(root(t[0]), static_cast<int>(number.size())).first->second);
  }
  count = static_cast<int>(number.size());
  return charts;
}

/// One chart of the source with its own search.
struct Chart {
  TriangleMesh mesh;
  std::unique_ptr<ClosestTriangleSearch> surface;
};

Eigen::Vector2f TextureAt(const Chart& chart, const Eigen::Vector3d& point) {
  const ClosestPoint closest = chart.surface->Find(point);
  const Eigen::Vector3i& t = chart.mesh.triangles[static_cast<std::size_t>(closest.triangle)];
  const Eigen::Vector3d weights = Barycentric(chart.mesh, t, closest.point);
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  for (int c = 0; c < 3; ++c) {
    uv +=
        weights[c] * chart.mesh.texture_coordinates[static_cast<std::size_t>(t[c])].cast<double>();
  }
  return uv.cast<float>();
}

/// Splits vertices where charts meet: one copy of a vertex for each chart that its faces belong to.
Status TakeTexture(const TriangleMesh& source, const ClosestTriangleSearch& surface,
                   TriangleMesh& mesh) {
  int count = 0;
  const std::vector<int> chart_of = ChartOfTriangles(source, count);
  std::vector<Chart> charts(static_cast<std::size_t>(count));
  for (Chart& chart : charts) {
    chart.mesh.vertices = source.vertices;
    chart.mesh.texture_coordinates = source.texture_coordinates;
  }
  for (std::size_t i = 0; i < source.triangles.size(); ++i) {
    charts[static_cast<std::size_t>(chart_of[i])].mesh.triangles.push_back(source.triangles[i]);
  }
  for (Chart& chart : charts) {
    CleanupReport unused;
    chart.mesh = CleanMesh(chart.mesh, unused);
    auto built = ClosestTriangleSearch::Build(chart.mesh);
    if (!built.ok()) return built.error();
    chart.surface = std::move(built).value();
  }
  std::map<std::pair<int, int>, int> copies;
  TriangleMesh split;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int corner : t)
      centre += mesh.vertices[static_cast<std::size_t>(corner)].cast<double>() / 3.0;
    const int chart = chart_of[static_cast<std::size_t>(surface.Find(centre).triangle)];
    Eigen::Vector3i corners;
    for (int c = 0; c < 3; ++c) {
      const auto [copy, is_new] =
          copies.try_emplace({t[c], chart}, static_cast<int>(split.vertices.size()));
      corners[c] = copy->second;
      if (!is_new) continue;
      const Eigen::Vector3f& vertex = mesh.vertices[static_cast<std::size_t>(t[c])];
      split.vertices.push_back(vertex);
      split.texture_coordinates.push_back(
          TextureAt(charts[static_cast<std::size_t>(chart)], vertex.cast<double>()));
    }
    split.triangles.push_back(corners);
  }
  split.texture_file = source.texture_file;
  mesh = std::move(split);
  return {};
}

Status MeasureErrors(const TriangleMesh& a, const TriangleMesh& b, DecimationReport& report) {
  double sum = 0, color_sum = 0;
  int samples = 0;
  const std::array<std::pair<const TriangleMesh*, const TriangleMesh*>, 2> ways = {
      {{&a, &b}, {&b, &a}}};
  for (const auto& [from, to] : ways) {
    const Result<SurfaceSamples> drawn = SampleSurface(*from, kErrorSamples, kDecimationSeed);
    if (!drawn.ok()) return drawn.error();
    const auto surface = ClosestTriangleSearch::Build(*to);
    if (!surface.ok()) return surface.error();
    std::vector<ClosestPoint> closest(drawn->points.size());
    (*surface)->Find(drawn->points, closest);
    for (std::size_t i = 0; i < closest.size(); ++i, ++samples) {
      sum += closest[i].distance_m;
      report.max_error_m = std::max(report.max_error_m, closest[i].distance_m);
      if (from->colors.empty() || to->colors.empty()) continue;
      const Eigen::Vector3d difference = ColorAt(*from, drawn->triangles[i], drawn->points[i]) -
                                         ColorAt(*to, closest[i].triangle, closest[i].point);
      color_sum += difference.cwiseAbs().mean();
    }
  }
  report.mean_error_m = sum / samples;
  report.mean_color_error = color_sum / samples;
  return {};
}

}  // namespace

Result<TriangleMesh> DecimateMesh(const TriangleMesh& mesh, int faces, DecimationReport& report) {
  report = {};
  report.faces_before = report.faces_after = static_cast<int>(mesh.triangles.size());
  if (report.faces_before <= faces) return mesh;
  TriangleMesh reduced = WeldedGeometry(mesh);
  // Quadrics stop early on surfaces with many borders; a second pass goes on, and the cruder method
  // finishes.
  for (int pass = 0; pass < 3 && static_cast<int>(reduced.triangles.size()) > faces; ++pass) {
    vtkNew<vtkQuadricDecimation> quadric;
    quadric->VolumePreservationOn();
    reduced = Reduced(reduced, faces, *quadric);
  }
  if (static_cast<int>(reduced.triangles.size()) > faces) {
    vtkNew<vtkDecimatePro> crude;
    crude->PreserveTopologyOff();
    crude->BoundaryVertexDeletionOn();
    reduced = Reduced(reduced, faces, *crude);
  }
  report.faces_after = static_cast<int>(reduced.triangles.size());
  if (report.faces_after > faces || reduced.triangles.empty()) {
    return Error{ErrorCode::kDegenerate, "it cannot be decimated to " + std::to_string(faces) +
                                             " faces (" + std::to_string(report.faces_after) +
                                             " reached); allow more with --faces"};
  }
  const auto surface = ClosestTriangleSearch::Build(mesh);
  if (!surface.ok()) return surface.error();
  if (!mesh.texture_coordinates.empty()) {
    if (const Status status = TakeTexture(mesh, **surface, reduced); !status.ok())
      return status.error();
  }
  if (!mesh.colors.empty()) TakeColors(mesh, **surface, reduced);
  if (const Status status = MeasureErrors(mesh, reduced, report); !status.ok())
    return status.error();
  return reduced;
}

}  // namespace plumbline
