// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a recording that is played by the clock fared: values only, so that the snapshot may hold it.

namespace plumbline {

/// Counts are of frames that have come so far: came = taken + passed_over. Ages are by the wall
/// clock, from when a frame came as from a camera.
struct LiveReport {
  double speed = 1;         ///< Times as fast as it was recorded.
  int taken = 0;            ///< The newest at their time: given to the consumer.
  int done = 0;             ///< Of those, what the consumer is done with.
  int passed_over = 0;      ///< Something newer had come before they could be taken.
  double recorded_s = 0;    ///< From the first that came to the newest, by their stamps.
  double taken_age_ms = 0;  ///< Mean, when they were taken.
  double done_age_ms = 0;   ///< Mean, when the consumer was done with them.

  int came() const { return taken + passed_over; }
};

}  // namespace plumbline
