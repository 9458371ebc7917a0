// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/rendered_scorer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/mapping/viewpoint_scorer.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

TriangleMesh Chair() {
  TriangleMesh chair = MakeBox({-0.22f, -0.22f, 0.42f}, {0.25f, 0.22f, 0.46f});
  Append(MakeBox({-0.25f, -0.22f, 0.42f}, {-0.21f, 0.22f, 0.9f}), chair);
  for (const float x : {-0.25f, 0.21f}) {
    for (const float y : {-0.22f, 0.18f})
      Append(MakeBox({x, y, 0}, {x + 0.04f, y + 0.04f, 0.42f}), chair);
  }
  return chair;
}

TriangleMesh Table() {
  TriangleMesh table = MakeBox({-0.7f, -0.4f, 0.7f}, {0.7f, 0.4f, 0.74f});
  for (const float x : {-0.68f, 0.62f}) {
    for (const float y : {-0.38f, 0.32f})
      Append(MakeBox({x, y, 0}, {x + 0.06f, y + 0.06f, 0.7f}), table);
  }
  return table;
}

CadModel Model(const char* name, TriangleMesh mesh) {
  CadModel model;
  model.name = model.category = name;
  model.mesh = std::move(mesh);
  return model;
}

/// A camera 1.5 m above the floor that looks down a little at a point 2.5 m ahead.
Eigen::Isometry3d CamFromWorld() {
  const Eigen::Vector3d forward = Eigen::Vector3d(2.5, 0, -1.0).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() << right, forward.cross(right), forward;
  world_from_cam.translation() = Eigen::Vector3d(0, 0, 1.5);
  return world_from_cam.inverse();
}

double Spearman(const std::vector<double>& a, const std::vector<double>& b) {
  const auto ranks = [](const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
    std::vector<double> rank(values.size());
    for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<double>(i);
    return rank;
  };
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = 0.5 * static_cast<double>(x.size() - 1);
  double xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean) * (y[i] - mean);
    xx += (x[i] - mean) * (x[i] - mean);
  }
  return xy / xx;
}

class RenderedScorerTest : public testing::Test {
 protected:
  void SetUp() override {
    database_ = ModelDatabase::FromModels({Model("chair", Chair()), Model("table", Table())});
    Result<std::unique_ptr<RenderedScorer>> scorer = RenderedScorer::Create(database_, {});
    ASSERT_TRUE(scorer.ok()) << scorer.error().message;
    rendered_ = std::move(scorer).value();
    truth_ = {ModelId{0}, 0.7, {2.5, 0.1, 0.45}};
    MakeEdges();
    view_.camera = camera_;
    view_.cam_from_world = CamFromWorld();
    view_.table = table_.get();
  }

