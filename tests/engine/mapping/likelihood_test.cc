// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/likelihood.h"

#include <gmock/gmock.h>

#include "engine/mapping/bytes.h"
#include "engine/mapping/map_object.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

HypothesisScore Lengths(float agreement_m, float visible_m, float total_m) {
  HypothesisScore score;
  score.agreement_m = agreement_m;
  score.visible_m = visible_m;
  score.total_m = total_m;
  score.whole_box = {10, 10, 50, 90};
  score.visible_box = {10, 10, 50, 40};
  return score;
}

/// Gives back scores that were put in, in order.
class GivenScores : public HypothesisScorer {
 public:
  explicit GivenScores(std::vector<HypothesisScore> given) : given_(std::move(given)) {}
  void Score(const ScoringView&, const UprightFrame&, std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override {
    for (std::size_t i = 0; i < hypotheses.size(); ++i) scores[i] = given_.at(i);
  }

 private:
  std::vector<HypothesisScore> given_;
};

class LikelihoodTest : public testing::Test {
 protected:
  std::vector<Likelihood> Evaluated(const std::vector<HypothesisScore>& scores,
                                    const std::vector<Detection>& boxes = {},
                                    std::optional<float> normalizer = std::nullopt) {
    std::vector<PoseHypothesis> hypotheses(scores.size());
    for (std::size_t i = 0; i < scores.size(); ++i)
      hypotheses[i].label = labels_.empty() ? ModelId{0} : labels_[i];
    const auto detections = DetectionsFromProposals(boxes);
    return Evaluate(GivenScores(scores), {}, map_, detections.get(), hypotheses, normalizer,
                    options_);
  }
  MapFrame map_ = MappingScene::Get().map();
  MapperOptions options_;
  std::vector<ModelId> labels_;
};

TEST_F(LikelihoodTest, EqualFitsScoreAlikeHoweverMuchContourShows) {
  // The same share of hits; one shows a third more contour.
  const auto likelihoods = Evaluated({Lengths(1.5f, 3, 4), Lengths(2, 4, 4), Lengths(1.5f, 3, 4)});
  EXPECT_NEAR(likelihoods[0].phi_edge, 0.5, 1e-6);
  EXPECT_NEAR(likelihoods[1].phi_edge, 0.5, 1e-6);
}

TEST_F(LikelihoodTest, TheDetectorCountsMoreForCars) {
  using Eigen::Vector3f;
  const Eigen::AlignedBox3f table(Vector3f(-1, -0.5f, 0), Vector3f(1, 0.5f, 0.7f)),
      car(Vector3f(-2, -0.9f, 0), Vector3f(2, 0.9f, 1.5f));
  EXPECT_EQ(DetectorWeight("dining table", table, options_), options_.alpha);
  EXPECT_EQ(DetectorWeight("car", car, options_), options_.large_alpha);
  // A conference table is as long as a car, and stands in a room.
  EXPECT_EQ(DetectorWeight("dining table", car, options_), options_.alpha);
  options_.room_thing_m = 5;
  EXPECT_EQ(DetectorWeight("car", car, options_), options_.alpha);
}

TEST_F(LikelihoodTest, ShowingLittleIsNoAdvantage) {
  // A perfect fit of a tenth of the contour is worth less than a good fit of all of it.
  const auto likelihoods =
      Evaluated({Lengths(0.4f, 0.4f, 4), Lengths(2.4f, 4, 4), Lengths(2.2f, 4, 4)});
  EXPECT_LT(likelihoods[0].phi_edge, 0.2f);
  EXPECT_GT(likelihoods[1].phi_edge, 0.55f);
}

TEST_F(LikelihoodTest, WhatIsMostlyHiddenScoresLittle) {
  const auto likelihoods = Evaluated({Lengths(0.1f, 0.1f, 4), Lengths(0.1f, 0.1f, 4)});
  EXPECT_NEAR(likelihoods[0].phi_edge, 0.1 / 0.8, 1e-6) << "a fifth of the contour at least";
}

TEST_F(LikelihoodTest, NothingVisibleIsNoEvidence) {
  const auto likelihoods = Evaluated({Lengths(0, 0, 4), Lengths(0, 0, 0)});
  for (const Likelihood& likelihood : likelihoods) {
    EXPECT_EQ(likelihood.phi_edge, 0);
    EXPECT_EQ(likelihood.visible_fraction, 0);
  }
  EXPECT_EQ(EdgeNormalizer({}), 0);
}

TEST_F(LikelihoodTest, AFixedNormalizerMakesCallsComparable) {
  const auto a = Evaluated({Lengths(1, 2, 4)}, {}, 3.0f);
  const auto b = Evaluated({Lengths(1, 2, 4), Lengths(2, 4, 4), Lengths(0, 4, 4)}, {}, 3.0f);
  EXPECT_EQ(a[0].phi_edge, b[0].phi_edge);
  EXPECT_NEAR(a[0].phi_edge, 1.0 / 3, 1e-6);
}

TEST_F(LikelihoodTest, TheBetterOfWholeAndVisibleBoxCounts) {
  const std::vector<Detection> boxes = {{{10, 10, 50, 40}, "chair", 0.8f}};
  EXPECT_NEAR(Evaluated({Lengths(1, 2, 4)}, boxes)[0].phi_cnn, 0.8, 1e-6);
  options_.scored_box = ScoredBox::kWhole;
  EXPECT_NEAR(Evaluated({Lengths(1, 2, 4)}, boxes)[0].phi_cnn, 0.8 * 30 / 80, 1e-6);
}

TEST_F(LikelihoodTest, EveryLabelIsScoredAsItsCategory) {
  labels_ = {map_.database->Find("chair").value(), map_.database->Find("vase").value(),
             map_.database->Find("armchair").value()};
  const std::vector<Detection> boxes = {{{10, 10, 50, 40}, "chair", 0.8f},
                                        {{10, 10, 50, 40}, "vase", 0.3f}};
  const auto likelihoods = Evaluated({Lengths(1, 2, 4), Lengths(1, 2, 4), Lengths(1, 2, 4)}, boxes);
  EXPECT_NEAR(likelihoods[0].phi_cnn, 0.8, 1e-6);
  EXPECT_NEAR(likelihoods[1].phi_cnn, 0.3, 1e-6);
  EXPECT_NEAR(likelihoods[2].phi_cnn, 0.8, 1e-6);
}

MapObject RandomObject() {
  MapObject object;
  object.id = ObjectId{7};
  object.state = ObjectState::kConfirmed;
  object.category = "chair";
  object.reference_frame = object.first_frame = 3;
  object.world_from_reference_cam = LookAt({2, 1, 1.3}, {0, 0, 0.5});
  object.confirmed_frame = 40;
  object.last_frame = 90;
  for (std::uint32_t i = 0; i < 100; ++i) {
    Random random({.particle = i});
    Particle particle = ToParticle({ModelId{static_cast<std::int32_t>(i % 2)},
                                    random.Gaussian(),
                                    {0.1 * random.Gaussian(), 0.1 * random.Gaussian(), 0.45}},
                                   object.world_from_reference_cam);
    particle.log_weight = -std::log(100.0f);
    object.particles.push_back(particle);
  }
  object.log_evidence = 4.5;
  object.seen_s = 2.25;
  object.last_search_s = 2.0;
  object.present_weight = 0.25;
  object.views = {{12, 1}, {40, 2.5}};
  object.memory.assign(100, 0.5f);
  object.outline_covariance = Eigen::Vector4d(1e-4, 2e-4, 3e-4, 4e-4).asDiagonal();
  object.outline_covariance(0, 3) = object.outline_covariance(3, 0) = 1e-5;
  object.last_proposal = Detection{{1, 2, 30, 40}, "chair", 0.7f};
  object.world_from_proposal_cam = LookAt({1, 2, 1.3}, {0, 0, 0.5});
  object.Summarize(MappingScene::Get().map());
  return object;
}

const ModelDatabase& Models() { return *MappingScene::Get().map().database; }

TEST(MapObject, ComesBackFromItsReport) {
  const MapObject object = RandomObject();
  const ObjectReport report = ToReport(object);
  const Result<MapObject> back = FromReport(report, Models());
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->id, object.id);
  EXPECT_EQ(back->state, object.state);
  EXPECT_EQ(back->confirmed_frame, object.confirmed_frame);
  EXPECT_EQ(back->log_evidence, object.log_evidence);
  EXPECT_EQ(back->seen_s, object.seen_s);
  EXPECT_EQ(back->last_search_s, object.last_search_s);
  EXPECT_EQ(back->present_weight, object.present_weight);
  ASSERT_EQ(back->views.size(), 2u);
  EXPECT_EQ(back->views[1].frame, 40);
  EXPECT_EQ(back->views[1].weight, 2.5);
  EXPECT_EQ(back->memory, object.memory);
  ASSERT_TRUE(back->last_proposal.has_value());
  EXPECT_EQ(back->last_proposal->box, object.last_proposal->box);
  EXPECT_EQ(back->last_proposal->category, "chair");
  EXPECT_TRUE(back->world_from_proposal_cam.isApprox(object.world_from_proposal_cam, 0));
  EXPECT_TRUE(back->mean().world_from_object.isApprox(object.mean().world_from_object, 0));
  ASSERT_EQ(back->particles.size(), object.particles.size());
  EXPECT_EQ(back->outline_covariance, object.outline_covariance);
  EXPECT_EQ(ToReport(*back).filter_state, report.filter_state);

