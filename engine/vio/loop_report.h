// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace plumbline {

/// A place that was known again.
struct LoopClosure {
  int image = 0;         ///< At which it was seen again; index in the source.
  int old_image = 0;     ///< The key frame that it was known by.
  int closed_image = 0;  ///< At which others had confirmed it.
  int inliers = 0;       ///< Points that agree.
  /// What the present pose moved by when the loop was closed, about up and along.
  double moved_m = 0, turned_deg = 0;
  double trust = 1;  ///< In the end, 0 to 1: its switch in the pose graph.
  int epoch = 0;     ///< Of the trajectory from here on; rises with each correction.
};

/// What coming back did for a trajectory.
struct LoopReport {
  bool has_images = false;  ///< Without images nothing is known again.
  int key_frames = 0;
  int alike = 0;        ///< Key frames that looked like an older one ...
  int turned_away = 0;  ///< ... whose pose by its points was farther off than drift can be ...
  int unconfirmed = 0;  ///< ... or that no second key frame confirmed.
  std::vector<LoopClosure> closures;
  int epochs = 0;  ///< Corrections of the trajectory.
  /// What the whole moved a pose by at most, and the last one.
  double largest_move_m = 0, largest_turn_deg = 0, last_move_m = 0, last_turn_deg = 0;
  double ms = 0;     ///< Of all key frames.
  double bytes = 0;  ///< That key frames hold.

  /// Closures that the graph still believes.
  int believed() const {
    int count = 0;
    for (const LoopClosure& closure : closures) count += closure.trust >= 0.5;
    return count;
  }
  /// Corrections up to an image, itself included: the epoch of a causal pose.
  int EpochAt(int image) const {
    int epoch = 0;
    for (const LoopClosure& closure : closures) {
      if (closure.closed_image <= image && closure.epoch > epoch) epoch = closure.epoch;
    }
    return epoch;
  }
};

/// For results and run files. What is missing from the second is left at its default; throws
/// std::exception for values of another type and whole numbers that do not fit.
nlohmann::json ToJson(const LoopReport& report);
LoopReport LoopReportFromJson(const nlohmann::json& json);

}  // namespace plumbline