  /// The edges of the chair at its true pose, a third of them missing, and clutter.
  void MakeEdges() {
    Result<std::unique_ptr<RenderContext>> context = RenderContext::CreateHeadless();
    ASSERT_TRUE(context.ok());
    Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(**context);
    ASSERT_TRUE(renderer.ok());
    const RenderInstance instance{(*renderer)->AddMesh(Chair()), CamFromObject(truth_), 1};
    const RenderedMaps maps =
        (*renderer)->Render(camera_, std::span(&instance, 1), {.contour = true, .near_m = 0.05});
    cv::Mat shade = maps.depth.clone(), dx, dy;
    shade.setTo(4.0, maps.depth == 0);
    cv::GaussianBlur(shade, shade, {}, 1.0);
    cv::Sobel(shade, dx, CV_32F, 1, 0);
    cv::Sobel(shade, dy, CV_32F, 0, 1);
    EdgeMap edges;
    edges.probability = cv::Mat(camera_.height, camera_.width, CV_8U, cv::Scalar(0));
    edges.angle = edges.probability.clone();
    Random random({.seed = 5});
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        const bool dropped = (x / 24 * 7 + y / 24 * 13) % 3 == 0;
        if (maps.contour.at<uchar>(y, x) == 0 || dropped) continue;
        SetEdge(x, y, std::atan2(dy.at<float>(y, x), dx.at<float>(y, x)), 220, edges);
      }
    }
    for (int line = 0; line < 30; ++line) {
      const double angle = 3.14159 * random.Uniform();
      const cv::Point2d from(camera_.width * random.Uniform(), camera_.height * random.Uniform());
      for (int k = 0; k < 60; ++k) {
        const cv::Point at(from + k * cv::Point2d(-std::sin(angle), std::cos(angle)));
        if (cv::Rect(0, 0, camera_.width, camera_.height).contains(at))
          SetEdge(at.x, at.y, angle, 180, edges);
      }
    }
    table_ = std::make_unique<OrientedTable>(edges, OrientedTableOptions{});
  }

  static void SetEdge(int x, int y, double angle, int probability, EdgeMap& edges) {
    edges.probability.at<uchar>(y, x) = static_cast<uchar>(probability);
    edges.angle.at<uchar>(y, x) =
        static_cast<uchar>(static_cast<int>(std::floor(angle * 256 / 3.14159265 + 256.5)) & 255);
  }

  Eigen::Isometry3d CamFromObject(const PoseHypothesis& hypothesis) const {
    Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
    world_from_object.linear() = upright_.WorldFromObjectRotation(hypothesis.azimuth_rad);
    world_from_object.translation() =
        hypothesis.center_in_world -
        world_from_object.linear() * database_->model(hypothesis.label).center();
    return CamFromWorld() * world_from_object;
  }

  std::vector<PoseHypothesis> Scattered(int count, double position_m, double angle_deg) const {
    Random random({.seed = 11});
    std::vector<PoseHypothesis> hypotheses;
    for (int i = 0; i < count; ++i) {
      PoseHypothesis hypothesis = truth_;
      hypothesis.azimuth_rad += angle_deg * kDegree * random.Gaussian();
      hypothesis.center_in_world +=
          position_m * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
      hypotheses.push_back(hypothesis);
    }
    return hypotheses;
  }

  std::vector<HypothesisScore> Score(const HypothesisScorer& scorer,
                                     const std::vector<PoseHypothesis>& hypotheses) const {
    std::vector<HypothesisScore> scores(hypotheses.size());
    scorer.Score(view_, upright_, hypotheses, scores);
    return scores;
  }

  static std::vector<double> Phi(const std::vector<HypothesisScore>& scores) {
    std::vector<double> phi;
    for (const HypothesisScore& score : scores)
      phi.push_back(static_cast<double>(score.agreement_m / std::max(1.0f, score.visible_m)));
    return phi;
  }

  PinholeCamera camera_{640, 480, 520, 525, 300.4, 251.7};
  UprightFrame upright_{Eigen::Vector3d(0, 0, -1)};
  std::shared_ptr<const ModelDatabase> database_;
  std::unique_ptr<RenderedScorer> rendered_;
  std::unique_ptr<OrientedTable> table_;
  PoseHypothesis truth_;
  ScoringView view_;
};

TEST_F(RenderedScorerTest, PrefersTheTruthToWhatLiesAround) {
  std::vector<PoseHypothesis> hypotheses = Scattered(100, 0.1, 10);
  hypotheses.push_back(truth_);
  const std::vector<double> phi = Phi(Score(*rendered_, hypotheses));
  const int better = static_cast<int>(
      std::count_if(phi.begin(), phi.end(), [&](double p) { return p > phi.back(); }));
  EXPECT_LE(better, 2);
  EXPECT_GT(phi.back(), 0.3);
}

TEST_F(RenderedScorerTest, AgreesWithTheFastScorer) {
  std::vector<std::shared_ptr<const ViewpointModel>> models(2);
  ViewpointModelOptions options;
  options.azimuths = 120;
  options.elevations = 3;
  options.min_elevation_deg = 13;
  options.max_elevation_deg = 33;
  options.distances = {4.2, 5.0};
  options.points = 512;
  models[0] = ViewpointModel::Build(database_->models()[0], options, {}).value();
  const ViewpointScorer fast(models, database_);
  for (const auto& [position_m, angle_deg, wanted] :
       {std::tuple(0.05, 5.0, 0.95), std::tuple(0.15, 20.0, 0.9)}) {
    const std::vector<PoseHypothesis> hypotheses = Scattered(300, position_m, angle_deg);
    const std::vector<HypothesisScore> a = Score(*rendered_, hypotheses),
                                       b = Score(fast, hypotheses);
    const double spearman = Spearman(Phi(a), Phi(b));
    RecordProperty("spearman_" + std::to_string(static_cast<int>(100 * position_m)) + "cm",
                   std::to_string(spearman));
    EXPECT_GE(spearman, wanted);
    double visible = 0, total = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      visible +=
          static_cast<double>(a[i].visible_m / b[i].visible_m) / static_cast<double>(a.size());
      total += static_cast<double>(a[i].total_m / b[i].total_m) / static_cast<double>(a.size());
    }
    EXPECT_NEAR(visible, 1.0, 0.06);
    EXPECT_NEAR(total, 1.0, 0.06);
  }
}

