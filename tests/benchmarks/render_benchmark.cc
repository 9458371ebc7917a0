// SPDX-License-Identifier: Apache-2.0
// Two layers, ids and contour of five objects as the mapper asks for them, by OpenGL (the baseline)
// and on the processor, and of a mesh of many triangles.

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "engine/render/renderer.h"
#include "tests/support/mapping_scene.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

enum DrawnBy : int { kOpenGl, kProcessor };
enum Scene : int { kFiveObjects, kManyTriangles };

/// Arguments: what draws, the image's width (960x500 and its fractions), the scene.
void Draw(benchmark::State& state) {
  static const std::unique_ptr<RenderContext> context = RenderContext::CreateHeadless().value();
  const std::unique_ptr<Renderer> renderer = state.range(0) == kOpenGl
                                                 ? Renderer::Create(*context).value()
                                                 : Renderer::CreateOnProcessor();
  const PinholeCamera full{960, 500, 600, 600, 479.5, 249.5};
  const PinholeCamera camera = full.Scaled(static_cast<double>(state.range(1)) / full.width);
  MappingScene& scene = MappingScene::Get();
  const Eigen::Isometry3d cam_from_world = LookAt({1, -2.8, 1.5}, {0, 0, 0.45}).inverse();
  std::vector<RenderInstance> instances;
  std::size_t triangles = 0;
  if (state.range(2) == kFiveObjects) {
    for (const PlacedModel& placed :
         {scene.Place("table", 0, 0, 90, 1), scene.Place("chair", 0.85, 0.1, 180, 2),
          scene.Place("chair", -0.1, -1.15, 75, 3), scene.Place("armchair", -1.0, 0.3, 20, 4),
          scene.Place("chair", 0.2, 1.2, -80, 5)}) {
      const TriangleMesh& mesh = scene.database()->model(placed.label).mesh;
      triangles += mesh.triangles.size();
      instances.push_back({renderer->AddMesh(mesh), cam_from_world * placed.world_from_object,
                           placed.object.value, placed.scale});
    }
  } else {
    const TriangleMesh mesh = MakeSphere(0.8f, 250);
    triangles = mesh.triangles.size();
    instances.push_back({renderer->AddMesh(mesh), cam_from_world, 1, 1});
  }
  RenderOptions options;
  options.contour = options.second_layer = true;
  for (auto _ : state) benchmark::DoNotOptimize(renderer->Render(camera, instances, options));
  state.counters["triangles"] = static_cast<double>(triangles);
}

BENCHMARK(Draw)
    ->ArgNames({"processor", "width", "many"})
    ->ArgsProduct({{kOpenGl, kProcessor}, {240, 480, 960}, {kFiveObjects, kManyTriangles}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
