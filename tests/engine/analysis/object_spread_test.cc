// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/object_spread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

PoseMode ModeAt(double x_m, double azimuth_rad, double weight, double position_std_m = 0.03,
                double azimuth_std_rad = 0.05) {
  PoseMode mode;
  mode.label = {0};
  mode.weight = weight;
  mode.world_from_object =
      Eigen::Translation3d(x_m, 0, 0) * Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitZ());
  mode.position_std_m = position_std_m;
  mode.azimuth_std_rad = azimuth_std_rad;
  return mode;
}

ObjectReport ObjectWith(std::vector<PoseMode> modes) {
  ObjectReport object;
  object.label = {0};
  object.covariance.diagonal() << 0.0003, 0.0003, 0.0003, 0.0025;  // as the modes above
  object.world_from_object = modes.front().world_from_object;
  object.modes = std::move(modes);
  return object;
}

SequenceView ViewOf(int symmetry_order, bool any_azimuth) {
  SequenceView view;
  ModelView model;
  model.symmetry_order = symmetry_order;
  model.any_azimuth = any_azimuth;
  view.models = {model};
  return view;
}

TEST(ObjectSpread, IsThatOfTheCovarianceWithOneMode) {
  const ObjectSpread spread = SpreadOf(ObjectWith({ModeAt(1, 0.3, 1)}), ViewOf(1, false));
  EXPECT_NEAR(spread.position_std_m, 0.03, 1e-12);
  EXPECT_NEAR(spread.azimuth_std_rad.value(), 0.05, 1e-12);
  EXPECT_EQ(spread.modes, 1);
}

TEST(ObjectSpread, CountsTheDistanceBetweenModes) {
  const ObjectSpread spread =
      SpreadOf(ObjectWith({ModeAt(0, 0, 0.5), ModeAt(0.8, 0.2, 0.5)}), ViewOf(1, false));
  EXPECT_NEAR(spread.position_std_m, std::hypot(0.4, 0.03), 1e-12);
  // Small angles: as on a line, to second order.
  EXPECT_NEAR(spread.azimuth_std_rad.value(), std::hypot(0.1, 0.05), 1e-3);
}

TEST(ObjectSpread, TakesWeightsAsSharesOfWhatIsReported) {
  const ObjectSpread whole =
      SpreadOf(ObjectWith({ModeAt(0, 0, 0.75), ModeAt(1, 0, 0.25)}), ViewOf(1, false));
  const ObjectSpread part =
      SpreadOf(ObjectWith({ModeAt(0, 0, 0.6), ModeAt(1, 0, 0.2)}), ViewOf(1, false));
  EXPECT_NEAR(whole.position_std_m, part.position_std_m, 1e-12);
  EXPECT_NEAR(whole.position_std_m, std::sqrt(0.25 * 0.75 + 0.0009), 1e-12);
}

TEST(ObjectSpread, KnowsNothingOfAnAzimuthThatMayBeTurnedAbout) {
  const std::vector<PoseMode> modes = {ModeAt(0, 0, 0.5), ModeAt(0, std::numbers::pi, 0.5)};
  EXPECT_NEAR(SpreadOf(ObjectWith(modes), ViewOf(1, false)).azimuth_std_rad.value(),
              std::numbers::pi / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(SpreadOf(ObjectWith(modes), ViewOf(2, false)).azimuth_std_rad.value(), 0.05, 1e-9)
      << "turned about, it looks the same";
}

TEST(ObjectSpread, CountsParticlesThatAreInNoMode) {
  ObjectReport object = ObjectWith({ModeAt(0, 0, 0.6)});
  Particle near, far;
  near.rho = far.rho = 0;  // 1 m ahead
  near.log_weight = std::log(0.6f);
  far.log_weight = std::log(0.4f);
  far.x_c = 0.5f;
  far.azimuth = 0.4f;
  object.particles = std::make_shared<const std::vector<Particle>>(std::vector{near, far});
  const ObjectSpread spread = SpreadOf(object, ViewOf(1, false));
  EXPECT_NEAR(spread.position_std_m, 0.5 * std::sqrt(0.6 * 0.4), 1e-6);
  // As on a line, to second order in the angle.
  EXPECT_NEAR(spread.azimuth_std_rad.value(), 0.4 * std::sqrt(0.6 * 0.4), 5e-3);
  EXPECT_NEAR(SpreadOfModes(object, ViewOf(1, false)).position_std_m, 0.03, 1e-9);
}

TEST(ObjectSpread, HasNoAzimuthOfARoundShape) {
  EXPECT_FALSE(SpreadOf(ObjectWith({ModeAt(0, 0, 1)}), ViewOf(1, true)).azimuth_std_rad);
  EXPECT_FALSE(SpreadOf(ObjectWith({ModeAt(0, 0, 0.5), ModeAt(1, 1, 0.5)}), ViewOf(1, true))
                   .azimuth_std_rad);
}

}  // namespace
}  // namespace plumbline
