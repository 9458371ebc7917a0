// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the sources of HypothesisProbe share; nobody else includes it.

#include <memory>
#include <optional>
#include <vector>

#include "engine/mapping/key_frames.h"
#include "engine/pipeline/hypothesis_probe.h"

namespace plumbline {

/// What is known of the frame and the object that are asked about.
struct HypothesisProbe::Frame {
  MapFrame map;
  ScoringView view;
  std::unique_ptr<const FrameDetections> detections;
  const ObjectReport* object = nullptr;  ///< Null: a truth without a candidate.
  std::vector<PoseHypothesis> particles;
  float normalizer = 0, reference_normalizer = 0;
  const SequenceView::Truth* truth = nullptr;
  ObjectId explained_by;  ///< Another object than `object` is paired with the truth.
  Eigen::Isometry3d world_from_axes = Eigen::Isometry3d::Identity();  ///< What sweeps go along.
  PoseHypothesis truth_hypothesis;
  PoseHypothesis mean;          ///< Of `object`.
  OrientedTableOptions search;  ///< That the view's table is made with.

  double AzimuthFromTruth(double azimuth_rad) const {
    return AzimuthDifference(map.database->model(truth_hypothesis.label), azimuth_rad,
                             truth_hypothesis.azimuth_rad);
  }
};

/// A parameter that is swept about the mean.
struct HypothesisProbe::Axis {
  const char* name;
  const char* unit;
  double reach;     ///< In m or rad.
  double per_unit;  ///< `unit` per m or rad.
  Eigen::Vector3d direction;
  std::optional<float> truth;  ///< Offset of the true place, in `unit`.

  bool turns() const { return direction.isZero(); }
  double Offset(int step, int steps) const { return reach * (2.0 * step / (steps - 1) - 1); }
  void Move(double offset, PoseHypothesis& pose) const {
    if (turns())
      pose.azimuth_rad += offset;
    else
      pose.center_in_world += offset * direction;
  }
};

}  // namespace plumbline
