// SPDX-License-Identifier: Apache-2.0
// A mapping step as a sequence gives it: 960x500, five confirmed objects of 500 particles, edges
// and proposals given. One thread makes search tables, the other steps the mapper, as in the
// pipeline. The baseline is what the step must cost at least: every particle scored once, on one
// core.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <numbers>
#include <thread>

#include <tbb/global_control.h>

#include "engine/base/queue.h"
#include "engine/base/timer.h"
#include "engine/mapping/mapper.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

constexpr int kWarmUp = 180, kFrames = 300;
constexpr double kRateHz = 30;
const PinholeCamera kCamera{960, 500, 600, 600, 479.5, 249.5};

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Half a turn round the objects in ten seconds, and on.
Eigen::Isometry3d CameraAt(int frame) {
  const double time_s = frame / kRateHz;
  const double angle = (-70 + 18 * time_s) * std::numbers::pi / 180;
  return LookAt({3 * std::cos(angle), 3 * std::sin(angle), 1.5 + 0.05 * std::sin(2 * time_s)},
                {0, 0, 0.45});
}

/// The frames as a sequence would give them, without their search tables.
std::vector<MapperInput> DrawFrames(MappingScene& scene) {
  const std::vector<PlacedModel> objects = {
      scene.Place("table", 0, 0, 90, 1), scene.Place("chair", 0.85, 0.1, 180, 2),
      scene.Place("chair", -0.1, -1.15, 75, 3), scene.Place("armchair", -1.0, 0.3, 20, 4),
      scene.Place("chair", 0.2, 1.2, -80, 5)};
  std::vector<MapperInput> frames;
  for (int i = 0; i < kWarmUp + kFrames; ++i) {
    MapperInput given;
    given.frame = i;
    given.stamp_ns = static_cast<std::int64_t>(1e9 * (i + 1) / kRateHz);
    given.world_from_cam = CameraAt(i);
    given.edges = scene.Edges(CameraAt(i), objects);
    given.detections = DetectionsFromProposals(scene.Boxes(CameraAt(i), objects));
    frames.push_back(std::move(given));
  }
  return frames;
}

std::shared_ptr<const HypothesisScorer> MakeScorer(const ModelDatabase& database,
                                                   std::shared_ptr<const ModelDatabase> shared) {
  std::vector<std::shared_ptr<const ViewpointModel>> views;
  for (const CadModel& model : database.models())
    views.push_back(ViewpointModel::Build(model, {}, {}).value());
  return std::make_shared<ViewpointScorer>(std::move(views), std::move(shared));
}

/// Seconds of one core to score every particle of a frame once.
double LeastSeconds(const HypothesisScorer& scorer, const MappingScene& scene,
                    const MapperInput& input, const FrameReport& report) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  ScoringView view;
  view.camera = kCamera;
  view.cam_from_world = input.world_from_cam.inverse();
  view.table = input.table.get();
  std::vector<PoseHypothesis> hypotheses;
  for (const ObjectReport& object : report.objects) {
    for (const Particle& particle : *object.particles)
      hypotheses.push_back(ToHypothesis(particle, object.world_from_reference_cam));
  }
  std::vector<HypothesisScore> scores(hypotheses.size());
  constexpr int kRepeats = 20;
  const double start = ProcessorSeconds();
  for (int i = 0; i < kRepeats; ++i) scorer.Score(view, scene.map().upright, hypotheses, scores);
  return (ProcessorSeconds() - start) / kRepeats;
}

void Run() {
  MappingScene scene(kCamera);
  const std::vector<MapperInput> frames = DrawFrames(scene);
  MapperSetup setup;
  setup.camera = kCamera;
  setup.gravity_in_world = {0, 0, -9.81};
  setup.floor_in_world = Eigen::Vector4d(0, 0, 1, 0);
  setup.database = scene.database();
  setup.scorer = MakeScorer(*scene.database(), scene.database());
  std::unique_ptr<Mapper> mapper = Mapper::Create(setup).value();

  BoundedQueue<MapperInput> ahead(4);
  std::jthread tables([&] {
    for (const MapperInput& given : frames) {
      MapperInput input = given;
      MakeTables(setup.options, kCamera.fx, input);
      if (!ahead.Push(std::move(input))) return;
    }
  });
  std::map<std::string, double> stages;
  FrameReport report;
  MapperInput last;
  Stopwatch watch;
  double processor = 0, seconds = 0;
  std::size_t confirmed = 0, particles = 0;
  for (int i = 0; i < kWarmUp + kFrames; ++i) {
    if (i == kWarmUp) {
      watch.Lap();
      processor = ProcessorSeconds();
    }
    last = *ahead.Pop();
    report = mapper->Step(last);
    if (i < kWarmUp) continue;
    for (const StageTiming& stage : report.timings) stages[stage.stage] += stage.milliseconds;
    for (const ObjectReport& object : report.objects) {
      confirmed += object.state == ObjectState::kConfirmed ? 1 : 0;
      particles += object.particles->size();
    }
  }
  seconds = watch.Lap() * 1e-3;
  processor = ProcessorSeconds() - processor;
  const double least = LeastSeconds(*setup.scorer, scene, last, report);
  std::printf(
      "%.1f frames/s on %u cores, %.1f ms of one core a frame; %.1f confirmed objects, %.0f "
      "particles\n",
      kFrames / seconds, std::thread::hardware_concurrency(), 1e3 * processor / kFrames,
      static_cast<double>(confirmed) / kFrames, static_cast<double>(particles) / kFrames);
  std::printf("scoring every particle once: %.1f ms of one core; the step takes %.2f times that\n",
              1e3 * least, processor / kFrames / least);
  for (const auto& [name, ms] : stages)
    std::printf("  %-12s %6.2f ms\n", name.c_str(), ms / kFrames);
}

}  // namespace
}  // namespace plumbline

int main() { plumbline::Run(); }
