// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/viewpoint_scorer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/random_vector.h"
#include "tests/support/mapping_scene.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

class ViewpointScorerTest : public testing::Test {
 protected:
  /// The scene's edges from one camera, ready for scoring.
  struct Image {
    std::unique_ptr<OrientedTable> table;
    ScoringView view;
  };
  Image Seen(const Eigen::Isometry3d& world_from_cam, std::span<const PlacedModel> objects) {
    Image image;
    image.table = std::make_unique<OrientedTable>(scene_.Edges(world_from_cam, objects),
                                                  OrientedTableOptions{});
    image.view.camera = scene_.camera();
    image.view.cam_from_world = world_from_cam.inverse();
    image.view.table = image.table.get();
    return image;
  }
  std::vector<HypothesisScore> Score(const ScoringView& view,
                                     const std::vector<PoseHypothesis>& hypotheses) {
    std::vector<HypothesisScore> scores(hypotheses.size());
    scene_.scorer()->Score(view, scene_.map().upright, hypotheses, scores);
    for (const HypothesisScore& score : scores) {
      EXPECT_TRUE(std::isfinite(score.agreement_m) && std::isfinite(score.visible_m) &&
                  std::isfinite(score.total_m));
      EXPECT_GT(score.total_m, 0);
      EXPECT_LE(score.visible_m, score.total_m * 1.0001f);
    }
    return scores;
  }
  HypothesisScore Score(const ScoringView& view, const PoseHypothesis& hypothesis) {
    return Score(view, std::vector<PoseHypothesis>{hypothesis}).front();
  }
  static PoseHypothesis Moved(PoseHypothesis hypothesis, const Eigen::Vector3d& by,
                              double turn_deg) {
    hypothesis.center_in_world += by;
    hypothesis.azimuth_rad += turn_deg * kRadPerDeg;
    return hypothesis;
  }
  static void ExpectUnseen(const HypothesisScore& score) {
    EXPECT_EQ(score.visible_m, 0);
    EXPECT_EQ(score.agreement_m, 0);
    EXPECT_TRUE(score.visible_box.empty());
  }

  MappingScene& scene_ = MappingScene::Get();
  const Eigen::Isometry3d front_ = LookAt({2.2, 0.6, 1.4}, {0, 0, 0.4});
  const std::vector<Eigen::Isometry3d> cameras_ = {front_, LookAt({-0.8, 2.0, 1.2}, {0, 0, 0.4}),
                                                   LookAt({-1.6, -1.9, 1.6}, {0, 0, 0.4})};
};

TEST_F(ViewpointScorerTest, ScoresHighestWhereTheObjectIs) {
  for (const char* name : {"chair", "armchair", "table", "crate", "vase"}) {
    const PlacedModel placed = scene_.Place(name, 0.05, -0.03, 25);
    const PoseHypothesis truth = scene_.Hypothesis(placed);
    for (const Eigen::Isometry3d& camera : cameras_) {
      const Image image = Seen(camera, {&placed, 1});
      const HypothesisScore at_truth = Score(image.view, truth);
      EXPECT_NEAR(at_truth.visible_m, at_truth.total_m, 1e-4) << name;
      EXPECT_GT(at_truth.agreement_m, 0.75 * at_truth.visible_m * (1 - image.table->chance()))
          << name;
      // Sliding to either side, along the line of sight and up loses, and loses more further away.
      const Eigen::Vector3d side = camera.linear().col(0);
      const Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), away = up.cross(side);
      float before = at_truth.agreement_m;
      for (const double step : {0.05, 0.20}) {
        float sum = 0;
        for (const Eigen::Vector3d& direction : {side, up, away}) {
          for (const double sign : {-1.0, 1.0}) {
            const float score =
                Score(image.view, Moved(truth, sign * step * direction, 0)).agreement_m;
            EXPECT_LT(score, at_truth.agreement_m)
                << name << " " << (sign * step * direction).transpose();
            sum += score / 6;
          }
        }
        EXPECT_LT(sum, 0.9f * before) << name << " " << step;
        before = sum;
      }
      if (scene_.database()->model(placed.label).symmetry.order == 0) continue;
      for (const double turn : {-30.0, -12.0, 12.0, 30.0}) {
        EXPECT_LT(Score(image.view, Moved(truth, {0, 0, 0}, turn)).agreement_m,
                  at_truth.agreement_m)
            << name << turn;
      }
    }
  }
}

