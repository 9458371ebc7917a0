// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the history of a run says of one object. engine/analysis works it out.

#include <array>
#include <vector>

#include "engine/base/ids.h"

namespace plumbline {

/// Whether the filter knows what it does not know: what it claimed in the frames of a run, against
/// ground truth. Frames of one object resemble one another, so a few hundred of them are far fewer
/// independent trials.
struct Reliability {
  int poses = 0;                     ///< Objects in frames, with a true object to compare with.
  int within_50 = 0, within_95 = 0;  ///< Of these: the truth lies in that region of the belief.
  /// By how surely the most likely shape was believed: how often that was the true one.
  struct Bin {
    double above = 0;  ///< Probability of the bin's lower edge; up to that of the next bin.
    int labels = 0, right = 0;
    double claimed = 0;  ///< Sum of the probabilities.
  };
  std::array<Bin, 5> bins = {{{0}, {0.5}, {0.7}, {0.9}, {0.99}}};
  int labels = 0, right = 0;  ///< Over all bins.
  double claimed = 0;         ///< Mean probability of the most likely shape; 0 without any.
};

/// What an object was believed to be, frame by frame.
struct LabelHistory {
  std::vector<ModelId> labels;  ///< Those that ever had more than 5 %, by falling sum.
  struct Frame {
    int frame = 0;
    std::vector<float> probability;  ///< Of each of `labels`; the rest to 1 is that of others.
  };
  std::vector<Frame> frames;  ///< In which the object lives.
};

struct ObjectHistory {
  ObjectId object;
  LabelHistory labels;
  Reliability of_object, of_all;
};

}  // namespace plumbline
