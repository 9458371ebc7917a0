// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "engine/models/model_database.h"

namespace plumbline {

/// Which steps in depth of a model are contour.
struct ContourStep {
  double near_m = 0.04;
  double far_m = 0.04;      ///< Of views from `far_view_m` on.
  double far_view_m = 2.5;  ///< From the camera to the model's centre.
  double of_radius = 0.3;   ///< At most, of the model's bounding radius: small things have less.

  /// The least step [m] that is contour, of a model of this bounding radius from this distance.
  double Of(double distance_m, double radius_m) const {
    return std::min(distance_m < far_view_m ? near_m : far_m, of_radius * radius_m);
  }
};

/// What has a back has a front, whose handles and boards stand out by a few centimetres and show
/// few edges from afar or none; as contour they speak for the plain back instead
/// (docs/algorithms/semantic_filter.md#relief).
inline ContourStep ContourStepOf(const CadModel& model) {
  ContourStep step;
  if (model.back) step.far_m = 0.08;
  return step;
}

}  // namespace plumbline
