// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/reliability.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace plumbline {
namespace {

std::shared_ptr<const FrameSample> FrameOf(std::initializer_list<ObjectSample> objects) {
  auto frame = std::make_shared<FrameSample>();
  frame->objects = objects;
  return frame;
}

ObjectSample Sample(int id, float level, double claimed, bool right, float distance_m = 0.1f) {
  ObjectSample sample;
  sample.id = {id};
  sample.state = ObjectState::kConfirmed;
  sample.updated = true;
  sample.label_probability = {{{0}, claimed}};
  sample.error = TruthError{"truth " + std::to_string(id), right, distance_m, 0, level, 2};
  return sample;
}

RunHistory SomeRun() {
  ObjectSample tentative = Sample(3, 0.1f, 0.9, true), hidden = tentative, unknown = tentative;
  tentative.state = ObjectState::kTentative;
  hidden.updated = false;
  unknown.error.reset();
  RunHistory history;
  history.frames = {nullptr, FrameOf({Sample(1, 0.3f, 0.95, true), Sample(2, 0.7f, 0.6, false)}),
                    FrameOf({Sample(1, 0.99f, 1.0, true), Sample(9, 0.1f, 1, true, 0.8f)}),
                    FrameOf({tentative, hidden, unknown})};
  return history;
}

TEST(Reliability, CountsWhatWasClaimedAgainstWhatWasSo) {
  const RunReliability run = ReliabilityOf(SomeRun());
  EXPECT_EQ(run.all.poses, 3)
      << "neither what is far from any truth nor what is tentative or hidden";
  EXPECT_EQ(run.all.within_50, 1);
  EXPECT_EQ(run.all.within_95, 2);
  EXPECT_EQ(run.all.labels.count, 3);
  EXPECT_EQ(run.all.labels.right, 2);
  EXPECT_NEAR(run.all.labels.claimed, 0.95 + 0.6 + 1.0, 1e-12);
  EXPECT_EQ(run.all.labels.bins[6].count, 1);
  EXPECT_EQ(run.all.labels.bins[9].right, 2);
  ASSERT_EQ(run.objects.size(), 2u);
  EXPECT_EQ(run.objects[0].object, ObjectId{1});
  EXPECT_EQ(run.objects[0].reliability.poses, 2);
  EXPECT_EQ(run.objects[1].reliability.within_50, 0);
  EXPECT_EQ(ReliabilityOf({}).all.poses, 0);
}

TEST(Reliability, SaysNothingOfLabelsWhereThereIsNoChoice) {
  ObjectSample only_model = Sample(1, 0.3f, 1, true);
  only_model.error->several_models = false;
  RunHistory history;
  history.frames = {FrameOf({only_model})};
  EXPECT_EQ(ReliabilityOf(history).all.labels.count, 0);
  EXPECT_EQ(ReliabilityOf(history).all.poses, 1);
}

TEST(Reliability, IsAMeanOverObjectsNotFramesForTheNees) {
  RunHistory history;
  ObjectSample round = Sample(2, 0.5f, 1, true);
  round.error->nees = 6;
  round.error->degrees_of_freedom = 3;
  for (int i = 0; i < 9; ++i) history.frames.push_back(FrameOf({Sample(1, 0.5f, 1, true)}));
  history.frames.push_back(FrameOf({Sample(1, 0.5f, 1, true), round}));
  const Reliability all = ReliabilityOf(history).all;
  EXPECT_EQ(all.objects, 2);
  EXPECT_NEAR(all.nees, (2 + 8) / 2.0, 1e-6) << "2, and 6 for three degrees of freedom";
  EXPECT_LT(all.nees_low, 1);
  EXPECT_GT(all.nees_high, 8.767) << "what a Gaussian belief would have";
}

TEST(Reliability, AtTheEndLooksAtTheLastUsedFrame) {
  RunHistory history = SomeRun();
  auto skipped = std::make_shared<FrameSample>();
  skipped->skipped = true;
  history.frames.push_back(skipped);
  const RunReliability end = ReliabilityAtEnd(history);
  EXPECT_EQ(end.all.poses, 1) << "the confirmed one, though it was not updated";
  EXPECT_EQ(ReliabilityAtEnd({}).all.poses, 0);
}

TEST(Confirmation, RanksObjectsByHowSurelyTheyAreThere) {
  ObjectSample there = Sample(1, 0.1f, 1, true), tentative = Sample(2, 0.1f, 1, true),
               far = Sample(3, 0.1f, 1, true, 0.9f), gone = Sample(4, 0.1f, 1, true);
  there.log_evidence = 2;
  tentative.state = ObjectState::kTentative;
  tentative.log_evidence = 0;
  far.log_evidence = 1;
  gone.state = ObjectState::kRetired;
  RunHistory history;
  history.frames = {FrameOf({there, tentative, far, gone})};
  const PrecisionRecall curve = ConfirmationOf(history, 4);
  ASSERT_EQ(curve.points.size(), 3u);
  EXPECT_NEAR(curve.points[0].threshold, 0.8808, 1e-4);
  EXPECT_EQ(curve.points[1].precision, 0.5);
  EXPECT_NEAR(curve.points[2].threshold, 0.5, 1e-6);
  EXPECT_EQ(curve.points[2].recall, 0.5);
}

TEST(Belief, IsAllInTheJson) {
  const nlohmann::json json = BeliefToJson(SomeRun(), 5);
  EXPECT_EQ(json["along_the_run"]["poses"], 3);
  EXPECT_NEAR(json["along_the_run"]["truth_in_95_percent"].get<double>(), 2.0 / 3, 1e-12);
  EXPECT_NEAR(json["along_the_run"]["labels"]["expected_calibration_error"].get<double>(),
              (0.6 + 0.05) / 3, 1e-12);
  EXPECT_EQ(json["at_the_end"]["poses"], 1);
  EXPECT_EQ(json["confirmation"]["truths"], 5);
  ASSERT_EQ(json["objects"].size(), 3u) << "of the last frame, confirmed or not";
  EXPECT_EQ(json["objects"][1]["ground_truth"], "truth 3");
  EXPECT_TRUE(json["objects"][2]["ground_truth"].is_null());
  EXPECT_TRUE(BeliefToJson({}, 0)["at_the_end"]["nees"].is_null());
}

}  // namespace
}  // namespace plumbline
