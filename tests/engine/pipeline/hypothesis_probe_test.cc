// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/hypothesis_probe.h"
#include "engine/mapping/particle_rank.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/snapshot/sequence_view.h"
#include "engine/vision/edge_detector.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

/// A white chair before black, seen from 2.5 m; a map that knows of one object of its category.
class HypothesisProbeTest : public testing::Test {
 protected:
  void SetUp() override {
    database_ = MakeFurnitureDatabase();
    chair_ = *database_->Find("chair");
    world_from_cam_.linear().col(0) = Eigen::Vector3d(0, -1, 0);
    world_from_cam_.linear().col(1) = Eigen::Vector3d(-0.4, 0, -1).normalized();
    world_from_cam_.linear().col(2) =
        world_from_cam_.linear().col(0).cross(world_from_cam_.linear().col(1));
    world_from_cam_.translation() = Eigen::Vector3d(-2.3, 0.1, 1.5);
    auto probe = HypothesisProbe::Create(camera_, database_, std::nullopt, WorkContext());
    ASSERT_TRUE(probe.ok()) << probe.error().message;
    probe_ = std::move(probe).value();
    for (const CadModel& model : database_->models())
      view_.models.push_back({model.name, model.category, {}, model.center()});
    view_.truth = {{"the chair", "chair", At(0, 0)}};
  }

  static Eigen::Isometry3d At(double x, double y) {
    Eigen::Isometry3d pose(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()));
    pose.translation() = Eigen::Vector3d(x, y, 0);
    return pose;
  }

  /// The image shows the chair at `seen`; the filter believes in `believed`, and its particles lie
  /// `spread_m` around that.
  MapSnapshot Snapshot(const Eigen::Isometry3d& seen, const Eigen::Isometry3d& believed,
                       double spread_m) const {
    OcclusionRenderer renderer(*database_);
    const PlacedModel placed[] = {{{1}, chair_, seen}};
    const RenderedMaps maps = renderer.Render(camera_, world_from_cam_.inverse(), placed);
    Frame frame;
    cv::resize(maps.id > 0, frame.image, {camera_.width, camera_.height}, 0, 0, cv::INTER_NEAREST);
    cv::cvtColor(frame.image, frame.image, cv::COLOR_GRAY2BGR);
    const EdgeMap edges = CreateEdgeDetector("gradient", nullptr).value()->Detect(frame).value();
    MapSnapshot snapshot;
    snapshot.edge_probability = edges.probability;
    snapshot.edge_angle = edges.angle;
    snapshot.report.frame = 7;
    snapshot.report.world_from_cam = world_from_cam_;
    ObjectReport object;
    object.id = {1};
    object.category = "chair";
    object.label = chair_;
    object.world_from_object = believed;
    object.world_from_reference_cam = world_from_cam_;
    auto particles = std::make_shared<std::vector<Particle>>();
    Random random({.seed = 3});
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d noise(random.Gaussian(), random.Gaussian(), 0);
      particles->push_back(
          ToParticle({chair_, 0.6 + 0.02 * random.Gaussian(),
                      believed * database_->model(chair_).center() + spread_m * noise},
                     world_from_cam_));
      particles->back().log_weight = -std::log(60.0f);
    }
    object.particles = particles;
    snapshot.report.objects = {object};
    return snapshot;
  }

  ProbeView Probe(const MapSnapshot& snapshot) {
    return probe_->Probe(snapshot, view_, {}, {{1}, -1, false}, {0});
  }

  PinholeCamera camera_{640, 480, 520, 520, 320, 240};
  Eigen::Isometry3d world_from_cam_ = Eigen::Isometry3d::Identity();
  std::shared_ptr<const ModelDatabase> database_;
  ModelId chair_;
  SequenceView view_;
  std::unique_ptr<HypothesisProbe> probe_;
};

TEST_F(HypothesisProbeTest, SaysThatAnObjectIsWhereItShouldBe) {
  const ProbeView view = Probe(Snapshot(At(0, 0), At(0.01, 0), 0.02));
  EXPECT_EQ(view.verdict, Verdict::kRight) << view.verdict_text;
  EXPECT_THAT(view.verdict_text, testing::StartsWith("It is where"));
  ASSERT_FALSE(view.hypotheses.empty());
  EXPECT_EQ(view.hypotheses.front().name, "mean");
  EXPECT_TRUE(view.hypotheses.back().is_truth);
  EXPECT_GT(view.hypotheses.back().phi_edge, 0.3);
  EXPECT_EQ(view.slices.size(), 4u);
}

TEST_F(HypothesisProbeTest, BlamesTheSearchWhereNoParticleIsNearABetterTruth) {
  const ProbeView view = Probe(Snapshot(At(0, 0), At(0.1, 0.3), 0.02));
  EXPECT_EQ(view.verdict, Verdict::kSearch) << view.verdict_text;
  EXPECT_THAT(view.verdict_text, testing::StartsWith("Search:"));
  EXPECT_GT(view.hypotheses.back().score, view.hypotheses.front().score);
  EXPECT_GT(view.nearest_particle_m, 0.2);
}

