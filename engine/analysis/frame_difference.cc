// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/frame_difference.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

constexpr double kPair_m = 0.5;

std::vector<const ObjectReport*> Confirmed(const FrameReport& report) {
  std::vector<const ObjectReport*> out;
  for (const ObjectReport& object : report.objects) {
    if (object.state == ObjectState::kConfirmed) out.push_back(&object);
  }
  return out;
}

bool Differ(const FrameSample& a, const FrameSample& b) {
  if (a.objects.size() != b.objects.size() || a.skipped != b.skipped) return true;
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    const ObjectSample &x = a.objects[i], &y = b.objects[i];
    if (x.id != y.id || x.label != y.label || x.state != y.state ||
        x.log_evidence != y.log_evidence || x.position_std_m != y.position_std_m)
      return true;
  }
  return false;
}

std::map<std::string, double> MeanStages(const RunHistory& history) {
  std::map<std::string, double> sums;
  int frames = 0;
  for (const auto& frame : history.frames) {
    if (frame == nullptr) continue;
    ++frames;
    for (const StageTiming& stage : frame->timings) sums[stage.stage] += stage.milliseconds;
  }
  for (auto& [stage, sum] : sums) sum /= std::max(1, frames);
  return sums;
}

}  // namespace

std::vector<ObjectPair> PairObjects(const FrameReport& a, const FrameReport& b,
                                    const Eigen::Vector3d& up_in_world) {
  const UprightFrame upright(-up_in_world);
  std::vector<const ObjectReport*> left = Confirmed(a), right = Confirmed(b);
  std::vector<ObjectPair> candidates, out;
  for (const ObjectReport* x : left) {
    for (const ObjectReport* y : right) {
      const double distance_m =
          (x->world_from_object.translation() - y->world_from_object.translation()).norm();
      if (x->category == y->category && distance_m < kPair_m)
        candidates.push_back({x, y, distance_m, 0});
    }
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const ObjectPair& x, const ObjectPair& y) { return x.distance_m < y.distance_m; });
  for (ObjectPair& candidate : candidates) {
    const auto in_left = std::find(left.begin(), left.end(), candidate.a);
    const auto in_right = std::find(right.begin(), right.end(), candidate.b);
    if (in_left == left.end() || in_right == right.end()) continue;
    left.erase(in_left);
    right.erase(in_right);
    candidate.azimuth_rad =
        std::abs(WrapAngle(upright.Azimuth(candidate.a->world_from_object.linear()) -
                           upright.Azimuth(candidate.b->world_from_object.linear())));
    out.push_back(candidate);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& x, const auto& y) { return x.a->id < y.a->id; });
  for (const ObjectReport* x : left) out.push_back({x, nullptr, 0, 0});
  for (const ObjectReport* y : right) out.push_back({nullptr, y, 0, 0});
  return out;
}

std::optional<int> FirstDifference(const RunHistory& a, const RunHistory& b) {
  std::map<int, const FrameSample*> by_frame;
  for (const auto& frame : a.frames) {
    if (frame != nullptr) by_frame[frame->frame] = frame.get();
  }
  for (const auto& frame : b.frames) {
    if (frame == nullptr) continue;
    const auto found = by_frame.find(frame->frame);
    if (found != by_frame.end() && Differ(*found->second, *frame)) return frame->frame;
  }
  return std::nullopt;
}

std::vector<StageDifference> CompareStages(const RunHistory& a, const RunHistory& b) {
  std::map<std::string, StageDifference> stages;
  for (const auto& [stage, mean] : MeanStages(a)) stages[stage] = {stage, mean, 0};
  for (const auto& [stage, mean] : MeanStages(b)) {
    stages[stage].stage = stage;
    stages[stage].mean_b_ms = mean;
  }
  std::vector<StageDifference> out;
  for (auto& [name, stage] : stages) out.push_back(stage);
  return out;
}

}  // namespace plumbline