TEST_F(ViewpointScorerTest, TwiceAsLargeAndTwiceAsFarLooksTheSame) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 25);
  const Image image = Seen(front_, {&chair, 1});
  const PoseHypothesis truth = scene_.Hypothesis(chair);
  const HypothesisScore near = Score(image.view, truth);
  for (const double factor : {0.9, 1.1, 2.0}) {
    PoseHypothesis far = truth;
    far.log_scale = std::log(factor);
    far.center_in_world =
        front_.translation() + factor * (truth.center_in_world - front_.translation());
    const HypothesisScore score = Score(image.view, far);
    // Lengths are measured at the object; a point in a thousand may fall into the next pixel.
    EXPECT_NEAR(score.agreement_m, factor * near.agreement_m, 0.005 * near.agreement_m);
    EXPECT_NEAR(score.total_m, factor * near.total_m, 1e-4 * near.total_m);
    EXPECT_NEAR(score.whole_box.x0, near.whole_box.x0, 0.01);
    EXPECT_NEAR(score.whole_box.y1, near.whole_box.y1, 0.01);
  }
}

TEST_F(ViewpointScorerTest, LooksForEdgesBesideTheOutline) {
  const PlacedModel crate = scene_.Place("crate", 0, 0, 25);
  Image image = Seen(front_, {&crate, 1});
  const PoseHypothesis truth = scene_.Hypothesis(crate);
  const double distance = (front_.translation() - truth.center_in_world).norm();
  // Edges of the crate as outlines of one that is larger by two pixels to each side lie inside.
  PoseHypothesis larger = truth;
  const double radius_px = scene_.camera().fx * 0.2 / distance;
  larger.log_scale = std::log1p(2 / radius_px);
  const auto agreement = [&](const PoseHypothesis& hypothesis, double offset_px) {
    image.view.outline_offsets_px.fill(offset_px);
    return Score(image.view, hypothesis).agreement_m;
  };
  EXPECT_GT(agreement(larger, -2), 1.05 * agreement(larger, 0));
  EXPECT_LT(agreement(larger, 2), agreement(larger, 0));
  EXPECT_LT(agreement(truth, -2), agreement(truth, 0));
  EXPECT_LT(agreement(truth, 2), agreement(truth, 0));

  // Edges of the crate two pixels to its right are outside of its right side and inside of its left
  // one.
  PoseHypothesis aside = truth;
  const Eigen::Vector3d right = front_.linear().col(0);
  aside.center_in_world -= 2 * distance / scene_.camera().fx * right;
  const auto sideways = [&](double right_px, double left_px) {
    image.view.outline_offsets_px = {right_px, 0, left_px, 0};
    return Score(image.view, aside).agreement_m;
  };
  EXPECT_GT(sideways(2, -2), 1.03 * sideways(0, 0));
  EXPECT_GT(sideways(2, -2), sideways(2, 0));
  EXPECT_GT(sideways(2, -2), sideways(0, -2));
  EXPECT_LT(sideways(-2, 2), sideways(0, 0));
}

/// A chair and a crate, the left half of the image hidden, and a hundred poses around them.
class WrittenForSpeed : public ViewpointScorerTest {
 protected:
  WrittenForSpeed() {
    image_.view.occluder_depth = cv::Mat(60, 80, CV_32F, cv::Scalar(0));
    image_.view.occluder_depth.colRange(0, 40).setTo(0.5);
    Random random({.seed = 3});
    for (int i = 0; i < 100; ++i) {
      PoseHypothesis hypothesis = Moved(scene_.Hypothesis(placed_[static_cast<std::size_t>(i) % 2]),
                                        0.1 * GaussianVector<3>(random), 30 * random.Gaussian());
      hypothesis.log_scale = 0.02 * random.Gaussian();
      hypotheses_.push_back(hypothesis);
    }
  }

