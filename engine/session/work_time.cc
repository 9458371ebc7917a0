// SPDX-License-Identifier: Apache-2.0
#include "engine/session/work_time.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

void WorkTime::NoteInput(double now_s, const std::optional<std::string>& object) {
  const double since_s = now_s - last_input_s_;
  last_input_s_ = now_s;
  if (object && since_s > 0 && since_s <= kLongestPause_s) seconds_[*object] += since_s;
}

double WorkTime::Of(const std::string& object) const {
  const auto found = seconds_.find(object);
  return found == seconds_.end() ? 0 : found->second;
}

double WorkTime::ToWrite(const std::string& object) const {
  // A tenth that is one but for rounding is one.
  return std::floor(10 * Of(object) + 1e-6) / 10;
}

void WorkTime::Written(const std::string& object, double seconds) {
  double& left = seconds_[object];
  left = std::max(0.0, left - seconds);
}

void WorkTime::GiveNextTo(const std::string& object) {
  const double seconds = Of(kNext);
  Forget(kNext);
  if (seconds > 0) seconds_[object] += seconds;
}

}  // namespace plumbline
