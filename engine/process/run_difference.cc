// SPDX-License-Identifier: Apache-2.0
#include "engine/process/run_difference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "engine/geometry/gravity.h"
#include "engine/process/history.h"

namespace plumbline {
namespace {

constexpr double kPair_m = 0.5;
constexpr double kDegrees = 180 / std::numbers::pi;

std::vector<std::string> Settings(const RunHeader& a, const RunHeader& b) {
  std::vector<std::string> out;
  const auto compare = [&](const std::string& name, const std::string& x, const std::string& y) {
    if (x != y) out.push_back(name + ": " + x + " / " + y);
  };
  compare("seed", std::to_string(a.seed), std::to_string(b.seed));
  compare("edges", a.edges, b.edges);
  compare("detector", a.detector, b.detector);
  compare("poses", a.poses, b.poses);
  compare("sequence", a.sequence_hash == b.sequence_hash ? "" : a.sequence_path,
          a.sequence_hash == b.sequence_hash ? "" : b.sequence_path);
  compare("program", a.program_version, b.program_version);
  const auto options_a = a.options.flatten(), options_b = b.options.flatten();
  std::map<std::string, std::pair<std::string, std::string>> all;
  for (const auto& [key, value] : options_a.items()) all[key].first = value.dump();
  for (const auto& [key, value] : options_b.items()) all[key].second = value.dump();
  for (const auto& [key, values] : all) {
    const auto text = [](const std::string& value) {
      return value.empty() ? std::string("(none)") : value;
    };
    compare(key.empty() ? "options" : key.substr(1), text(values.first), text(values.second));
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

std::map<std::string, double> MeanStages(const RunReview& review) {
  std::map<std::string, double> sums;
  for (const RunTiming& frame : review.timings) {
    for (const StageTiming& stage : frame.stages) sums[stage.stage] += stage.milliseconds;
  }
  for (auto& [stage, sum] : sums)
    sum /= static_cast<double>(std::max<std::size_t>(1, review.timings.size()));
  return sums;
}

std::vector<const ObjectReport*> Confirmed(const FrameReport& report) {
  std::vector<const ObjectReport*> out;
  for (const ObjectReport& object : report.objects) {
    if (object.state == ObjectState::kConfirmed) out.push_back(&object);
  }
  return out;
}

std::vector<ObjectDifference> Objects(const RunReview& a, const RunReview& b) {
  const UprightFrame upright(-a.view.up_in_world);
  std::vector<const ObjectReport*> left = Confirmed(a.last), right = Confirmed(b.last);
  struct Candidate {
    double distance_m;
    const ObjectReport *a, *b;
  };
  std::vector<Candidate> candidates;
  for (const ObjectReport* x : left) {
    for (const ObjectReport* y : right) {
      const double distance_m =
          (x->world_from_object.translation() - y->world_from_object.translation()).norm();
      if (x->category == y->category && distance_m < kPair_m)
        candidates.push_back({distance_m, x, y});
    }
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& x, const Candidate& y) { return x.distance_m < y.distance_m; });
  std::vector<ObjectDifference> out;
  for (const Candidate& candidate : candidates) {
    const auto in_left = std::find(left.begin(), left.end(), candidate.a);
    const auto in_right = std::find(right.begin(), right.end(), candidate.b);
    if (in_left == left.end() || in_right == right.end()) continue;
    left.erase(in_left);
    right.erase(in_right);
    const double turned =
        std::abs(WrapAngle(upright.Azimuth(candidate.a->world_from_object.linear()) -
                           upright.Azimuth(candidate.b->world_from_object.linear())));
    out.push_back({candidate.a, candidate.b, candidate.distance_m, turned, {}, {}});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& x, const auto& y) { return x.a->id < y.a->id; });
  for (const ObjectReport* x : left) out.push_back({x, nullptr, 0, 0, {}, {}});
  for (const ObjectReport* y : right) out.push_back({nullptr, y, 0, 0, {}, {}});
  for (ObjectDifference& difference : out) {
    if (difference.a != nullptr) difference.error_a = ErrorOf(*difference.a, a.view);
    if (difference.b != nullptr) difference.error_b = ErrorOf(*difference.b, b.view);
  }
  return out;
}

}  // namespace

Result<RunDifference> CompareRuns(const RunReview& a, const RunReview& b) {
  if (a.header.models != b.header.models)
    return Error{ErrorCode::kInvalidInput,
                 "the two runs were made with different models; nothing can be compared"};
  RunDifference out;
  out.settings = Settings(a.header, b.header);
  std::map<int, const FrameSample*> by_frame;
  for (const auto& frame : a.history.frames) by_frame[frame->frame] = frame.get();
  for (const auto& frame : b.history.frames) {
    const auto found = by_frame.find(frame->frame);
    if (found == by_frame.end()) continue;
    ++out.common_frames;
    if (!out.first_frame && Differ(*found->second, *frame)) out.first_frame = frame->frame;
  }
  out.objects = Objects(a, b);
  std::map<std::string, StageDifference> stages;
  for (const auto& [stage, mean] : MeanStages(a)) stages[stage] = {stage, mean, 0};
  for (const auto& [stage, mean] : MeanStages(b)) {
    stages[stage].stage = stage;
    stages[stage].mean_b_ms = mean;
  }
  for (auto& [name, stage] : stages) out.stages.push_back(stage);
  return out;
}

nlohmann::json DifferenceToJson(const RunDifference& difference, const RunReview& a,
                                const RunReview& b) {
  const auto side = [](const RunReview& review, const ObjectReport* object,
                       const std::optional<TruthError>& error) -> nlohmann::json {
    if (object == nullptr) return nullptr;
    const auto label = static_cast<std::size_t>(object->label.value);
    nlohmann::json json = {
        {"id", object->id.value},
        {"model", label < review.header.models.size() ? review.header.models[label].name : ""}};
    if (error)
      json.update({{"ground_truth", error->truth},
                   {"translation_m", error->translation_m},
                   {"azimuth_deg", kDegrees * error->azimuth_rad}});
    return json;
  };
  nlohmann::json objects = nlohmann::json::array(), stages = nlohmann::json::object();
  for (const ObjectDifference& o : difference.objects)
    objects.push_back({{"a", side(a, o.a, o.error_a)},
                       {"b", side(b, o.b, o.error_b)},
                       {"distance_m", o.distance_m},
                       {"azimuth_deg", kDegrees * o.azimuth_rad}});
  for (const StageDifference& s : difference.stages)
    stages[s.stage] = {{"a", s.mean_a_ms}, {"b", s.mean_b_ms}};
  return {{"settings", difference.settings},
          {"common_frames", difference.common_frames},
          {"first_difference",
           difference.first_frame ? nlohmann::json(*difference.first_frame) : nlohmann::json()},
          {"objects", objects},
          {"timings_ms", stages}};
}

}  // namespace plumbline