TEST_F(HypothesisProbeTest, TellsASpuriousObject) {
  const ProbeView view = Probe(Snapshot(At(0, 0), At(0.2, 0.6), 0.02));
  EXPECT_EQ(view.verdict, Verdict::kSpurious) << view.verdict_text;
  EXPECT_THAT(view.verdict_text, testing::StartsWith("Spurious:"));
}

TEST_F(HypothesisProbeTest, DoesNotTakeATruthThatAnotherExplains) {
  const ProbeView view = probe_->Probe(Snapshot(At(0, 0), At(0.1, 0.3), 0.02), view_, {},
                                       {{1}, -1, false}, {0, ObjectId{4}});
  EXPECT_EQ(view.verdict, Verdict::kSecond) << view.verdict_text;
  EXPECT_THAT(view.verdict_text, testing::HasSubstr("object 4 explains the chair"));
}

TEST_F(HypothesisProbeTest, ScoresATrueInstanceBesideItsCandidate) {
  ProbeCommand ask{{1}};
  ask.truth = "the chair";
  const ProbeView missed =
      probe_->Probe(Snapshot(At(0, 0), At(0.1, 0.3), 0.02), view_, {}, ask, {0});
  EXPECT_EQ(missed.object, ObjectId{}) << "the answer is about the instance";
  EXPECT_EQ(missed.truth, "the chair");
  EXPECT_TRUE(missed.hypotheses[0].is_truth);
  EXPECT_EQ(missed.hypotheses[1].name, "mean of #1");
  EXPECT_EQ(missed.verdict, Verdict::kSearch) << missed.verdict_text;
  EXPECT_THAT(missed.verdict_text, testing::HasSubstr("object 1, 32 cm"));
  EXPECT_NEAR(*missed.slices.front().truth, 0, 1e-4) << "sweeps go through the truth";
  MapSnapshot elsewhere = Snapshot(At(0.1, 0.3), At(0.1, 0.3), 0.02);
  elsewhere.report.frame = 8;
  const ProbeView wrong = probe_->Probe(elsewhere, view_, {}, ask, {0});
  EXPECT_EQ(wrong.verdict, Verdict::kLikelihood) << wrong.verdict_text;
}

TEST_F(HypothesisProbeTest, ScoresATrueInstanceThatNothingIsNear) {
  ProbeCommand ask;
  ask.truth = "the chair";
  const ProbeView alone =
      probe_->Probe(Snapshot(At(0, 0), At(0.1, 0.3), 0.02), view_, {}, ask, {0});
  ASSERT_EQ(alone.hypotheses.size(), 1u);
  EXPECT_GT(alone.hypotheses[0].phi_edge, 0.3);
  EXPECT_FALSE(alone.hypotheses[0].outline.empty());
  EXPECT_THAT(alone.verdict_text, testing::HasSubstr("no candidate is within a metre"));
  // Where the image shows nothing, the truth is not what search could be blamed for.
  MapSnapshot blank = Snapshot(At(0, 0), At(0.1, 0.3), 0.02);
  blank.report.frame = 8;
  blank.edge_probability = cv::Mat::zeros(blank.edge_probability.size(), CV_8U);
  EXPECT_THAT(probe_->Probe(blank, view_, {}, ask, {0}).verdict_text,
              testing::HasSubstr("the truth itself hardly meets edges"));
  ask.truth = "nobody";
  EXPECT_THAT(probe_->Probe(blank, view_, {}, ask, {}).message,
              testing::HasSubstr("no such instance"));
}

TEST_F(HypothesisProbeTest, BlamesTheLikelihoodWhereTheWrongPlaceScoresBetter) {
  const ProbeView view = Probe(Snapshot(At(0.1, 0.3), At(0.1, 0.3), 0.02));
  EXPECT_EQ(view.verdict, Verdict::kLikelihood) << view.verdict_text;
  EXPECT_THAT(view.verdict_text, testing::StartsWith("Likelihood:"));
}

