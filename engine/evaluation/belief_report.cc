// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/belief_report.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

void LabelCalibration::Add(double probability, bool label_right) {
  const double place = std::clamp(probability, 0.0, 1.0) * static_cast<double>(bins.size());
  Bin& bin = bins[std::min(bins.size() - 1, static_cast<std::size_t>(place))];
  ++bin.count;
  bin.right += label_right;
  bin.claimed += probability;
  ++count;
  right += label_right;
  claimed += probability;
}

std::optional<double> LabelCalibration::ExpectedError() const {
  if (count == 0) return std::nullopt;
  double sum = 0;
  for (const Bin& bin : bins) sum += std::abs(bin.right - bin.claimed);
  return sum / count;
}

}  // namespace plumbline
