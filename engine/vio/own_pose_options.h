// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/options.h"
#include "engine/tracking/tracker_options.h"
#include "engine/vio/loop_options.h"
#include "engine/vio/vio_options.h"

namespace plumbline {

/// What becomes of a place that is known again.
enum class LoopUse {
  kOff,        ///< Nothing: poses are the filter's own.
  kCausal,     ///< Poses from there on are corrected; earlier ones stay as they were told.
  kCorrected,  ///< The whole trajectory is corrected before anything is mapped: not causal.
};
template <>
struct EnumNames<LoopUse> {
  static constexpr std::string_view names[] = {"off", "causal", "corrected"};
};

/// Everything that can be chosen about poses that come from a sequence's own images and IMU: the
/// tracking, the filter, and when a mapper may believe them.
///
/// The camera's place on the body is taken as calibrated: what an online estimate takes from images
/// that err as a whole (a rolling shutter above all) turns the camera against gravity, and so tilts
/// a map by as much, while the trajectory of the body hardly suffers.
struct OwnPoseOptions {
  TrackerOptions tracker;
  VioOptions filter = [] {
    VioOptions options;
    options.estimate_extrinsics = false;
    return options;
  }();

  // Drift
  LoopUse loops = LoopUse::kCorrected;
  LoopOptions closing;

  // When poses serve a mapper
  double ready_tilt_deg = 3.0;
  double ready_velocity_m_s = 0.15;

  // Floor
  double floor_camera_height_m = 0.9;
  int floor_points = 30;
  double floor_spread_m = 0.06;
};

/// One flat list of names: those of the tracker, the filter, closing loops, and what lies between
/// them and the mapper.
template <class Visitor>
void VisitFields(OwnPoseOptions& o, Visitor&& visit) {
  VisitFields(o.tracker, visit);
  VisitFields(o.filter, visit);
  visit(o.loops,
        {"loops", "",
         "places known again: off, causal (correct later poses only), corrected (the whole "
         "trajectory, before mapping)"});
  VisitFields(o.closing, visit);
  visit(
      o.ready_tilt_deg,
      {"ready_tilt_deg", "deg",
       "frames wait until the standard deviation of gravity's direction is below this", 0.01, 90});
  visit(o.ready_velocity_m_s,
        {"ready_velocity_m_s", "m/s",
         "frames wait until the standard deviation of the velocity, each axis, is below this",
         0.001, 100});
  visit(o.floor_camera_height_m,
        {"floor_camera_height_m", "m",
         "nothing nearer below the camera is taken for the floor; lower for a small robot", 0, 10});
  visit(o.floor_points, {"floor_points", "", "points that a floor needs", 5, 100000});
  visit(o.floor_spread_m, {"floor_spread_m", "m",
                           "standard deviation of the heights of points on the floor", 0.005, 0.5});
}

}  // namespace plumbline
