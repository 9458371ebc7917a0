// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/options.h"

namespace plumbline {

/// Everything that can be chosen about tracking points from image to image.
struct TrackerOptions {
  int points = 160;
  double spacing_px = 22;
  int window_px = 17;
  int levels = 3;
  double round_trip_px = 0.7;
  double corner_quality = 0.005;
};

template <class Visitor>
void VisitFields(TrackerOptions& o, Visitor&& visit) {
  visit(o.points, {"points", "", "tracked at a time", 8, 2000});
  visit(o.spacing_px, {"spacing_px", "px", "between new points, at an image width of 640", 3, 200});
  visit(o.window_px, {"window_px", "px", "side of the patch that is followed", 5, 51});
  visit(o.levels, {"levels", "", "of the image pyramid above the image itself", 0, 6});
  visit(o.round_trip_px,
        {"round_trip_px", "px", "tracked forth and back, a point returns this closely", 0.05, 20});
  visit(o.corner_quality,
        {"corner_quality", "", "of a new point, as a share of the best in the image", 1e-5, 0.5});
}

}  // namespace plumbline
