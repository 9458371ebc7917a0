// SPDX-License-Identifier: Apache-2.0
// The surface error's work: 500 000 points to a million triangles, against VTK's cell locator on
// the same mesh. Times are wall time on all cores; the preparation (building the hierarchy) is
// apart.

#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <cmath>
#include <cstdio>
#include <ctime>

#include <benchmark/benchmark.h>

#include "engine/base/random.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/random_vector.h"
#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

constexpr int kSamples = 500000;
constexpr int kVtkSamples = 20000;  // VTK's share is measured on a part and given per point

/// A room-sized relief of 2 * 708^2 = 1 002 528 triangles, rough like a fused scan.
const TriangleMesh& Scan() {
  static const TriangleMesh mesh = [] {
    constexpr int kSide = 709;
    TriangleMesh scan;
    Random random({.seed = 1});
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const double x = 6.0 * i / kSide, y = 6.0 * j / kSide;
        const double z =
            0.5 * std::sin(2 * x) * std::cos(3 * y) + (std::fmod(x, 1) < 0.4 ? 0.7 : 0.0);
        scan.vertices.emplace_back(
            Eigen::Vector3d(x, y, z + 0.003 * random.Gaussian()).cast<float>());
      }
    }
    for (int i = 0; i + 1 < kSide; ++i) {
      for (int j = 0; j + 1 < kSide; ++j) {
        const int a = i * kSide + j, b = a + kSide;
        scan.triangles.emplace_back(a, b, b + 1);
        scan.triangles.emplace_back(a, b + 1, a + 1);
      }
    }
    return scan;
  }();
  return mesh;
}

/// Points about `offset_m` away from the surface.
std::vector<Eigen::Vector3d> Queries(double offset_m) {
  SurfaceSamples samples = SampleSurface(Scan(), kSamples, 1).value();
  Random random({.seed = 2});
  for (Eigen::Vector3d& point : samples.points) {
    point += offset_m * GaussianVector<3>(random);
  }
  return std::move(samples.points);
}

/// Of all threads [s].
double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// CPU time per point with VTK's locator.
double VtkSecondsPerPoint(const std::vector<Eigen::Vector3d>& queries) {
  static const vtkNew<vtkCellLocator> locator;
  static const vtkNew<vtkPolyData> data;
  if (data->GetNumberOfCells() == 0) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const Eigen::Vector3f& v : Scan().vertices) points->InsertNextPoint(v.x(), v.y(), v.z());
    vtkNew<vtkCellArray> cells;
    for (const Eigen::Vector3i& t : Scan().triangles) {
      const vtkIdType ids[] = {t[0], t[1], t[2]};
      cells->InsertNextCell(3, ids);
    }
    data->SetPoints(points);
    data->SetPolys(cells);
    const double start = CpuSeconds();
    locator->SetDataSet(data);
    locator->CacheCellBoundsOn();
    locator->BuildLocator();
    std::printf("VTK's locator was built in %.0f ms of CPU time\n", 1e3 * (CpuSeconds() - start));
  }
  vtkNew<vtkGenericCell> cell;
  const double start = CpuSeconds();
  for (int i = 0; i < kVtkSamples; ++i) {
    double closest[3], distance2 = 0;
    vtkIdType id = 0;
    int sub = 0;
    locator->FindClosestPoint(
        queries[static_cast<std::size_t>(i) * (kSamples / kVtkSamples)].data(), closest, cell, id,
        sub, distance2);
    benchmark::DoNotOptimize(distance2);
  }
  return (CpuSeconds() - start) / kVtkSamples;
}

void BM_BuildClosestTriangle(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ClosestTriangleSearch::Build(Scan()));
}
BENCHMARK(BM_BuildClosestTriangle)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void BM_SampleSurface(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(SampleSurface(Scan(), kSamples, 1));
}
BENCHMARK(BM_SampleSurface)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void BM_ClosestTriangle(benchmark::State& state) {
  static const auto search = ClosestTriangleSearch::Build(Scan()).value();
  const std::vector<Eigen::Vector3d> queries = Queries(static_cast<double>(state.range(0)) / 1000);
  std::vector<ClosestPoint> closest(queries.size());
  double seconds = 0;
  for (auto _ : state) {
    const double start = CpuSeconds();
    search->Find(queries, closest);
    seconds += CpuSeconds() - start;
  }
  const double ours = seconds / static_cast<double>(state.iterations()) / kSamples;
  const double vtk = VtkSecondsPerPoint(queries);
  state.counters["us_per_point"] = 1e6 * ours;
  state.counters["vtk_us_per_point"] = 1e6 * vtk;
  state.counters["times_vtk"] = vtk / ours;
}
BENCHMARK(BM_ClosestTriangle)
    ->ArgName("offset_mm")
    ->Arg(20)
    ->Arg(300)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