  std::vector<PlacedModel> placed_ = {scene_.Place("chair", 0, 0, 25),
                                      scene_.Place("crate", 0.5, -0.4, 10)};
  Image image_ = Seen(front_, placed_);
  std::vector<PoseHypothesis> hypotheses_;
};

// What is written for speed says what is written to be read.
TEST_F(WrittenForSpeed, SidesAreScoredAsEachByItself) {
  int differ = 0;
  for (const bool rims : {false, true}) {
    for (const bool inner_lines : {false, true}) {
      image_.view.rims = rims;
      image_.view.inner_lines = inner_lines;
      const SideScores quick = scene_.scorer()->ScoreSides(image_.view, scene_.map().upright,
                                                           hypotheses_, 1.5),
                       plain = scene_.scorer()->HypothesisScorer::ScoreSides(
                           image_.view, scene_.map().upright, hypotheses_, 1.5);
      const std::vector<HypothesisScore> unmoved = Score(image_.view, hypotheses_);
      for (std::size_t k = 0; k < quick.size(); ++k) {
        for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
          ASSERT_EQ(quick[k][i].agreement_m, plain[k][i].agreement_m) << k << ' ' << i;
          ASSERT_EQ(quick[k][i].visible_m, plain[k][i].visible_m) << k << ' ' << i;
          ASSERT_EQ(quick[k][i].total_m, plain[k][i].total_m) << k << ' ' << i;
          differ += quick[k][i].agreement_m != unmoved[i].agreement_m ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(differ, 1000) << "of 3200: sides that nothing hides";
}

TEST_F(WrittenForSpeed, ShiftsAreScoredAsEachByItself) {
  const std::vector<ImageShift> shifts = {{3.7, -1.2, 0.5}, {0, 0, 0.25}, {-40.3, 25.1, 0.25}};
  int differ = 0, moved = 0;
  for (const bool rims : {false, true}) {
    for (const double outwards_px : {0.0, 1.5}) {
      image_.view.rims = rims;
      image_.view.outline_offsets_px.fill(outwards_px);
      const std::vector<HypothesisScore> quick = scene_.scorer()->ScoreShifts(image_.view,
                                                                              scene_.map().upright,
                                                                              hypotheses_, shifts),
                                         plain = scene_.scorer()->HypothesisScorer::ScoreShifts(
                                             image_.view, scene_.map().upright, hypotheses_,
                                             shifts);
      const std::vector<HypothesisScore> unmoved = Score(image_.view, hypotheses_);
      ASSERT_EQ(quick.size(), 300u);
      for (std::size_t k = 0; k < quick.size(); ++k) {
        // Sums are rounded in another order: now and then a point falls into the next pixel.
        const HypothesisScore &a = quick[k], &b = plain[k], &c = unmoved[k % hypotheses_.size()];
        differ += a.agreement_m != b.agreement_m || a.visible_m != b.visible_m ? 1 : 0;
        ASSERT_NEAR(a.agreement_m, b.agreement_m, 0.01 * b.total_m) << k;
        ASSERT_NEAR(a.visible_m, b.visible_m, 0.01 * b.total_m) << k;
        ASSERT_EQ(a.total_m, b.total_m) << k;
        moved += a.agreement_m != c.agreement_m ? 1 : 0;
      }
    }
  }
  EXPECT_LT(differ, 60) << "of 1200";
  EXPECT_GT(moved, 300) << "of 400 that nothing hides and that are not where the pose says";
}

constexpr float kRim_m = 0.02f;

/// A screen 60 cm wide and 40 high that faces +x, its frame darker than what it frames.
struct Screen {
  Screen() {
    TriangleMesh mesh = MakeBox({-0.02f, -0.3f, 0}, {0.02f, 0.3f, 0.4f});
    mesh.colors.assign(mesh.vertices.size(), {30, 30, 30});
    TriangleMesh shown =
        MakeBox({0, -0.3f + kRim_m, kRim_m}, {0.021f, 0.3f - kRim_m, 0.4f - kRim_m});
    shown.colors.assign(shown.vertices.size(), {120, 140, 160});
    Append(shown, mesh);
    CadModel model;
    model.name = "screen";
    model.mesh = mesh;
    database = ModelDatabase::FromModels({model});
    views = ViewpointModel::Build(database->models().front(), ViewpointModelOptions{}, {}).value();
    scorer = std::make_unique<ViewpointScorer>(std::vector{views}, database);
    view.camera = {640, 480, 500, 500, 319.5, 239.5};
    view.rims = true;
  }
  /// From straight before it.
  void LookFrom(double distance_m) {
    view.cam_from_world = LookAt({distance_m, 0, 0.2}, {0, 0, 0.2}).inverse();
  }
  /// Edges of a rectangle so far inside of its outline.
  void FindEdges(float inside_m) {
    cv::Mat lines(view.camera.height, view.camera.width, CV_8U, cv::Scalar(0));
    const auto at = [&](double y, double z) {
      const Eigen::Vector2d pixel =
          view.camera.Project(view.cam_from_world * Eigen::Vector3d(0.02, y, z));
      return cv::Point(cvRound(pixel.x()), cvRound(pixel.y()));
    };
    cv::rectangle(lines, at(-0.3 + inside_m, inside_m), at(0.3 - inside_m, 0.4 - inside_m),
                  cv::Scalar(255));
    OrientedTableOptions narrow;
    narrow.radius_px = 7;
    narrow.sigma_px = 2.5;
    table = std::make_unique<OrientedTable>(EdgesOfContour(lines), narrow);
    view.table = table.get();
  }
  HypothesisScore Score(const PoseHypothesis& hypothesis) const {
    HypothesisScore found;
    scorer->Score(view, upright, {&hypothesis, 1}, {&found, 1});
    return found;
  }

  std::shared_ptr<const ModelDatabase> database;
  std::shared_ptr<const ViewpointModel> views;
  std::unique_ptr<ViewpointScorer> scorer;
  UprightFrame upright{{0, 0, -1}};
  std::unique_ptr<OrientedTable> table;
  ScoringView view;
  const PoseHypothesis truth{ModelId{0}, 0, {0, 0, 0.2}};
};

TEST_F(ViewpointScorerTest, PointsFoundAreWhatTheScoreSums) {
  Screen screen;
  screen.LookFrom(4);
  screen.FindEdges(kRim_m);
  screen.view.occluder_depth = cv::Mat(60, 80, CV_32F, cv::Scalar(0));
  screen.view.occluder_depth.colRange(0, 39).setTo(0.5);
  const ContourView contour = screen.views->View({4, 0, 0.2f});
  for (const bool rims : {false, true}) {
    screen.view.rims = rims;
    const std::vector<ContourPointFound> points =
        screen.scorer->PointsFound(screen.view, screen.upright, screen.truth);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(contour.size));
    double surplus = 0;
    int hidden = 0;
    for (const ContourPointFound& point : points) {
      EXPECT_NEAR(point.outwards.norm(), 1, 1e-4);
      EXPECT_EQ(point.seen, point.pixel.x() >= 311.5f);
      if (point.seen) surplus += point.hit - screen.table->chance();
      hidden += point.seen ? 0 : 1;
    }
    EXPECT_GT(hidden, 50);
    const HypothesisScore score = screen.Score(screen.truth);
    EXPECT_NEAR(contour.length_per_point_m * surplus, score.agreement_m, 1e-4);
    EXPECT_GT(score.agreement_m, 0.1);
  }
}

// From afar a frame and what it frames give one line, along whichever is stronger: the true pose
// explains both. From nearby each gives its own.
TEST_F(ViewpointScorerTest, AnEdgeAlongTheRimIsTheOutlinesWhereTheyCannotBeToldApart) {
  Screen screen;
  screen.view.inner_lines = false;
  // The score of the true pose, of the outline alone, where all edges lie `inside` of it.
  const auto score = [&](double distance, float inside) {
    screen.LookFrom(distance);
    screen.FindEdges(inside);
    const HypothesisScore found = screen.Score(screen.truth);
    return found.agreement_m / found.visible_m;
  };
  const float far_m = 5, near_m = 1;  // 2 and 10 pixels
  EXPECT_GT(score(far_m, kRim_m), 0.9f * score(far_m, 0));
  EXPECT_LT(score(near_m, kRim_m), 0.3f * score(near_m, 0));
  EXPECT_LT(score(far_m, 3 * kRim_m), 0.5f * score(far_m, 0)) << "further inside than the rim";
  EXPECT_LT(score(far_m, -2 * kRim_m), 0.5f * score(far_m, 0)) << "outside";
}

// The frame is as dark as .12. Before something as dark nobody sees where it ends.
TEST_F(ViewpointScorerTest, AnOutlineWithoutContrastCountsNeitherAsFoundNorAsMissed) {
  Screen screen;
  screen.LookFrom(2);
  screen.FindEdges(0);
  const HypothesisScore open = screen.Score(screen.truth);
  // The image's right half is known.
  const auto before = [&](float luminance) {
    screen.view.luminance_behind = cv::Mat(240, 320, CV_32F, cv::Scalar(9));
    screen.view.luminance_behind.colRange(160, 320).setTo(luminance);
    return screen.Score(screen.truth);
  };
  screen.view.least_contrast = 0.15;
  for (const float luminance : {0.3f, 0.9f, kUnknownLuminance})
    EXPECT_EQ(before(luminance).agreement_m, open.agreement_m) << luminance;
  for (const float luminance : {0.0f, 0.12f, 0.25f}) {
    const HypothesisScore alike = before(luminance);
    EXPECT_NEAR(alike.visible_m, 0.5f * open.visible_m, 0.05f * open.visible_m) << luminance;
    EXPECT_NEAR(alike.total_m, open.total_m, 1e-6f);
    EXPECT_EQ(alike.visible_box.x0, open.visible_box.x0) << "a detector sees all of it";
    EXPECT_EQ(alike.visible_box.x1, open.visible_box.x1);
    int seen_right = 0;
    for (const ContourPointFound& point :
         screen.scorer->PointsFound(screen.view, screen.upright, screen.truth)) {
      if (point.pixel.x() < 320) continue;
      seen_right += point.seen ? 1 : 0;
    }
    EXPECT_LE(seen_right,
              screen.views->View({2, 0, 0.2f}).size - screen.views->View({2, 0, 0.2f}).outline_size)
        << "but for inner lines";
  }
  const std::vector<PoseHypothesis> truth = {screen.truth};
  const SideScores quick = screen.scorer->ScoreSides(screen.view, screen.upright, truth, 1.5),
                   plain = screen.scorer->HypothesisScorer::ScoreSides(screen.view, screen.upright,
                                                                       truth, 1.5);
  for (std::size_t k = 0; k < quick.size(); ++k) {
    EXPECT_EQ(quick[k][0].agreement_m, plain[k][0].agreement_m) << k;
    EXPECT_EQ(quick[k][0].visible_m, plain[k][0].visible_m) << k;
  }
  // Edges that are not there are not missed.
  screen.table = std::make_unique<OrientedTable>(
      EdgesOfContour(cv::Mat(480, 640, CV_8U, cv::Scalar(0))), OrientedTableOptions{});
  screen.view.table = screen.table.get();
  screen.view.inner_lines = false;
  const HypothesisScore missed = before(0.9f), not_missed = before(0.12f);
  EXPECT_NEAR(not_missed.agreement_m, 0.5f * missed.agreement_m,
              0.05f * std::abs(missed.agreement_m));
  screen.view.least_contrast = 0;
  EXPECT_EQ(before(0.12f).agreement_m, missed.agreement_m);
}

TEST_F(ViewpointScorerTest, ScoresHighestAtItsScale) {
  for (const double scale : {0.95, 1.05}) {
    PlacedModel chair = scene_.Place("chair", 0, 0, 25);
    chair.scale = scale;
    const PoseHypothesis truth = scene_.Hypothesis(chair);
    // Standing on the floor, every size has its own distance from the camera's height.
    PoseHypothesis as_model = scene_.Hypothesis(scene_.Place("chair", 0, 0, 25));
    for (const Eigen::Isometry3d& camera : cameras_) {
      const Image image = Seen(camera, {&chair, 1});
      EXPECT_GT(Score(image.view, truth).agreement_m,
                1.1 * Score(image.view, as_model).agreement_m);
    }
  }
}

TEST_F(ViewpointScorerTest, ABodyOfRevolutionMayTurn) {
  const PlacedModel vase = scene_.Place("vase", 0, 0, 0);
  const Image image = Seen(front_, {&vase, 1});
  const PoseHypothesis truth = scene_.Hypothesis(vase);
  const float straight = Score(image.view, truth).agreement_m;
  for (const double turn : {20.0, 90.0, 170.0})
    EXPECT_NEAR(Score(image.view, Moved(truth, {0, 0, 0}, turn)).agreement_m, straight,
                0.05 * straight);
}

TEST_F(ViewpointScorerTest, LeavesOutWhatAnotherObjectHides) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  Image image = Seen(front_, {&chair, 1});
  const HypothesisScore open = Score(image.view, scene_.Hypothesis(chair));
  // A wall one metre before the camera hides the left half; half the image's size serves.
  image.view.occluder_depth =
      cv::Mat::zeros(scene_.camera().height / 2, scene_.camera().width / 2, CV_32F);
  image.view.occluder_depth.colRange(0, scene_.camera().width / 4).setTo(1.0f);
  const HypothesisScore half = Score(image.view, scene_.Hypothesis(chair));
  EXPECT_EQ(half.total_m, open.total_m);
  EXPECT_LT(half.visible_m, 0.75f * open.visible_m);
  EXPECT_GT(half.visible_m, 0.25f * open.visible_m);
  EXPECT_LT(half.agreement_m, 0.75f * open.agreement_m);
  EXPECT_GT(half.agreement_m / half.visible_m, 0.9f * open.agreement_m / open.visible_m)
      << "what shows fits as well as before";
  EXPECT_EQ(half.whole_box, open.whole_box);
  EXPECT_GE(half.visible_box.x0, 0.5f * static_cast<float>(scene_.camera().width) - 1.5f);
  EXPECT_NEAR(half.visible_box.x1, open.visible_box.x1, 1e-3f);

  // The same wall behind the chair hides nothing, nor does one within the margin.
  image.view.occluder_depth.setTo(10.0f);
  EXPECT_EQ(Score(image.view, scene_.Hypothesis(chair)).visible_m, open.visible_m);
  const RenderedMaps maps = scene_.Draw(front_, {&chair, 1});
  image.view.occluder_depth = maps.depth - 0.03;
  image.view.occluder_depth.setTo(0, maps.depth == 0);
  EXPECT_GT(Score(image.view, scene_.Hypothesis(chair)).visible_m, 0.97f * open.visible_m);

  image.view.occluder_depth = cv::Mat(scene_.camera().height, scene_.camera().width, CV_32F, 0.3);
  const HypothesisScore hidden = Score(image.view, scene_.Hypothesis(chair));
  ExpectUnseen(hidden);
  EXPECT_EQ(hidden.whole_box, open.whole_box);
}

TEST_F(ViewpointScorerTest, WhatIsBehindOrBesideTheCameraIsNotSeen) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Image image = Seen(front_, {&chair, 1});
  const PoseHypothesis truth = scene_.Hypothesis(chair);
  const Eigen::Vector3d forward = front_.linear().col(2);
  const Eigen::Vector3d right = front_.linear().col(0);
  for (const Eigen::Vector3d& by :
       {Eigen::Vector3d(-5 * forward), Eigen::Vector3d(-4 * forward + right),
        Eigen::Vector3d(6 * right), Eigen::Vector3d(-30 * right)}) {
    const HypothesisScore score = Score(image.view, Moved(truth, by, 0));
    ExpectUnseen(score);
    EXPECT_TRUE(score.whole_box.empty());
  }
}

