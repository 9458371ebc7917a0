// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether beliefs were honest, as values: what was claimed against what was so. Definitions:
// docs/algorithms/evaluation.md.

#include <array>
#include <optional>
#include <vector>

namespace plumbline {

/// How often the most likely label was the true one, by how surely it was believed.
struct LabelCalibration {
  struct Bin {
    int count = 0, right = 0;
    double claimed = 0;  ///< Sum of the probabilities.
  };
  std::array<Bin, 10> bins;  ///< Of equal width, from 0 to 1.
  int count = 0, right = 0;  ///< Over all bins.
  double claimed = 0;

  /// @param probability  That was given to the label, in [0, 1].
  void Add(double probability, bool label_right);
  /// Mean over the labels of how far the share that is right is from the one that was claimed,
  /// both of the label's bin; nothing without labels.
  std::optional<double> ExpectedError() const;
};

/// Confirming every object whose probability of being there is at least `threshold`.
struct PrecisionRecallPoint {
  double threshold = 0;
  double precision = 0;  ///< Share of these objects that are there.
  double recall = 0;     ///< Share of what is there that they are.
};

struct PrecisionRecall {
  std::vector<PrecisionRecallPoint> points;  ///< By falling threshold; empty without objects.
  double average_precision = 0;              ///< Area under the steps.
  int truths = 0;
};

/// What the beliefs about confirmed objects claimed, against ground truth. Frames of one object
/// resemble one another, so a few hundred of them are far fewer independent trials.
struct Reliability {
  int poses = 0;                     ///< Objects in frames, with a true object to compare with.
  int within_50 = 0, within_95 = 0;  ///< Of these: the truth lies in that region of the belief.
  int objects = 0;
  /// Normalised estimation error squared: mean over objects of the mean over their frames; where an
  /// azimuth says nothing, 4/3 of that of the position. Then the interval in which it lies in 95 of
  /// 100 runs if the beliefs are honest and each object is one trial.
  double nees = 0, nees_low = 0, nees_high = 0;
  LabelCalibration labels;  ///< Of objects whose category has several models.
};

}  // namespace plumbline
