// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/snapshot/run_history.h"

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

LabelHistory LabelsOf(const RunHistory& history, ObjectId object);

}  // namespace plumbline