TEST_F(RenderedScorerTest, BoxesAreThoseOfTheProjection) {
  const HypothesisScore score = Score(*rendered_, {truth_}).front();
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3f& vertex : Chair().vertices) {
    box.extend(camera_.Project(CamFromObject(truth_) * vertex.cast<double>()));
  }
  EXPECT_NEAR(score.whole_box.x0, box.min().x(), 2.0);
  EXPECT_NEAR(score.whole_box.y0, box.min().y(), 2.0);
  EXPECT_NEAR(score.whole_box.x1, box.max().x(), 2.0);
  EXPECT_NEAR(score.whole_box.y1, box.max().y(), 2.0);
  EXPECT_EQ(score.whole_box, score.visible_box);
}

TEST_F(RenderedScorerTest, CountsOnlyWhatIsNotHidden) {
  const HypothesisScore open = Score(*rendered_, {truth_}).front();
  // Something at 1 m covers the left half of the chair's box; the map is of half size.
  const double middle = open.whole_box.center_x();
  view_.occluder_depth = cv::Mat(240, 320, CV_32F, cv::Scalar(0));
  view_.occluder_depth(cv::Rect(0, 0, static_cast<int>(middle / 2), 240)).setTo(1.0);
  const HypothesisScore half = Score(*rendered_, {truth_}).front();
  EXPECT_FLOAT_EQ(half.total_m, open.total_m);
  EXPECT_NEAR(half.visible_m / open.visible_m, 0.5, 0.15);
  EXPECT_NEAR(half.visible_box.x0, middle, 3);
  EXPECT_EQ(half.whole_box, open.whole_box);
  // Within the margin nothing is hidden; wholly hidden scores nothing.
  view_.occluder_depth.setTo(9.0);
  EXPECT_FLOAT_EQ(Score(*rendered_, {truth_}).front().visible_m, open.visible_m);
  view_.occluder_depth.setTo(0.5);
  const HypothesisScore none = Score(*rendered_, {truth_}).front();
  EXPECT_EQ(none.visible_m, 0);
  EXPECT_EQ(none.agreement_m, 0);
  EXPECT_TRUE(none.visible_box.empty());
}

TEST_F(RenderedScorerTest, GivesTheSameScoresAgainAndWhateverTheBatchAndOrder) {
  std::vector<PoseHypothesis> hypotheses = Scattered(300, 0.1, 15);
  for (std::size_t i = 0; i < hypotheses.size(); i += 3) hypotheses[i].label = ModelId{1};
  const std::vector<HypothesisScore> first = Score(*rendered_, hypotheses);
  std::vector<PoseHypothesis> reversed(hypotheses.rbegin(), hypotheses.rend());
  const std::vector<HypothesisScore> again = Score(*rendered_, reversed);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const HypothesisScore& other = again[first.size() - 1 - i];
    // A tile's place in the atlas changes the rounding of its pixels' edges.
    EXPECT_NEAR(first[i].agreement_m, other.agreement_m, 0.01f * first[i].visible_m);
    EXPECT_NEAR(first[i].visible_m, other.visible_m, 0.01f * first[i].visible_m);
  }
  const std::vector<HypothesisScore> third = Score(*rendered_, hypotheses);
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(first[i].agreement_m, third[i].agreement_m);
}

TEST_F(RenderedScorerTest, HypothesesBehindBesideAndAroundTheCameraScoreNothingOrStayFinite) {
  PoseHypothesis behind = truth_, beside = truth_, around = truth_;
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