TEST_F(ViewpointScorerTest, WhatIsPartlyOutsideTheImageCountsInside) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Eigen::Isometry3d aside = LookAt({2.2, 0.6, 1.4}, {0.4, 1.1, 0.4});
  const Image image = Seen(aside, {&chair, 1});
  const HypothesisScore score = Score(image.view, scene_.Hypothesis(chair));
  EXPECT_GT(score.visible_m, 0.2f * score.total_m);
  EXPECT_LT(score.visible_m, 0.9f * score.total_m);
  for (const Box2& box : {score.whole_box, score.visible_box}) {
    EXPECT_GE(box.x0, 0);
    EXPECT_GE(box.y0, 0);
    EXPECT_LE(box.x1, static_cast<float>(scene_.camera().width - 1));
    EXPECT_LE(box.y1, static_cast<float>(scene_.camera().height - 1));
  }
}

TEST_F(ViewpointScorerTest, WhatIsTooCloseIsCutAtTheNearPlane) {
  const PlacedModel table = scene_.Place("table", 0, 0, 30);
  const Image image = Seen(front_, {&table, 1});
  const Eigen::Vector3d forward = front_.linear().col(2);
  // The camera passes through the object: every share of it may lie behind.
  for (double by = 0; by < 4; by += 0.05) {
    const HypothesisScore score =
        Score(image.view, Moved(scene_.Hypothesis(table), -by * forward, 0));
    EXPECT_TRUE(std::isfinite(score.whole_box.x0) && std::isfinite(score.visible_box.x1));
    if (!score.visible_box.empty()) {
      EXPECT_GE(score.visible_box.x0, -0.5f);
      EXPECT_LE(score.visible_box.x1, static_cast<float>(scene_.camera().width));
    }
  }
  // Exactly at the camera's centre.
  PoseHypothesis inside = scene_.Hypothesis(table);
  inside.center_in_world = front_.translation();
  Score(image.view, inside);
}

