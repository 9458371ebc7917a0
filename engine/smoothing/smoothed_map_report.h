// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the second pass over a recording found, as values: the run file stores it beside the run.

#include <vector>

#include "engine/mapping/map_report.h"

namespace plumbline {

/// An object as all frames together have it.
struct SmoothedObject {
  /// As of the run, where the second pass says nothing else. `first_frame` is the first look that
  /// shows the object, before or after it was spawned; `log_evidence` is over all looks; without
  /// `confirmed_frame`, a confirmed object was confirmed by the second pass alone. No particles.
  ObjectReport belief;
  int spawned_frame = 0;  ///< When the run first had it.
  int looks = 0;          ///< That show it, over the whole recording.
  int looks_before = 0;   ///< Of these, before it was spawned.
  int views = 0;          ///< That its pose was refined in.
  bool refined = false;   ///< By its outline in the images; else the pose is the sampled one.
  double agreement = 0;   ///< Of its outline with the edges of these views, in [0, 1].
  double pushed_m = 0;    ///< By what stands in the same place and by the floor.
};

struct SmoothedMap {
  int last_frame = 0;         ///< Of the run that it belongs to.
  int looks = 0;              ///< Independent looks that the recording amounts to.
  int floor_objects = 0;      ///< That share the floor; 0: nothing below applies.
  double floor_height_m = 0;  ///< Of the floor they share above the one that the run was given.
  double floor_std_m = 0;
  std::vector<SmoothedObject> objects;  ///< By id; confirmed and tentative ones.
};

}  // namespace plumbline
