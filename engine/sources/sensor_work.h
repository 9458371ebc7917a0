// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// This machine's steady clock [ns], which recordings are stamped by.
std::int64_t SteadyNs();

/// What comes from a camera or an IMU is handed over as it comes, in the caller's thread, until
/// `stop` is requested or nothing more can come.
struct SensorWork {
  std::int64_t began_ns = 0;   ///< When the first image of what is played again comes.
  std::int64_t joined_ns = 0;  ///< What was played before is passed over, as a camera would.
  /// What cannot be opened is waited for, too: it was there before.
  bool patient = false;
  std::stop_token stop;
  /// Something went wrong that may pass, in one sentence.
  std::function<void(const std::string& sentence)> tell;

  /// An image, or a reading, was recorded.
  std::function<void()> came = [] {};

  /// Waits, unless `stop` is requested.
  void WaitUntil(std::int64_t time_ns) const;
  void WaitToTryAgain() const;
};

/// Whether it is a sequence that is played again, play:SEQUENCE: its stamps are on this machine's
/// clock.
bool IsPlayed(const std::string& spec);

/// The sequence of play:SEQUENCE. Errors: those of OpenSequence; kInvalidInput without frames.
Result<std::shared_ptr<const Sequence>> PlayedSequence(const std::string& spec);

}  // namespace plumbline
