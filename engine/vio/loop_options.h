// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/options.h"

namespace plumbline {

/// Everything that can be chosen about closing loops; docs/algorithms/vio.md, "Coming back".
struct LoopOptions {
  // Key frames
  double key_move_m = 0.25;
  double key_turn_deg = 15;
  int corners = 500;

  // Search
  double min_age_s = 10;
  double reach_m = 2.5;
  int min_matches = 18;

  // Verification
  double match_px = 4;
  int min_inliers = 16;
  double max_tilt_deg = 4;
  double gate_probability = 0.999;
  double agree_s = 4;

  // Weights
  double drift_factor = 3;
  double loop_std_m = 0.02;
  double loop_std_deg = 0.3;
};

template <class Visitor>
void VisitFields(LoopOptions& o, Visitor&& visit) {
  visit(o.key_move_m, {"key_move_m", "m", "a key frame each time the body has moved so far", 0.01, 10});
  visit(o.key_turn_deg,
        {"key_turn_deg", "deg", "a key frame each time the camera has turned so far", 1, 180});
  visit(o.corners, {"corners", "", "described in each key frame", 50, 5000});
  visit(o.min_age_s, {"min_age_s", "s", "younger key frames are not come back to", 0, 1e6});
  visit(o.reach_m,
        {"reach_m", "m", "key frames are looked for so far beyond what drift allows", 0, 1000});
  visit(o.min_matches, {"min_matches", "", "points of a key frame that look alike", 4, 1000});
  visit(o.match_px, {"match_px", "px", "a seen-again point lies this close", 0.5, 50});
  visit(o.min_inliers, {"min_inliers", "", "points that agree on a pose", 4, 1000});
  visit(o.max_tilt_deg,
        {"max_tilt_deg", "deg", "between gravity as the filter and as the points have it", 0.1, 180});
  visit(o.gate_probability,
        {"gate_probability", "", "of a true loop to be within what drift allows", 0.5, 0.9999999});
  visit(o.agree_s, {"agree_s", "s", "within which a second key frame must say the same", 0, 1000});
  visit(o.drift_factor,
        {"drift_factor", "", "times the filter's standard deviations: what it is overconfident by",
         0.1, 100});
  visit(o.loop_std_m, {"loop_std_m", "m", "of a loop, whatever its points say", 1e-4, 10});
  visit(o.loop_std_deg, {"loop_std_deg", "deg", "of a loop, whatever its points say", 1e-3, 90});
}

}  // namespace plumbline
