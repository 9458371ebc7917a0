// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/options.h"

namespace plumbline {

/// Everything that can be chosen about closing loops; docs/algorithms/vio.md, "Coming back".
struct LoopOptions {
  // Key frames
  double key_move_m = 0.25;
  double key_turn_deg = 15;
  int key_corners = 500;
  int key_frames_kept = 1500;

  // Search
  double loop_min_age_s = 10;
  double loop_reach_m = 2.5;
  int loop_min_matches = 18;

  // Verification
  double loop_match_px = 4;
  int loop_min_inliers = 16;
  double loop_max_tilt_deg = 4;
  double loop_gate_probability = 0.999;
  double loop_agree_s = 4;
  double loop_gate_factor = 3.3;

  // Weights
  double loop_drift_factor = 1;
  double loop_std_m = 0.02;
  double loop_std_deg = 0.3;
};

template <class Visitor>
void VisitFields(LoopOptions& o, Visitor&& visit) {
  visit(o.key_move_m,
        {"key_move_m", "m", "a key frame each time the body has moved so far", 0.01, 10});
  visit(o.key_turn_deg,
        {"key_turn_deg", "deg", "a key frame each time the camera has turned so far", 1, 180});
  visit(o.key_corners, {"key_corners", "", "described in each key frame", 50, 5000});
  visit(o.key_frames_kept,
        {"key_frames_kept", "",
         "can be come back to; of more, those that are nearest to an older one are let go of", 50,
         1000000});
  visit(o.loop_min_age_s,
        {"loop_min_age_s", "s", "younger key frames are not come back to", 0, 1e6});
  visit(o.loop_reach_m, {"loop_reach_m", "m",
                         "key frames are looked for so far beyond what drift allows", 0, 1000});
  visit(o.loop_min_matches,
        {"loop_min_matches", "", "points of a key frame that look alike", 4, 1000});
  visit(o.loop_match_px, {"loop_match_px", "px", "a seen-again point lies this close", 0.5, 50});
  visit(o.loop_min_inliers, {"loop_min_inliers", "", "points that agree on a pose", 4, 1000});
  visit(o.loop_max_tilt_deg, {"loop_max_tilt_deg", "deg",
                              "between gravity as the filter and as the points have it", 0.1, 180});
  visit(o.loop_gate_probability, {"loop_gate_probability", "",
                                  "of a true loop to be within what drift allows", 0.5, 0.9999999});
  visit(o.loop_agree_s,
        {"loop_agree_s", "s", "within which a second key frame must say the same", 0, 1000});
  visit(o.loop_gate_factor,
        {"loop_gate_factor", "",
         "times the standard deviations of the poses: a loop that is farther off is false", 0.1,
         1000});
  visit(o.loop_drift_factor,
        {"loop_drift_factor", "",
         "times the standard deviations of the poses: what weighs against loops; "
         "beyond it, twice as many "
         "key frames must agree",
         0.1, 100});
  visit(o.loop_std_m, {"loop_std_m", "m", "of a loop, whatever its points say", 1e-4, 10});
  visit(o.loop_std_deg, {"loop_std_deg", "deg", "of a loop, whatever its points say", 1e-3, 90});
}

}  // namespace plumbline