TEST_F(HypothesisProbeTest, NamesTheBestTheMedianAndTheParticleNearestToTheTruth) {
  MapSnapshot snapshot = Snapshot(At(0, 0), At(0.01, 0), 0.05);
  auto particles = std::make_shared<std::vector<Particle>>(*snapshot.report.objects[0].particles);
  for (std::size_t i = 0; i < particles->size(); ++i)
    (*particles)[i].phi_edge = static_cast<float>((i * 37) % 60) / 60;  // rank by made-up scores
  const Eigen::Vector3d truth = At(0, 0) * database_->model(chair_).center();
  (*particles)[23] = ToParticle({chair_, 0.6, truth}, world_from_cam_);
  (*particles)[23].log_weight = (*particles)[0].log_weight;
  snapshot.report.objects[0].particles = particles;
  const MapperOptions options;
  const std::vector<int> order = ByRank(*particles, options.alpha, options.beta);
  const ProbeView view = Probe(snapshot);
  const auto particle = [&](const std::string& name) {
    for (const ProbedHypothesis& h : view.hypotheses) {
      if (h.name.starts_with(name)) return h.particle.value_or(-1);
    }
    return -2;
  };
  EXPECT_EQ(particle("best particle"), order.front());
  EXPECT_EQ(particle("median particle"), order[order.size() / 2]);
  EXPECT_EQ(particle("nearest to truth"), 23);
  EXPECT_NEAR(view.nearest_particle_m, 0, 1e-5);
}

TEST_F(HypothesisProbeTest, FindsTheEdgesThatContourSamplesHit) {
  const ProbeView view = Probe(Snapshot(At(0, 0), At(0, 0), 0.01));
  int visible = 0, near = 0;
  for (const ContourSample& sample : view.hypotheses.front().samples) {
    visible += sample.visible;
    near += sample.visible && sample.edge_at_px && std::abs(*sample.edge_at_px) <= 4;
    EXPECT_NEAR(sample.normal.norm(), 1, 1e-4);
  }
  EXPECT_GT(visible, 100);
  EXPECT_GT(near, visible / 2) << "at the true place the edges are close to the contour";
}

TEST_F(HypothesisProbeTest, SlicesPeakAtTheTruth) {
  const ProbeView view = Probe(Snapshot(At(0, 0), At(0, 0.12), 0.02));
  const LikelihoodSlice& sideways = view.slices.front();
  ASSERT_TRUE(sideways.truth);
  const auto best = std::max_element(sideways.score.begin(), sideways.score.end());
  EXPECT_NEAR(sideways.offsets[static_cast<std::size_t>(best - sideways.score.begin())],
              *sideways.truth, 2.5);
}

TEST_F(HypothesisProbeTest, SweepsTwoParametersAtOnceWhereItIsAsked) {
  const MapSnapshot snapshot = Snapshot(At(0, 0), At(0, 0.12), 0.02);
  EXPECT_TRUE(Probe(snapshot).maps.empty());
  const ProbeView view = probe_->Probe(snapshot, view_, {}, {{1}, -1, false, true}, {0});
  ASSERT_EQ(view.maps.size(), 2u);
  const LikelihoodMap& map = view.maps.front();
  ASSERT_EQ(map.score.size(), map.x_offsets.size() * map.y_offsets.size());
  ASSERT_TRUE(map.truth);
  const auto best = std::max_element(map.score.begin(), map.score.end()) - map.score.begin();
  const auto columns = static_cast<std::ptrdiff_t>(map.x_offsets.size());
  EXPECT_NEAR(map.x_offsets[static_cast<std::size_t>(best % columns)], map.truth->x(), 3);
  EXPECT_NEAR(map.y_offsets[static_cast<std::size_t>(best / columns)], map.truth->y(), 8);
  // The row through the mean is the slice.
  const std::size_t middle = map.y_offsets.size() / 2;
  EXPECT_NEAR(map.score[middle * map.x_offsets.size() + middle], view.hypotheses.front().score,
              1e-4);
}

TEST_F(HypothesisProbeTest, OutlinesEveryHypothesis) {
  const MapSnapshot snapshot = Snapshot(At(0, 0), At(0, 0), 0.02);
  const ProbeView view = probe_->Probe(snapshot, view_, {}, {{1}, 5, false, false, 7}, {0});
  EXPECT_EQ(view.hovered, 7);
  EXPECT_FALSE(view.hovered_outline.empty());
  ASSERT_EQ(view.hypotheses[3].particle, 5);
  for (const ProbedHypothesis& h : view.hypotheses) {
    ASSERT_FALSE(h.outline.empty()) << h.name;
    for (const auto& contour : h.outline) {
      for (const Eigen::Vector2f& p : contour) {
        EXPECT_GT(p.x(), h.whole_box.x0 - 6);
        EXPECT_LT(p.y(), h.whole_box.y1 + 6);
      }
    }
  }
}

TEST_F(HypothesisProbeTest, SaysWhatIsMissing) {
  MapSnapshot snapshot = Snapshot(At(0, 0), At(0, 0), 0.02);
  EXPECT_THAT(probe_->Probe(snapshot, view_, {}, {{9}, -1, false}, {0}).message,
              testing::HasSubstr("not in this frame"));
  snapshot.edge_probability = cv::Mat();
  EXPECT_THAT(Probe(snapshot).message, testing::HasSubstr("images"));
}

}  // namespace
}  // namespace plumbline
