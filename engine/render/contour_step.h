// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace plumbline {

/// Which steps in depth of a model are contour. From afar only those count that are larger: handles
/// and boards that stand out by a few centimetres show few edges there or none
/// (docs/algorithms/semantic_filter.md#relief).
struct ContourStep {
  double near_m = 0.04;
  double far_m = 0.08;      ///< Of views from `far_view_m` on.
  double far_view_m = 2.5;  ///< From the camera to the model's centre.
  double of_radius = 0.3;   ///< At most, of the model's bounding radius: small things have less.

  /// The least step [m] that is contour, of a model of this bounding radius from this distance.
  double Of(double distance_m, double radius_m) const {
    return std::min(distance_m < far_view_m ? near_m : far_m, of_radius * radius_m);
  }
};

}  // namespace plumbline
