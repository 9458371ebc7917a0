// SPDX-License-Identifier: Apache-2.0
#include "tests/support/room_run.h"

#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/evaluation/pose_error.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/synthetic/sequence_writer.h"

namespace plumbline {
namespace {

constexpr double kMatch_m = 0.5;
constexpr int kShownPixels = 2000, kShownFrames = 60;

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}

std::filesystem::path Film(const SyntheticOptions& options) {
  std::ostringstream name;
  name << "room-" << NameOf(options.scene) << '-' << options.seed << '-' << options.frames;
  name << '-' << options.rate_hz << "hz-" << options.width << 'x' << options.height;
  if (options.horizontal_fov_rad) name << '-' << *options.horizontal_fov_rad << "rad";
  const std::filesystem::path folder = CacheDirectory() / name.str();
  const std::filesystem::path done = CacheDirectory() / (name.str() + ".complete");
  if (std::filesystem::exists(done)) return folder;
  Must(WriteSyntheticSequence(options, folder, {}));
  if (!WriteFileAtomically(done, "complete\n").ok()) throw std::runtime_error("cannot write");
  return folder;
}

std::vector<FrameRun> ToRuns(const nlohmann::json& json) {
  std::vector<FrameRun> runs;
  for (const auto& run : json) runs.push_back({run[0], run[1]});
  return runs;
}

std::map<std::string, int> ShownFrames(const std::filesystem::path& folder) {
  std::map<std::string, int> shown;
  std::istringstream lines(Must(ReadFile(folder / "visibility.csv")));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    if (std::stoi(line.substr(second + 1)) >= kShownPixels)
      ++shown[line.substr(first + 1, second - first - 1)];
  }
  return shown;
}

double Distance(const ObjectReport& object, const RunInstance& instance) {
  return (object.world_from_object.translation() - instance.truth.world_from_object.translation())
      .norm();
}

}  // namespace

const RunInstance& RoomRun::Instance(const std::string& id) const {
  for (const RunInstance& instance : instances) {
    if (instance.truth.id == id) return instance;
  }
  throw std::runtime_error("no instance " + id);
}

const ObjectReport* RoomRun::Find(const FrameReport& report, const RunInstance& instance) const {
  const ObjectReport* best = nullptr;
  for (const ObjectReport& object : report.objects) {
    if (object.state != ObjectState::kConfirmed || object.category != instance.truth.category ||
        Distance(object, instance) > kMatch_m)
      continue;
    if (best == nullptr || Distance(object, instance) < Distance(*best, instance)) best = &object;
  }
  return best;
}

SyntheticOptions QuicklyLit(SyntheticScene scene, std::uint64_t seed) {
  SyntheticOptions options = OptionsFor(scene);
  options.seed = seed;
  options.samples_per_pixel = 2;
  options.light_rays = 48;
  options.light_spacing = 2;
  return options;
}

RoomRun MapRoom(const SyntheticOptions& options, const std::string& edges) {
  const std::filesystem::path folder = Film(options);
  RoomRun run;
  const nlohmann::json scene = nlohmann::json::parse(Must(ReadFile(folder / "scene.json")));
  std::map<std::string, int> shown = ShownFrames(folder);
  const GroundTruth ground_truth = Must(ReadGroundTruth(folder / "ground_truth.json"));
  run.gravity_in_world = ground_truth.gravity_in_world;
  for (const GroundTruthInstance& truth : ground_truth.instances) {
    RunInstance instance{truth, shown[truth.id], {}, {}};
    for (const auto& situation : scene["situations"]) {
      if (situation["instance"] != truth.id) continue;
      instance.hidden = ToRuns(situation["hidden_frames"]);
      instance.truncated = ToRuns(situation["truncated_frames"]);
    }
    run.instances.push_back(std::move(instance));
  }
  run.main_instance = scene.value("main_instance", "");
  run.shaken = ToRuns(scene["shaken_frames"]);
  RunRecipe recipe;
  recipe.sequence = folder;
  recipe.edges = ParseEdges(edges);
  const std::unique_ptr<MappingPipeline> pipeline = Must(MappingPipeline::Open(recipe, {}));
  run.database = pipeline->database();
  while (const auto snapshot = pipeline->Next()) {
    FrameReport report = (*snapshot)->report;
    for (ObjectReport& object : report.objects) object.particles.reset();
    report.mapper_state.clear();
    run.reports.push_back(std::move(report));
  }
  return run;
}

RoomFigures Judge(const RoomRun& run) {
  RoomFigures figures;
  std::ostringstream text;
  std::set<std::int32_t> matched;
  const FrameReport& last = run.reports.back();
  for (const RunInstance& instance : run.instances) {
    const ObjectReport* object = run.Find(last, instance);
    if (object != nullptr) matched.insert(object->id.value);
    if (instance.shown_frames < kShownFrames) continue;
    ++figures.instances;
    if (object == nullptr) {
      text << instance.truth.id << " is missed\n";
      continue;
    }
    const CadModel& model = run.database->model(object->label);
    const bool right = model.name == instance.truth.model;
    const PoseError error =
        ComparePoses(object->world_from_object, instance.truth.world_from_object, model.symmetry,
                     UprightFrame(run.gravity_in_world));
    const double distance_m = error.translation_m;
    const double angle_deg = error.rotation_rad * 180.0 / std::numbers::pi;
    ++figures.found;
    figures.right += right ? 1 : 0;
    figures.sum_m += distance_m;
    figures.sum_deg += angle_deg;
    if (!right || distance_m > 0.03 || angle_deg > 3)
      text << instance.truth.id << " as " << model.name << " is off by " << 100 * distance_m
           << " cm, " << angle_deg << " deg\n";
  }
  for (const ObjectReport& object : last.objects) {
    if (object.state != ObjectState::kConfirmed || matched.contains(object.id.value)) continue;
    ++figures.spurious;
    text << "spurious " << run.database->model(object.label).name << "\n";
  }
  figures.text = text.str();
  return figures;
}

}  // namespace plumbline
