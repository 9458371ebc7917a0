// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/bop_recall.h"

namespace plumbline {

BopRecall BopRecallOf(const std::vector<BopErrors>& errors, int targets) {
  BopRecall recall;
  recall.targets = targets;
  recall.estimated = static_cast<int>(errors.size());
  if (targets == 0) return recall;
  for (const BopErrors& of : errors) {
    for (const double threshold : kBopShares) {
      for (const double vsd : of.vsd) recall.vsd += vsd < threshold;
      recall.mssd += of.mssd_share < threshold;
      recall.mspd += of.mspd_at_640_px < threshold * kBopPixels;
    }
  }
  const double thresholds = static_cast<double>(kBopShares.size()) * targets;
  recall.vsd /= thresholds * static_cast<double>(kBopShares.size());
  recall.mssd /= thresholds;
  recall.mspd /= thresholds;
  return recall;
}

}  // namespace plumbline
