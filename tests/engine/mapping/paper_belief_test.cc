// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/paper_belief.h"

#include <gmock/gmock.h>

#include <numbers>

#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

class PaperBelief : public testing::Test {
 protected:
  /// Updates `particles` in an image of one chair, as often as told.
  void Update(std::vector<Particle>& particles, int times, bool settled) {
    const std::vector<NearestEdges> levels = SearchLevels(input_.edges, options_);
    ScoringView view;
    view.camera = scene_.camera();
    view.cam_from_world = input_.world_from_cam.inverse();
    const PaperImage image{scene_.scorer().get(), &scene_.map(), view, levels,
                           input_.detections.get()};
    for (int i = 0; i < times; ++i) {
      const auto frame = static_cast<std::uint32_t>(i);
      UpdateAsPaper(particles, input_.world_from_cam, image, options_,
                    {particles.size(), settled, {1, frame, 8, 0}, {1, frame, 9, 0}});
    }
  }
  std::vector<Particle> Born() {
    const std::vector<Detection> boxes = scene_.Boxes(input_.world_from_cam, {&chair_, 1});
    return BirthAsPaper(boxes.front().box, scene_.camera(),
                        scene_.database()->OfCategory(boxes.front().category), options_,
                        {1, 0, 11, 0});
  }

  MappingScene& scene_ = MappingScene::Get();
  PlacedModel chair_ = scene_.Place("chair", 0.1, 0.2, 30);
  MapperInput input_ = scene_.Input(0, LookAt({2.4, 0.5, 1.3}, {0, 0.2, 0.4}), {&chair_, 1});
  PaperOptions options_;
};

TEST_F(PaperBelief, EveryShapeIsBornWithTheSamePoses) {
  const std::vector<ModelId> labels = {ModelId{0}, ModelId{2}, ModelId{1}};
  const Box2 box{100, 50, 200, 250};
  const std::vector<Particle> born = BirthAsPaper(box, scene_.camera(), labels, options_, {1});
  ASSERT_EQ(born.size(), 3000u);
  double log_depth = 0, squares = 0;
  for (std::size_t i = 0; i < born.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(born[i + k].label, labels[k].value);
      EXPECT_EQ(born[i + k].x_c, born[i].x_c);
      EXPECT_EQ(born[i + k].rho, born[i].rho);
      EXPECT_EQ(born[i + k].azimuth, born[i].azimuth);
    }
    log_depth += born[i].rho / 1000;
    squares += born[i].rho * born[i].rho / 1000;
  }
  // Standard errors: 1 / sqrt(1000) and 1 / sqrt(2000), five of them.
  EXPECT_NEAR(log_depth, std::log(2.5), 0.16);
  EXPECT_NEAR(std::sqrt(squares - log_depth * log_depth), 1.0, 0.12);
}

TEST_F(PaperBelief, UpdatesFindAChairWhoseEdgesAndBoxAreGiven) {
  std::vector<Particle> particles = Born();
  Update(particles, 25, false);
  Update(particles, 25, true);
  const std::vector<PoseMode> modes = FindModes(particles, input_.world_from_cam, scene_.map());
  const Eigen::Vector3d truth = scene_.Hypothesis(chair_).center_in_world;
  // One view gives the depth by the size of the chair alone; 5 px of 400 are 4 cm at 2.6 m.
  EXPECT_LT((ToHypothesis(modes.front(), scene_.map()).center_in_world - truth).norm(), 0.15);
  EXPECT_EQ(modes.front().label, chair_.label);
}

TEST_F(PaperBelief, UpdatesLeaveEqualWeightsAndKnowTheirAncestors) {
  std::vector<Particle> particles = Born();
  const std::vector<Particle> before = particles;
  Update(particles, 1, true);
  for (const Particle& particle : particles) {
    EXPECT_NEAR(std::exp(particle.log_weight), 1.0 / static_cast<double>(particles.size()), 1e-6);
    // Two diffusions of .005 each, in the logarithm of the depth: six deviations.
    EXPECT_NEAR(particle.rho, before[particle.ancestor].rho, 0.045);
  }
}

Particle Mean(float x, float azimuth, std::uint16_t label = 0) {
  Particle mean;
  mean.x_c = x;
  mean.azimuth = azimuth;
  mean.label = label;
  return mean;
}

TEST_F(PaperBelief, AnObjectSettlesWhenItsMeansAgreeAndItsContourIsMatched) {
  const CadModel& model = scene_.database()->model(chair_.label);
  EdgeMatch good;
  good.ratio = 0.9;
  good.distance_px = 1;
  PaperTrack track;
  for (int i = 0; i < 14; ++i) track.Add(Mean(0.1f, i % 2 == 0 ? 3.1f : -3.1f), false);
  EXPECT_FALSE(Settles(track, good, model)) << "too soon";
  track.Add(Mean(0.1f, 3.1f), false);
  EXPECT_TRUE(Settles(track, good, model)) << "azimuths on both sides of half a turn are near";
  EdgeMatch bad = good;
  bad.ratio = 0.8;
  EXPECT_FALSE(Settles(track, bad, model));
  EXPECT_FALSE(Lost(bad)) << "what has settled stays so down to 0.75";
  bad.ratio = 0.7;
  EXPECT_TRUE(Lost(bad));

  PaperTrack restless = track;
  restless.Add(Mean(0.9f, 3.1f), false);  // variance .8^2 * 14 / 15^2 = .04
  EXPECT_FALSE(Settles(restless, good, model));
  track.Add(Mean(0.1f, 3.1f, 1), false);
  EXPECT_FALSE(Settles(track, good, model)) << "another label";
}

TEST_F(PaperBelief, BoxesLengthenALife) {
  PaperTrack track;
  track.updates = 151;
  EXPECT_TRUE(TooManyUpdates(track, options_));
  track.matched = 1;
  EXPECT_FALSE(TooManyUpdates(track, options_));
  track.unmatched = 25;
  EXPECT_FALSE(TooFewBoxes(track, options_));
  track.unmatched = 26;
  EXPECT_TRUE(TooFewBoxes(track, options_));
  track.settled_updates = 1;
  EXPECT_FALSE(TooFewBoxes(track, options_));
}

TEST_F(PaperBelief, ATrackIsTheSameAfterBytes) {
  PaperTrack track;
  for (int i = 0; i < 20; ++i) track.Add(Mean(0.1f * static_cast<float>(i), 1), i > 10);
  track.matched = 3;
  ByteWriter out;
  track.Save(out);
  const std::string bytes = out.Take();
  ByteReader in(bytes);
  PaperTrack back;
  back.Restore(in);
  EXPECT_TRUE(in.ok());
  ByteWriter again;
  back.Save(again);
  EXPECT_EQ(again.Take(), bytes);
  EXPECT_EQ(back.means.size(), 15u);
  EXPECT_EQ(back.updates, 11);
}

}  // namespace
}  // namespace plumbline