  // Until 2026-11-28 one deviation of four numbers stood in its place.
  ObjectReport older = report;
  const double deviation[] = {0.01, 0.02, 0.03, 0.04};
  older.filter_state.resize(report.filter_state.size() - 16 * sizeof(double) + sizeof(deviation));
  std::memcpy(older.filter_state.data() + older.filter_state.size() - sizeof(deviation), deviation,
              sizeof(deviation));
  const Result<MapObject> restored = FromReport(older, Models());
  ASSERT_TRUE(restored.ok());
  const Eigen::Vector4d d = Eigen::Vector4d::Map(deviation);
  EXPECT_EQ(restored->outline_covariance, Eigen::Matrix4d(d * d.transpose()));
}

TEST(MapObject, TellsOfAnotherShapeInItsPlaceWhatIsMore) {
  const std::vector<ModelId> chairs = Models().OfCategory("chair");
  ASSERT_GE(chairs.size(), 2u);
  MapObject object = RandomObject();
  const MapFrame map = MappingScene::Get().map();
  for (Particle& particle : object.particles)
    particle.label = static_cast<std::uint16_t>(chairs[0].value);
  object.Summarize(map);
  EXPECT_EQ(object.label_probability.size(), 1u) << "all of one shape";
  object.shapes_in_place = {{chairs[0], 0.75}, {chairs[1], 0.25}};
  object.Summarize(map);
  ASSERT_EQ(object.label_probability.size(), 2u);
  EXPECT_EQ(object.label_probability[0].label, chairs[0]);
  EXPECT_EQ(object.label_probability[0].probability, 0.75);
  EXPECT_EQ(object.label_probability[1].probability, 0.25);

  const Result<MapObject> back = FromReport(ToReport(object), Models());
  ASSERT_TRUE(back.ok());
  ASSERT_EQ(back->shapes_in_place.size(), 2u);
  EXPECT_EQ(back->shapes_in_place[1].label, chairs[1]);
  EXPECT_EQ(back->shapes_in_place[1].probability, 0.25);
  EXPECT_EQ(ToReport(*back).filter_state, ToReport(object).filter_state);

  // Particles that doubt more are told as they are, and once they are of another shape mostly, what
  // was found in its place before is not.
  for (std::size_t i = 0; i < 40; ++i)
    object.particles[i].label = static_cast<std::uint16_t>(chairs[1].value);
  object.Summarize(map);
  EXPECT_NEAR(object.label_probability[0].probability, 0.6, 1e-6);
  for (std::size_t i = 0; i < 70; ++i)
    object.particles[i].label = static_cast<std::uint16_t>(chairs[1].value);
  object.Summarize(map);
  EXPECT_EQ(object.label_probability[0].label, chairs[1]);
  EXPECT_NEAR(object.label_probability[0].probability, 0.7, 1e-6);

  object.shapes_in_place = {{chairs[0], 0.75}, {ModelId{1000}, 0.25}};
  EXPECT_FALSE(FromReport(ToReport(object), Models()).ok()) << "of a model that is not there";
}

