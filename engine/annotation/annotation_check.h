// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/annotation/pose_exchange.h"

namespace plumbline {

/// Something in a document that is probably wrong.
struct AnnotationFinding {
  std::string kind;  ///< tilted, floating, sunk, interpenetrating, duplicate, unknown_model,
  ///< missing_frames, empty_crop, unmade_crop
  std::vector<std::string> instances;
  double amount = 0;  ///< Of `unit`.
  std::string unit;   ///< deg, m or frames; "" where there is no amount
  std::string sentence;
};

struct AnnotationCheckOptions {
  double tilt_deg = 0.5;
  double floor_gap_m = 0.02;  ///< For models whose support is the floor.
  double overlap_m = 0.02;    ///< Depth of one object in another.
  double duplicate_m = 0.05;  ///< Between the centres of two instances of one model.
};

/// `models`, `sequence` and `scan` may be null: then what needs them is not looked at.
std::vector<AnnotationFinding> CheckAnnotations(const AnnotationDocument& document,
                                                const ExchangeInputs& inputs,
                                                const AnnotationCheckOptions& options = {});

}  // namespace plumbline
