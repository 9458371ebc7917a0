// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/rendered_scorer.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <gmock/gmock.h>

#include "engine/mapping/viewpoint_scorer.h"
#include "tests/support/furniture_models.h"
#include "tests/support/scoring_scene.h"

namespace plumbline {
namespace {

class RenderedScorerTest : public testing::Test {
 protected:
  void SetUp() override {
    database_ = MakeFurnitureDatabase();
    scene_ = MakeScoringScene(*database_, *database_->Find("chair"),
                              {640, 480, 520, 525, 300.4, 251.7}, 4);
    Result<std::unique_ptr<RenderedScorer>> scorer = RenderedScorer::Create(database_, {});
    ASSERT_TRUE(scorer.ok()) << scorer.error().message;
    rendered_ = std::move(scorer).value();
  }

  std::vector<HypothesisScore> Score(const HypothesisScorer& scorer,
                                     const std::vector<PoseHypothesis>& hypotheses) const {
    std::vector<HypothesisScore> scores(hypotheses.size());
    scorer.Score(scene_.View(), upright_, hypotheses, scores);
    return scores;
  }

  static std::vector<double> Phi(const std::vector<HypothesisScore>& scores) {
    std::vector<double> phi;
    for (const HypothesisScore& score : scores)
      phi.push_back(static_cast<double>(score.agreement_m / std::max(1.0f, score.visible_m)));
    return phi;
  }

