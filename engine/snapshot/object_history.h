// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the history of a run says of one object. engine/analysis works it out.

#include <vector>

#include "engine/base/ids.h"
#include "engine/evaluation/belief_report.h"

namespace plumbline {

/// What an object was believed to be, frame by frame.
struct LabelHistory {
  std::vector<ModelId> labels;  ///< Those that ever had more than 5 %, by falling sum.
  struct Frame {
    int frame = 0;
    std::vector<float> probability;  ///< Of each of `labels`; the rest to 1 is that of others.
  };
  std::vector<Frame> frames;  ///< In which the object lives.
};

/// Whether the beliefs of a run are reliable: pooled, and about each object that was judged, by id.
struct RunReliability {
  struct OfObject {
    ObjectId object;
    Reliability reliability;
  };
  Reliability all;
  std::vector<OfObject> objects;
};

struct ObjectHistory {
  ObjectId object;
  LabelHistory labels;
  RunReliability reliability;
  PrecisionRecall confirmation;  ///< Of the objects of the newest frame.
};

}  // namespace plumbline
