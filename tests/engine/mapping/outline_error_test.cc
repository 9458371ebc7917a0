// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_error.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

constexpr double kStd_m = 0.02, kMetresPerPixel = 0.004;

/// Edges that are best explained where x is `kMetresPerPixel` for every pixel of the offset, with
/// the curvature that gives x the deviation `kStd_m` with beta = 10 and one view.
class LineScorer : public HypothesisScorer {
 public:
  void Score(const ScoringView& view, const UprightFrame&,
             std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override {
    for (std::size_t i = 0; i < scores.size(); ++i) {
      const double offset = view.outline_offset_px * 500 / view.camera.fx;
      const double off = (hypotheses[i].center_in_world.x() - kMetresPerPixel * offset) / kStd_m;
      scores[i].agreement_m = static_cast<float>(-0.5 * off * off / 10);
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
      hypothesis.center_in_world.y() += 0.01 * random.Gaussian();
      hypothesis.azimuth_rad += 0.03 * random.Gaussian();
    }
    const Eigen::Vector4d moved =
        OutlineSensitivity(LineScorer(), map, {view}, drawn, mean, options, 1);
    const double expected = kMetresPerPixel * posterior / (kStd_m * kStd_m);
    EXPECT_NEAR(moved.x(), expected, 0.03 * kMetresPerPixel);
    EXPECT_NEAR(moved.y(), 0, 0.03 * kMetresPerPixel);
    EXPECT_NEAR(moved.z(), 0, 1e-12);
    EXPECT_NEAR(moved[3], 0, 0.002);
    // Twice the views against the prior: it follows more.
    const Eigen::Vector4d sharper =
        OutlineSensitivity(LineScorer(), map, {view, view}, drawn, mean, options, 1);
    EXPECT_NEAR(sharper.x(), 2 * moved.x(), 1e-9) << "of the same spread";
  }
  EXPECT_TRUE(OutlineSensitivity(LineScorer(), map, {view}, {}, mean, options, 1).isZero(0));
}

}  // namespace
}  // namespace plumbline
