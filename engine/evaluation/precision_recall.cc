// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/precision_recall.h"

#include <algorithm>
#include <set>

namespace plumbline {

PrecisionRecall PrecisionRecallOf(std::vector<Candidate> candidates, int truths) {
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.probability > b.probability; });
  PrecisionRecall curve;
  curve.truths = truths;
  std::set<std::string> found;
  double recall = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!candidates[i].truth.empty()) found.insert(candidates[i].truth);
    const bool last_of_equals =
        i + 1 == candidates.size() || candidates[i + 1].probability < candidates[i].probability;
    if (!last_of_equals) continue;
    const auto right = static_cast<double>(found.size());
    curve.points.push_back({candidates[i].probability, right / static_cast<double>(i + 1),
                            truths > 0 ? right / truths : 0});
    curve.average_precision +=
        curve.points.back().precision * (curve.points.back().recall - recall);
    recall = curve.points.back().recall;
  }
  return curve;
}

}  // namespace plumbline
