// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/stamp_watch.h"

namespace plumbline {

StampWatch::Verdict StampWatch::Add(std::int64_t stamp_ns) {
  if (!newest_ns_ || stamp_ns > *newest_ns_) {
    if (newest_ns_) period_ns_ = stamp_ns - *newest_ns_;
    newest_ns_ = stamp_ns;
    late_ = 0;
    return Verdict::kRises;
  }
  if (late_ == 0 || stamp_ns <= last_late_ns_) {
    late_ = 0;
    first_late_ns_ = stamp_ns;
  }
  last_late_ns_ = stamp_ns;
  if (++late_ < patience_) return Verdict::kLate;
  jump_ns_ = *newest_ns_ + period_ns_ - first_late_ns_;
  newest_ns_ = stamp_ns;
  late_ = 0;
  return Verdict::kJumpedBack;
}

}  // namespace plumbline
