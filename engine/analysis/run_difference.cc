// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/run_difference.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <utility>

#include "engine/analysis/history.h"
#include "engine/analysis/missed_truths.h"
#include "engine/geometry/angles.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

std::vector<ObjectDifference> Objects(const RunReview& a, const RunReview& b) {
  std::vector<ObjectDifference> out;
  const auto errors_a = ErrorsOf(*a.last, a.view), errors_b = ErrorsOf(*b.last, b.view);
  const auto place = [](const ObjectReport* object, const FrameReport& report) {
    return static_cast<std::size_t>(object - report.objects.data());
  };
  for (const ObjectPair& pair : PairObjects(*a.last, *b.last, a.view.up_in_world)) {
    ObjectDifference difference{pair, {}, {}};
    if (pair.a != nullptr) difference.error_a = errors_a[place(pair.a, *a.last)];
    if (pair.b != nullptr) difference.error_b = errors_b[place(pair.b, *b.last)];
    out.push_back(difference);
  }
  return out;
}

std::vector<MissedDifference> Missed(const RunReview& a, const RunReview& b) {
  std::vector<MissedDifference> out;
  const TruthsView truths_a = TruthsOf(a), truths_b = TruthsOf(b);
  for (const TruthView& truth : truths_a.truths) {
    const TruthView* other = FindTruth(truths_b, truth.id);
    if (other == nullptr || (truth.found && other->found)) continue;
    out.push_back({truth.id, truth.found ? "" : truth.text, other->found ? "" : other->text});
  }
  return out;
}

}  // namespace

std::vector<std::string> DifferentSettings(const RunHeader& a, const RunHeader& b) {
  std::vector<std::string> out;
  const auto compare = [&](const std::string& name, const std::string& p, const std::string& q) {
    if (p != q) out.push_back(name + ": " + p + " / " + q);
  };
  const RunRecipe &x = a.recipe, &y = b.recipe;
  compare("seed", std::to_string(x.seed), std::to_string(y.seed));
  // Where a file lies says nothing; its content does.
  const auto compare_inputs = [&](const std::string& name, const auto& p, const auto& q) {
    if (!p.SameContent(q)) out.push_back(name + ": " + ToText(p) + " / " + ToText(q));
  };
  compare_inputs("edges", x.edges.value_or(EdgeChoice()), y.edges.value_or(EdgeChoice()));
  compare_inputs("detector", x.detector.value_or(DetectorChoice()),
                 y.detector.value_or(DetectorChoice()));
  compare_inputs("poses", x.poses, y.poses);
  const auto pace = [](const RunRecipe& recipe) {
    return recipe.live_speed ? fmt::format("live, speed {:g}", *recipe.live_speed)
                             : std::string("every frame");
  };
  compare("pace", pace(x), pace(y));
  compare("scorer", std::string(NameOf(x.scorer)), std::string(NameOf(y.scorer)));
  if (a.sequence_hash != b.sequence_hash)
    out.push_back("sequence: " + x.sequence.string() + " / " + y.sequence.string());
  compare("program", a.program_version, b.program_version);
  const auto options_a = OptionsToJson(x.options).flatten(),
             options_b = OptionsToJson(y.options).flatten();
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

std::vector<std::string> ChangesOnTheWay(const char* run, const RunHeader& header,
                                         const std::vector<RunEvent>& events) {
  std::vector<std::string> out;
  for (const RunEvent& event : events) {
    // What a fork took over is that of another run.
    if (event.event.kind == EventKind::kOptionsChanged &&
        event.frame > header.forked_after.value_or(-1))
      out.push_back(std::string(run) + " run, from frame " + std::to_string(event.frame) + ": " +
                    event.event.text);
  }
  return out;
}

Result<RunDifference> CompareRuns(const RunReview& a, const RunReview& b) {
  if (a.header.models != b.header.models)
    return Error{ErrorCode::kInvalidInput,
                 "the two runs were made with different models; nothing can be compared"};
  RunDifference out;
  out.settings = DifferentSettings(a.header, b.header);
  for (const auto& changes :
       {ChangesOnTheWay("first", a.header, a.events), ChangesOnTheWay("other", b.header, b.events)})
    out.settings.insert(out.settings.end(), changes.begin(), changes.end());
  std::set<int> frames;
  for (const auto& frame : a.history.frames) frames.insert(frame->frame);
  for (const auto& frame : b.history.frames) out.common_frames += int(frames.count(frame->frame));
  out.first_frame = FirstDifference(a.history, b.history);
  out.objects = Objects(a, b);
  out.missed = Missed(a, b);
  out.stages = CompareStages(a.history, b.history);
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
                   {"azimuth_deg", kDegPerRad * error->azimuth_rad}});
    return json;
  };
  nlohmann::json missed = nlohmann::json::array();
  for (const MissedDifference& m : difference.missed)
    missed.push_back({{"ground_truth", m.truth}, {"why_a", m.why_a}, {"why_b", m.why_b}});
  nlohmann::json objects = nlohmann::json::array(), stages = nlohmann::json::object();
  for (const ObjectDifference& o : difference.objects)
    objects.push_back({{"a", side(a, o.a, o.error_a)},
                       {"b", side(b, o.b, o.error_b)},
                       {"distance_m", o.distance_m},
                       {"azimuth_deg", kDegPerRad * o.azimuth_rad}});
  for (const StageDifference& s : difference.stages)
    stages[s.stage] = {{"a", s.mean_a_ms}, {"b", s.mean_b_ms}};
  return {{"settings", difference.settings},
          {"common_frames", difference.common_frames},
          {"first_difference",
           difference.first_frame ? nlohmann::json(*difference.first_frame) : nlohmann::json()},
          {"objects", objects},
          {"missed", missed},
          {"timings_ms", stages}};
}

}  // namespace plumbline
