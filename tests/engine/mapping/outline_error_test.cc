// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_error.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

constexpr double kStd_m = 0.02, kMetresPerPixel = 0.004;

/// Edges that are best explained where x is `kMetresPerPixel` for every pixel that they are farther
/// outside on the right than on the left and y the same for every pixel below, with the curvature
/// that gives x the deviation `kStd_m` and y half of it with beta = 10 and one view.
class LineScorer : public HypothesisScorer {
 public:
  void Score(const ScoringView& view, const UprightFrame&,
             std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override {
    for (std::size_t i = 0; i < scores.size(); ++i) {
      const auto& [right, below, left, above] = view.outline_offsets_px;
      const Eigen::Vector2d best =
          kMetresPerPixel * 500 / view.camera.fx * Eigen::Vector2d(right - left, below);
      const Eigen::Vector2d off = (hypotheses[i].center_in_world.head<2>() - best) / kStd_m;
      scores[i].agreement_m =
          static_cast<float>(-0.5 * (off.x() * off.x() + 4 * off.y() * off.y()) / 10);
      scores[i].visible_m = scores[i].total_m = 1;
    }
  }
};

// A normal likelihood whose mean follows the offset is its own closed form: so does the posterior's
// mean, less what a prior holds back.
TEST(OutlineSensitivity, IsByHowMuchTheMeanOfTheBeliefFollows) {
  const std::shared_ptr<const ModelDatabase> database = MakeFurnitureDatabase();
  const MapFrame map{UprightFrame({0, 0, -1}), {}, database};
  MapperOptions options;
  options.view_correlation = 0;
  const PoseHypothesis mean{database->Find("chair").value(), 0.2, {0, 0, 0.5}};
  JudgingView view;
  view.view.camera = {320, 240, 250, 250, 159.5, 119.5};
  view.normalizer = 1;
  Random random({.seed = 5});
  for (const double prior_std_m : {1e3, kStd_m}) {
    const double posterior = 1 / (1 / (kStd_m * kStd_m) + 1 / (prior_std_m * prior_std_m));
    std::vector<PoseHypothesis> drawn(20000, mean);
    for (PoseHypothesis& hypothesis : drawn) {
      hypothesis.center_in_world.x() += std::sqrt(posterior) * random.Gaussian();
      hypothesis.center_in_world.y() += 0.5 * kStd_m * random.Gaussian();
      hypothesis.azimuth_rad += 0.03 * random.Gaussian();
    }
    const Eigen::Matrix4d moved =
        OutlineSensitivity(LineScorer(), map, {view}, drawn, mean, options, 1);
    const double expected = kMetresPerPixel * posterior / (kStd_m * kStd_m);
    Eigen::Matrix4d sides = Eigen::Matrix4d::Zero();
    sides.row(0) << expected, 0, -expected, 0;
    sides(1, 1) = kMetresPerPixel;
    EXPECT_TRUE(moved.topRows<3>().isApprox(sides.topRows<3>(), 0.04)) << moved;
    EXPECT_LT(moved.row(3).cwiseAbs().maxCoeff(), 0.003);
    // Twice the views against the prior: it follows more.
    const Eigen::Matrix4d sharper =
        OutlineSensitivity(LineScorer(), map, {view, view}, drawn, mean, options, 1);
    EXPECT_TRUE(sharper.isApprox(2 * moved, 1e-9)) << "of the same spread";
  }
  EXPECT_TRUE(OutlineSensitivity(LineScorer(), map, {view}, {}, mean, options, 1).isZero(0));
}

// Sides that are off alike cancel in x; sides that are off by themselves do not.
TEST(OutlineCovariance, IsOfOffsetsAllAroundAndOfEachSide) {
  Eigen::Matrix4d sides = Eigen::Matrix4d::Zero();
  sides.row(0) << 0.003, 0, -0.003, 0;
  sides.row(1) << 0, 0.002, 0, 0;
  const Eigen::Matrix4d alike = OutlineCovariance(sides, 2, 0),
                        own = OutlineCovariance(sides, 0, 2);
  EXPECT_NEAR(alike(0, 0), 0, 1e-15);
  EXPECT_NEAR(alike(1, 1), 0.004 * 0.004, 1e-15);
  EXPECT_NEAR(own(0, 0), 2 * 0.006 * 0.006, 1e-15);
  EXPECT_NEAR(own(1, 1), 0.004 * 0.004, 1e-15);
  EXPECT_TRUE(OutlineCovariance(sides, 2, 2).isApprox(alike + own, 1e-12));
}

}  // namespace
}  // namespace plumbline
