// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/posterior_marginals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

Parameters At(const Eigen::Vector3d& center_in_cam, double azimuth_rad) {
  const double z = std::max(0.05, center_in_cam.z());
  return {{kDegPerRad * std::atan(center_in_cam.x() / z),
           kDegPerRad * std::atan(center_in_cam.y() / z), std::log(z), kDegPerRad * azimuth_rad}};
}

const SequenceView::Truth* TruthOf(const FrameContext& context) {
  for (const auto& frame : context.shown_playback().history->frames) {
    if (frame == nullptr || frame->frame != context.snapshot->report.frame) continue;
    for (const ObjectSample& sample : frame->objects) {
      if (sample.id != context.selection.object || !sample.error) continue;
      for (const SequenceView::Truth& truth : context.sequence->truth) {
        if (truth.id == sample.error->truth) return &truth;
      }
    }
  }
  return nullptr;
}

std::optional<Parameters> TruthParameters(const FrameContext& context, const ObjectReport& object,
                                          double mean_azimuth_deg) {
  const SequenceView::Truth* truth = TruthOf(context);
  if (truth == nullptr) return std::nullopt;
  const UprightFrame upright(-context.sequence->up_in_world);
  for (const ModelView& model : context.sequence->models) {
    if (model.name != truth->model) continue;
    Parameters at = At(object.world_from_reference_cam.inverse() *
                           (truth->world_from_object * (truth->scale * model.center)),
                       upright.Azimuth(truth->world_from_object.linear()));
    const double period = 360.0 / std::max(1, model.symmetry_order);
    at.value[kAzimuthAxis] =
        mean_azimuth_deg +
        (model.any_azimuth ? 0 : std::remainder(at.value[kAzimuthAxis] - mean_azimuth_deg, period));
    return at;
  }
  return std::nullopt;
}

}  // namespace

Marginals MarginalsOf(const FrameContext& context, const ObjectReport& object) {
  const std::vector<Particle>& particles = *object.particles;
  const UprightFrame upright(-context.sequence->up_in_world);
  const double around = kDegPerRad * upright.Azimuth(object.world_from_object.linear());
  std::vector<Parameters> places;
  std::vector<double> weights;
  double sum = 0;
  for (const Particle& p : particles) {
    const double z = std::exp(double{p.rho});
    places.push_back(At({z * p.x_c, z * p.y_c, z}, p.azimuth));
    double& azimuth = places.back().value[kAzimuthAxis];
    azimuth = around + std::remainder(azimuth - around, 360.0);
    weights.push_back(std::exp(double{p.log_weight}));
    sum += weights.back();
  }
  Marginals result;
  result.truth = TruthParameters(context, object, around);
  for (int axis = 0; axis < 4; ++axis) {
    double mean = 0, square = 0, low = 1e9, high = -1e9;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double v = places[i].value[axis];
      mean += weights[i] / sum * v;
      square += weights[i] / sum * v * v;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    const double reach = std::max(high - low, kParameterAxes[axis].least_reach);
    // A truth not far outside widens the axis; one further off is named in words.
    if (result.truth && std::abs(result.truth->value[axis] - mean) < 2 * reach) {
      low = std::min(low, result.truth->value[axis]);
      high = std::max(high, result.truth->value[axis]);
    }
    const double middle = 0.5 * (low + high);
    const double half = 0.54 * std::max(high - low, kParameterAxes[axis].least_reach);
    result.low[axis] = middle - half;
    result.high[axis] = middle + half;
    result.mean[axis] = mean;
    result.std[axis] = std::sqrt(std::max(0.0, square - mean * mean));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const int bin =
          static_cast<int>(kMarginalBins * (places[i].value[axis] - result.low[axis]) / (2 * half));
      result.share[axis][std::clamp(bin, 0, kMarginalBins - 1)] += weights[i] / sum;
    }
  }
  return result;
}

}  // namespace plumbline
