// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// A curve over the frames, NaN where there is nothing; `bound` (empty: none) is drawn as a band.
struct InertialCurve {
  ImU32 color = 0;
  std::vector<double> values, bound;
};

struct InertialPlot {
  const char* name;
  const char* unit;
  const char* help;
  bool from_zero = false;
  std::vector<InertialCurve> curves;
};

/// Rates, biases with their bounds, innovations with their gate and the distance from the reference
/// over all frames, in the room that is left; the frame that shows is marked.
class InertialPlots {
 public:
  void Draw(const FrameContext& context);

 private:
  std::shared_ptr<const OwnPoses> of_;  ///< What `plots_` show: they are made once.
  std::vector<InertialPlot> plots_;
};

/// How far the camera is from the reference at a frame, trajectories aligned [m]; nothing without
/// one.
std::optional<double> DistanceFromReference(const SequenceView& sequence, int frame);

}  // namespace plumbline