  UprightFrame upright_{Eigen::Vector3d(0, 0, -1)};
  std::shared_ptr<const ModelDatabase> database_;
  std::unique_ptr<RenderedScorer> rendered_;
  ScoringScene scene_;
};

TEST_F(RenderedScorerTest, PrefersTheTruthToWhatLiesAround) {
  std::vector<PoseHypothesis> hypotheses = Scattered(scene_, 100, 0.1, 10, 11);
  hypotheses.push_back(scene_.truth);
  const std::vector<double> phi = Phi(Score(*rendered_, hypotheses));
  const auto better =
      std::count_if(phi.begin(), phi.end(), [&](double p) { return p > phi.back(); });
  EXPECT_LE(better, 2);
  EXPECT_GT(phi.back(), 0.25);
}

TEST_F(RenderedScorerTest, AgreesWithTheFastScorer) {
  std::vector<std::shared_ptr<const ViewpointModel>> models(database_->models().size());
  ViewpointModelOptions options;  // its steps, in the part that is looked at
  options.elevations = 3;
  options.min_elevation_deg = 13;
  options.max_elevation_deg = 33;
  options.distances = {4.2, 5.0};
  models[static_cast<std::size_t>(scene_.truth.label.value)] =
      ViewpointModel::Build(database_->model(scene_.truth.label), options, {}).value();
  const ViewpointScorer fast(models, database_);
  for (const auto& [position_m, angle_deg, wanted] :
       {std::tuple(0.05, 5.0, 0.95), std::tuple(0.15, 20.0, 0.9)}) {
    const std::vector<PoseHypothesis> hypotheses =
        Scattered(scene_, 300, position_m, angle_deg, 12);
    const std::vector<HypothesisScore> a = Score(*rendered_, hypotheses),
                                       b = Score(fast, hypotheses);
    const double spearman = Spearman(Phi(a), Phi(b));
    RecordProperty("spearman_" + std::to_string(std::lround(100 * position_m)) + "cm",
                   std::to_string(spearman));
    EXPECT_GE(spearman, wanted);
    double visible = 0, total = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      visible += static_cast<double>(a[i].visible_m / b[i].visible_m);
      total += static_cast<double>(a[i].total_m / b[i].total_m);
    }
    EXPECT_NEAR(visible / static_cast<double>(a.size()), 1.0, 0.1);
    EXPECT_NEAR(total / static_cast<double>(a.size()), 1.0, 0.1);
  }
}

TEST_F(RenderedScorerTest, TwiceAsLargeAndTwiceAsFarLooksTheSame) {
  const Eigen::Vector3d eye = scene_.View().cam_from_world.inverse().translation();
  const HypothesisScore near = Score(*rendered_, {scene_.truth}).front();
  PoseHypothesis far = scene_.truth;
  far.log_scale = std::log(1.25);
  far.center_in_world = eye + 1.25 * (scene_.truth.center_in_world - eye);
  const HypothesisScore score = Score(*rendered_, {far}).front();
  // Depth steps of 4 cm are those of a contour at any scale: a few more show on what is larger.
  EXPECT_NEAR(score.total_m, 1.25 * near.total_m, 0.05 * near.total_m);
  EXPECT_NEAR(score.agreement_m, 1.25 * near.agreement_m, 0.1 * near.total_m);
  EXPECT_NEAR(score.whole_box.x0, near.whole_box.x0, 1);
  EXPECT_NEAR(score.whole_box.y1, near.whole_box.y1, 1);
}

TEST_F(RenderedScorerTest, BoxesAreThoseOfTheProjection) {
  const HypothesisScore score = Score(*rendered_, {scene_.truth}).front();
  Eigen::AlignedBox2d box;
  const Eigen::Isometry3d cam_from_object = CamFromObject(scene_, *database_, scene_.truth);
  for (const Eigen::Vector3f& vertex : database_->model(scene_.truth.label).mesh.vertices)
    box.extend(scene_.camera.Project(cam_from_object * vertex.cast<double>()));
  EXPECT_NEAR(score.whole_box.x0, box.min().x(), 2.0);
  EXPECT_NEAR(score.whole_box.y0, box.min().y(), 2.0);
  EXPECT_NEAR(score.whole_box.x1, box.max().x(), 2.0);
  EXPECT_NEAR(score.whole_box.y1, box.max().y(), 2.0);
  EXPECT_EQ(score.whole_box, score.visible_box);
}

TEST_F(RenderedScorerTest, CountsOnlyWhatIsNotHidden) {
  const HypothesisScore open = Score(*rendered_, {scene_.truth}).front();
  // Something at 1 m covers the left half of the chair's box; the map is of half size.
  const double middle = open.whole_box.center_x();
  scene_.occluder_depth = cv::Mat(240, 320, CV_32F, cv::Scalar(0));
  cv::Mat left = scene_.occluder_depth(cv::Rect(0, 0, static_cast<int>(middle / 2), 240));
  left.setTo(1.0);
  const HypothesisScore half = Score(*rendered_, {scene_.truth}).front();
  EXPECT_FLOAT_EQ(half.total_m, open.total_m);
  EXPECT_NEAR(half.visible_m / open.visible_m, 0.5, 0.2);
  EXPECT_NEAR(half.visible_box.x0, middle, 3);
  EXPECT_EQ(half.whole_box, open.whole_box);
  // What is behind the object hides nothing; wholly hidden it scores nothing.
  scene_.occluder_depth.setTo(9.0);
  EXPECT_FLOAT_EQ(Score(*rendered_, {scene_.truth}).front().visible_m, open.visible_m);
  scene_.occluder_depth.setTo(0.5);
  const HypothesisScore none = Score(*rendered_, {scene_.truth}).front();
  EXPECT_EQ(none.visible_m, 0);
  EXPECT_EQ(none.agreement_m, 0);
  EXPECT_TRUE(none.visible_box.empty());
}

TEST_F(RenderedScorerTest, GivesTheSameScoresAgainAndWhateverTheBatchAndOrder) {
  std::vector<PoseHypothesis> hypotheses = Scattered(scene_, 300, 0.1, 15, 13);
  for (std::size_t i = 0; i < hypotheses.size(); i += 3)
    hypotheses[i].label = *database_->Find("table");
  const std::vector<HypothesisScore> first = Score(*rendered_, hypotheses);
  const std::vector<PoseHypothesis> reversed(hypotheses.rbegin(), hypotheses.rend());
  const std::vector<HypothesisScore> again = Score(*rendered_, reversed);
  const std::vector<HypothesisScore> third = Score(*rendered_, hypotheses);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].agreement_m, third[i].agreement_m);
    // A tile's place in the atlas changes the rounding of its pixels' edges.
    const HypothesisScore& other = again[first.size() - 1 - i];
    EXPECT_NEAR(first[i].agreement_m, other.agreement_m, 0.01f * first[i].visible_m);
    EXPECT_NEAR(first[i].visible_m, other.visible_m, 0.01f * first[i].visible_m);
  }
}

TEST_F(RenderedScorerTest, HypothesesBehindBesideAndAroundTheCameraScoreNothingOrStayFinite) {
  PoseHypothesis behind = scene_.truth, beside = scene_.truth, around = scene_.truth;
  behind.center_in_world = {-2, 0, 0.45};
  beside.center_in_world = {1, 9, 0.45};
  around.center_in_world = {0.1, 0, 1.4};
  const std::vector<HypothesisScore> scores = Score(*rendered_, {behind, beside, around});
  EXPECT_EQ(scores[0].visible_m, 0);
  EXPECT_EQ(scores[1].visible_m, 0);
  EXPECT_TRUE(scores[1].visible_box.empty());
  EXPECT_TRUE(std::isfinite(scores[2].agreement_m) && std::isfinite(scores[2].visible_m));
}

}  // namespace
}  // namespace plumbline
