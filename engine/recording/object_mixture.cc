// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/object_mixture.h"

#include <cmath>

#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

/// Sums over weighted states, as differences from a state near them.
struct MixtureSums {
  double weight = 0;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();

  void Add(double w, const Eigen::Vector4d& difference,
           const Eigen::Matrix4d& own = Eigen::Matrix4d::Zero()) {
    weight += w;
    sum += w * difference;
    squares += w * (difference * difference.transpose() + own);
  }
  Eigen::Matrix4d Covariance() const {
    const Eigen::Vector4d mean = sum / weight;
    return squares / weight - mean * mean.transpose();
  }
};

/// What is known of a mode that is not the heaviest one.
Eigen::Matrix4d OwnCovariance(const PoseMode& mode) {
  const double axis = mode.position_std_m * mode.position_std_m / 3;
  return Eigen::Vector4d(axis, axis, axis, mode.azimuth_std_rad * mode.azimuth_std_rad)
      .asDiagonal();
}

}  // namespace

Eigen::Matrix4d MixtureCovariance(const ObjectReport& object, const UprightFrame& upright,
                                  const ModelDatabase* models) {
  if (object.modes.size() < 2) return object.covariance;
  const auto label = static_cast<std::size_t>(object.label.value);
  const bool known = models != nullptr && label < models->models().size();
  const int order = known ? models->models()[label].symmetry.order : 1;
  const double azimuth = upright.Azimuth(object.world_from_object.linear());
  const Eigen::Vector3d place = object.world_from_object.translation();
  const auto difference = [&](const Eigen::Vector3d& at, double azimuth_rad) {
    const double turn = order == 0 ? 0 : WrapAngle((azimuth_rad - azimuth) * order) / order;
    Eigen::Vector4d state;
    state << at - place, turn;
    return state;
  };
  MixtureSums all;
  if (object.particles != nullptr) {
    for (const Particle& p : *object.particles) {
      const double z = std::exp(double{p.rho});
      all.Add(std::exp(double{p.log_weight}),
              difference(object.world_from_reference_cam * Eigen::Vector3d(z * p.x_c, z * p.y_c, z),
                         p.azimuth));
    }
  }
  if (all.weight > 0) return all.Covariance();
  for (std::size_t i = 0; i < object.modes.size(); ++i) {
    const PoseMode& mode = object.modes[i];
    all.Add(mode.weight,
            difference(mode.world_from_object.translation(),
                       upright.Azimuth(mode.world_from_object.linear())),
            i == 0 ? object.covariance : OwnCovariance(mode));
  }
  return all.weight > 0 ? all.Covariance() : object.covariance;
}

}  // namespace plumbline