TEST(MapObject, AReportThatLacksWhatResumingNeedsIsAnError) {
  const ObjectReport good = ToReport(RandomObject());
  ObjectReport bad = good;
  bad.particles.reset();
  EXPECT_FALSE(FromReport(bad, Models()).ok());
  bad = good;
  bad.modes.clear();
  EXPECT_FALSE(FromReport(bad, Models()).ok());
  bad = good;
  bad.filter_state.pop_back();
  ASSERT_FALSE(FromReport(bad, Models()).ok());
  EXPECT_EQ(FromReport(bad, Models()).error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(FromReport(bad, Models()).error().message, testing::HasSubstr("object 7"));
  MapObject joined = RandomObject();
  joined.joined.push_back({ModelId{1000}, 0, {0, 0, 0}});
  EXPECT_FALSE(FromReport(ToReport(joined), Models()).ok()) << "of a model that is not there";
}

TEST(ByteReader, TakesNoOtherByteForATruthValue) {
  ByteReader good(std::string_view("\1\0", 2));
  EXPECT_TRUE(good.Get<bool>());
  EXPECT_FALSE(good.Get<bool>());
  EXPECT_TRUE(good.ok());
  ByteReader bad("u");
  EXPECT_FALSE(bad.Get<bool>());
  EXPECT_FALSE(bad.ok());
}

TEST(Bytes, ReadingPastTheEndGivesZerosAndSaysSo) {
  ByteWriter out;
  out.Put(std::int32_t{5});
  const std::string bytes = out.Take();
  ByteReader in(bytes);
  EXPECT_EQ(in.Get<std::int32_t>(), 5);
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.Get<double>(), 0);
  EXPECT_FALSE(in.ok());
}

}  // namespace
}  // namespace plumbline
