// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/label_history.h"

#include <algorithm>
#include <map>

namespace plumbline {
namespace {

constexpr double kLeastShown = 0.05;

/// Calls `take(frame, sample)` for every frame in which the object lives.
template <typename Take>
void ForEachSample(const RunHistory& history, ObjectId object, const Take& take) {
  for (const auto& frame : history.frames) {
    if (frame == nullptr) continue;
    for (const ObjectSample& sample : frame->objects) {
      if (sample.id == object) take(frame->frame, sample);
    }
  }
}

}  // namespace

LabelHistory LabelsOf(const RunHistory& history, ObjectId object) {
  struct Seen {
    double most = 0, sum = 0;
  };
  std::map<ModelId, Seen> seen;
  ForEachSample(history, object, [&](int, const ObjectSample& sample) {
    for (const LabelProbability& label : sample.label_probability) {
      Seen& of = seen[label.label];
      of.most = std::max(of.most, label.probability);
      of.sum += label.probability;
    }
  });
  LabelHistory result;
  for (const auto& [label, of] : seen) {
    if (of.most > kLeastShown) result.labels.push_back(label);
  }
  std::stable_sort(result.labels.begin(), result.labels.end(),
                   [&](ModelId a, ModelId b) { return seen[a].sum > seen[b].sum; });
  ForEachSample(history, object, [&](int frame, const ObjectSample& sample) {
    LabelHistory::Frame at{frame, std::vector<float>(result.labels.size())};
    for (const LabelProbability& label : sample.label_probability) {
      const auto found = std::find(result.labels.begin(), result.labels.end(), label.label);
      if (found != result.labels.end())
        at.probability[static_cast<std::size_t>(found - result.labels.begin())] =
            static_cast<float>(label.probability);
    }
    result.frames.push_back(std::move(at));
  });
  return result;
}

}  // namespace plumbline
