// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/analysis/run_difference.h"
#include "engine/geometry/angles.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

struct CompareArguments {
  std::string a, b, models, sequence, ground_truth, json;
};

std::string Name(const RunReview& review, const ObjectReport* object) {
  if (object == nullptr) return "-";
  const auto label = static_cast<std::size_t>(object->label.value);
  return "#" + std::to_string(object->id.value) + " " +
         (label < review.header.models.size() ? review.header.models[label].name : "?");
}

std::string Off(const std::optional<TruthError>& error) {
  if (!error) return "-";
  char text[40];
  std::snprintf(text, sizeof(text), "%.1f cm %.1f deg", 100 * error->translation_m,
                kDegPerRad * error->azimuth_rad);
  return text;
}

void Print(const RunDifference& difference, const RunReview& a, const RunReview& b) {
  std::printf("settings that differ (A / B)\n");
  if (difference.settings.empty()) std::printf("  none\n");
  for (const std::string& setting : difference.settings) std::printf("  %s\n", setting.c_str());
  std::printf("\n%d common frames; ", difference.common_frames);
  if (difference.first_frame)
    std::printf("the first difference is in frame %d\n", *difference.first_frame);
  else
    std::printf("no difference\n");
  std::printf("\n%-24s %-24s %8s %8s  %-18s %-18s\n", "A", "B", "apart cm", "deg", "A off",
              "B off");
  for (const ObjectDifference& o : difference.objects) {
    const bool both = o.a != nullptr && o.b != nullptr;
    char apart[20] = "-", turned[20] = "-";
    if (both) {
      std::snprintf(apart, sizeof(apart), "%.2f", 100 * o.distance_m);
      std::snprintf(turned, sizeof(turned), "%.2f", kDegPerRad * o.azimuth_rad);
    }
    std::printf("%-24s %-24s %8s %8s  %-18s %-18s\n", Name(a, o.a).c_str(), Name(b, o.b).c_str(),
                apart, turned, Off(o.error_a).c_str(), Off(o.error_b).c_str());
  }
  for (const MissedDifference& m : difference.missed) {
    std::printf("\nmissed: %s\n", m.truth.c_str());
    std::printf("  A  %s\n", m.why_a.empty() ? "found" : m.why_a.c_str());
    std::printf("  B  %s\n", m.why_b.empty() ? "found" : m.why_b.c_str());
  }
  std::printf("\n%-24s %10s %10s %8s\n", "mean time [ms]", "A", "B", "B / A");
  for (const StageDifference& s : difference.stages) {
    std::printf("%-24s %10.2f %10.2f", s.stage.c_str(), s.mean_a_ms, s.mean_b_ms);
    if (s.mean_a_ms > 0.005) std::printf(" %8.2f", s.mean_b_ms / s.mean_a_ms);
    std::printf("\n");
  }
}

Status Compare(const CompareArguments& arguments) {
  ConsoleWork console;
  const auto review = [&](const std::string& run) {
    return ReviewRun({run, arguments.sequence, arguments.models}, arguments.ground_truth,
                     console.context());
  };
  const auto a = review(arguments.a);
  if (!a) return a.error();
  const auto b = review(arguments.b);
  if (!b) return b.error();
  const auto difference = CompareRuns(*a, *b);
  if (!difference) return difference.error();
  if (arguments.json != "-") Print(*difference, *a, *b);
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, DifferenceToJson(*difference, *a, *b));
}

}  // namespace

void AddCompareVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* verb = app.add_subcommand(
      "compare", "Compare two runs of a sequence: settings, objects, errors, costs");
  verb->add_option("a", arguments->a, "A run file")->required()->type_name("A.plb");
  verb->add_option("b", arguments->b, "Another")->required()->type_name("B.plb");
  verb->add_option("--ground-truth", arguments->ground_truth,
                   "Ground truth (default: that of the sequence, if it has any)")
      ->type_name("FILE");
  verb->add_option("--models", arguments->models, "The models of the runs, if they have moved")
      ->type_name("DIR");
  verb->add_option("--sequence", arguments->sequence, "The sequence, if it has moved")
      ->type_name("DIR");
  verb->add_option("--json", arguments->json,
                   "Write the differences as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Compare(*arguments); }; });
}

}  // namespace plumbline