TEST_F(ViewpointScorerTest, ManyAtOnceScoreAsOneByOne) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Image image = Seen(front_, {&chair, 1});
  std::vector<PoseHypothesis> hypotheses;
  for (std::uint32_t i = 0; i < 500; ++i) {
    Random random({.seed = 7, .particle = i});
    PoseHypothesis hypothesis =
        Moved(scene_.Hypothesis(chair),
              {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-0.2, 0.2)},
              random.Uniform(0, 360));
    hypothesis.label = ModelId{static_cast<std::int32_t>(i % 5)};
    hypotheses.push_back(hypothesis);
  }
  const std::vector<HypothesisScore> together = Score(image.view, hypotheses);
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    const HypothesisScore alone = Score(image.view, hypotheses[i]);
    EXPECT_EQ(alone.agreement_m, together[i].agreement_m);
    EXPECT_EQ(alone.visible_m, together[i].visible_m);
    EXPECT_EQ(alone.whole_box, together[i].whole_box);
    EXPECT_EQ(alone.visible_box, together[i].visible_box);
  }
}

TEST_F(ViewpointScorerTest, OnlyTheDirectionOfGravityMatters) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Image image = Seen(front_, {&chair, 1});
  const HypothesisScore straight = Score(image.view, scene_.Hypothesis(chair));
  for (std::uint32_t i = 0; i < 20; ++i) {
    Random random({.seed = 3, .particle = i});
    const Eigen::Quaterniond turn = Eigen::Quaterniond(random.Gaussian(), random.Gaussian(),
                                                       random.Gaussian(), random.Gaussian())
                                        .normalized();
    const UprightFrame upright(turn * Eigen::Vector3d(0, 0, -1));
    ScoringView view = image.view;
    view.cam_from_world = image.view.cam_from_world * turn.inverse();
    PoseHypothesis hypothesis = scene_.Hypothesis(chair);
    hypothesis.center_in_world = turn * hypothesis.center_in_world;
    hypothesis.azimuth_rad =
        upright.Azimuth(turn.toRotationMatrix() * chair.world_from_object.linear());
    HypothesisScore score;
    scene_.scorer()->Score(view, upright, {&hypothesis, 1}, {&score, 1});
    EXPECT_NEAR(score.agreement_m, straight.agreement_m, 0.02 * straight.agreement_m);
  }
}

}  // namespace
}  // namespace plumbline
