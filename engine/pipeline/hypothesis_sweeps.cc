// SPDX-License-Identifier: Apache-2.0
// The score over one or two parameters of a pose about the mean.

#include <numbers>
#include <utility>

#include "engine/geometry/angles.h"
#include "engine/pipeline/hypothesis_frame.h"

namespace plumbline {
namespace {

constexpr int kSliceSteps = 61, kMapSteps = 41;

}  // namespace

std::vector<HypothesisProbe::Axis> HypothesisProbe::Axes(const Frame& frame,
                                                         const ProbeView& view) {
  const Eigen::Isometry3d& world_from_cam = frame.world_from_axes;
  const ProbedHypothesis& mean = view.hypotheses.front();
  const Eigen::Vector3d ray = (mean.center_in_world - world_from_cam.translation()).normalized();
  std::vector<Axis> axes = {{"sideways", "cm", 0.3, 100, world_from_cam.linear().col(0)},
                            {"down", "cm", 0.3, 100, world_from_cam.linear().col(1)},
                            {"distance", "cm", 0.5, 100, ray},
                            {"azimuth", "\u00b0", std::numbers::pi, 1 / kRadPerDeg, {0, 0, 0}}};
  if (frame.truth == nullptr) return axes;
  for (Axis& axis : axes) {
    const double offset =
        axis.turns()
            ? -frame.AzimuthFromTruth(mean.azimuth_rad)
            : (frame.truth_hypothesis.center_in_world - mean.center_in_world).dot(axis.direction);
    axis.truth = static_cast<float>(offset * axis.per_unit);
  }
  return axes;
}

void HypothesisProbe::AddSlices(const Frame& frame, const HypothesisScorer* reference,
                                ProbeView& view) const {
  const ProbedHypothesis& mean = view.hypotheses.front();
  for (const Axis& axis : Axes(frame, view)) {
    LikelihoodSlice slice{axis.name, axis.unit, {}, {}, {}, {}, {}, axis.truth};
    std::vector<PoseHypothesis> poses;
    for (int i = 0; i < kSliceSteps; ++i) {
      const double offset = axis.Offset(i, kSliceSteps);
      slice.offsets.push_back(static_cast<float>(offset * axis.per_unit));
      poses.push_back({mean.label, mean.azimuth_rad, mean.center_in_world, mean.log_scale});
      axis.Move(offset, poses.back());
    }
    for (const Likelihood& likelihood : Score(frame, *scorer_, poses)) {
      slice.phi_cnn.push_back(likelihood.phi_cnn);
      slice.phi_edge.push_back(likelihood.phi_edge);
      slice.score.push_back(
          static_cast<float>(view.alpha * likelihood.phi_cnn + view.beta * likelihood.phi_edge));
    }
    if (reference != nullptr) {
      for (const Likelihood& likelihood : Score(frame, *reference, poses))
        slice.phi_edge_rendered.push_back(likelihood.phi_edge);
    }
    view.slices.push_back(std::move(slice));
  }
}

void HypothesisProbe::AddMap(const Frame& frame, const Axis& x, const Axis& y,
                             ProbeView& view) const {
  const ProbedHypothesis& mean = view.hypotheses.front();
  LikelihoodMap map{x.name, x.unit, y.name, y.unit, {}, {}, {}, {}, {}, {}};
  std::vector<PoseHypothesis> poses;
  for (int row = 0; row < kMapSteps; ++row) {
    map.x_offsets.push_back(static_cast<float>(x.Offset(row, kMapSteps) * x.per_unit));
    map.y_offsets.push_back(static_cast<float>(y.Offset(row, kMapSteps) * y.per_unit));
    for (int column = 0; column < kMapSteps; ++column) {
      poses.push_back({mean.label, mean.azimuth_rad, mean.center_in_world, mean.log_scale});
      x.Move(x.Offset(column, kMapSteps), poses.back());
      y.Move(y.Offset(row, kMapSteps), poses.back());
    }
  }
  for (const Likelihood& likelihood : Score(frame, *scorer_, poses)) {
    map.phi_cnn.push_back(likelihood.phi_cnn);
    map.phi_edge.push_back(likelihood.phi_edge);
    map.score.push_back(
        static_cast<float>(view.alpha * likelihood.phi_cnn + view.beta * likelihood.phi_edge));
  }
  if (x.truth && y.truth) map.truth = Eigen::Vector2f(*x.truth, *y.truth);
  view.maps.push_back(std::move(map));
}

}  // namespace plumbline
