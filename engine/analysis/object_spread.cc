// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/object_spread.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

const ModelView* ModelOf(const SequenceView& view, ModelId label) {
  const auto index = static_cast<std::size_t>(label.value);
  return index < view.models.size() ? &view.models[index] : nullptr;
}

Eigen::Vector3d CenterOf(const PoseMode& mode, const SequenceView& view) {
  const ModelView* model = ModelOf(view, mode.label);
  return mode.world_from_object *
         (mode.scale * (model != nullptr ? model->center : Eigen::Vector3d(0, 0, 0)));
}

/// Sums over weighted places.
class Spreading {
 public:
  /// @param order  Of the shape's symmetry.
  explicit Spreading(double order) : order_(order) {}
  void Add(double weight, const Eigen::Vector3d& center, double azimuth_rad, double position_m2 = 0,
           double azimuth_rad2 = 0) {
    weight_ += weight;
    sum_ += weight * center;
    squares_ += weight * (center.squaredNorm() + position_m2);
    resultant_ +=
        std::polar(weight * std::exp(-0.5 * order_ * order_ * azimuth_rad2), order_ * azimuth_rad);
  }
  bool empty() const { return !(weight_ > 0); }
  double position_std_m() const {
    return std::sqrt(std::max(0.0, squares_ / weight_ - (sum_ / weight_).squaredNorm()));
  }
  double azimuth_std_rad() const {
    const double unknown_rad = std::numbers::pi / std::sqrt(3.0) / order_;
    const double length = std::min(1.0, std::abs(resultant_) / weight_);
    return length > 0 ? std::min(unknown_rad, std::sqrt(-2 * std::log(length)) / order_)
                      : unknown_rad;
  }

 private:
  double order_, weight_ = 0, squares_ = 0;
  Eigen::Vector3d sum_{0, 0, 0};
  std::complex<double> resultant_ = 0;
};

Spreading SpreadingOf(const ModelView* model) {
  return Spreading(model != nullptr ? std::max(1, model->symmetry_order) : 1);
}

}  // namespace

ObjectSpread SpreadOf(const ObjectReport& object, const SequenceView& view) {
  ObjectSpread spread = SpreadOfModes(object, view);
  if (object.particles == nullptr || object.particles->empty()) return spread;
  Spreading all = SpreadingOf(ModelOf(view, object.label));
  for (const Particle& p : *object.particles) {
    const double z = std::exp(double{p.rho});
    all.Add(std::exp(double{p.log_weight}),
            object.world_from_reference_cam * Eigen::Vector3d(z * p.x_c, z * p.y_c, z), p.azimuth);
  }
  spread.position_std_m = all.position_std_m();
  if (spread.azimuth_std_rad) spread.azimuth_std_rad = all.azimuth_std_rad();
  return spread;
}

ObjectSpread SpreadOfModes(const ObjectReport& object, const SequenceView& view) {
  const ModelView* model = ModelOf(view, object.label);
  ObjectSpread spread;
  spread.object = object.id;
  spread.modes = static_cast<int>(object.modes.size());
  const double heaviest_m2 = object.covariance.topLeftCorner<3, 3>().trace();
  const double heaviest_rad2 = std::max(0.0, object.covariance(3, 3));
  spread.position_std_m = std::sqrt(heaviest_m2);
  if (model == nullptr || !model->any_azimuth) spread.azimuth_std_rad = std::sqrt(heaviest_rad2);
  if (object.modes.size() < 2) return spread;

  const UprightFrame upright(-view.up_in_world);
  Spreading all = SpreadingOf(model);
  for (std::size_t i = 0; i < object.modes.size(); ++i) {
    const PoseMode& mode = object.modes[i];
    all.Add(mode.weight, CenterOf(mode, view), upright.Azimuth(mode.world_from_object.linear()),
            i == 0 ? heaviest_m2 : mode.position_std_m * mode.position_std_m,
            i == 0 ? heaviest_rad2 : mode.azimuth_std_rad * mode.azimuth_std_rad);
  }
  if (all.empty()) return spread;
  spread.position_std_m = all.position_std_m();
  if (spread.azimuth_std_rad) spread.azimuth_std_rad = all.azimuth_std_rad();
  return spread;
}

}  // namespace plumbline
