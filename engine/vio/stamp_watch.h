// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace plumbline {

/// Watches the stamps of a stream, which should rise.
class StampWatch {
 public:
  enum class Verdict {
    kRises,
    kLate,       ///< Not after the newest: came twice, or out of order. To be left out.
    kJumpedBack  ///< The clock was set back: this stamp begins the new time.
  };

  /// @param patience  So many stamps that rise among themselves, all of them late, are no accident.
  explicit StampWatch(int patience) : patience_(patience) {}

  Verdict Add(std::int64_t stamp_ns);

  /// By how much the clock was set back, after kJumpedBack: exact where the stream is regular and
  /// lost nothing meanwhile.
  std::int64_t jump_ns() const { return jump_ns_; }

 private:
  int patience_;
  int late_ = 0;  ///< In a row.
  std::int64_t first_late_ns_ = 0, last_late_ns_ = 0;
  std::optional<std::int64_t> newest_ns_;
  std::int64_t period_ns_ = 0;  ///< Between the newest two.
  std::int64_t jump_ns_ = 0;
};

}  // namespace plumbline
