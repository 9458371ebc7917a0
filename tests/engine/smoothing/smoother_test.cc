// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/smoother.h"

#include <gtest/gtest.h>

#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

constexpr int kFrames = 40, kFirstBoxOfArmchair = 24;

/// A walk past a table, a chair and an armchair, mapped; the detector finds the armchair late.
class Walk {
 public:
  static const Walk& Get() {
    static const Walk walk;
    return walk;
  }

  SmoothingTask Task() const {
    SmoothingTask task;
    task.setup = setup_;
    task.load = [this](int frame) { return Input(frame); };
    for (int i = 0; i < kFrames; ++i) task.frames.push_back({i, Stamp(i), Camera(i)});
    for (const auto& [id, report] : last_) task.objects.push_back(report);
    return task;
  }
  double Error(const ObjectReport& object) const {
    double nearest = 1e9;
    for (const PlacedModel& truth : truth_) {
      if (truth.label == object.label) {
        nearest = std::min(nearest, (object.world_from_object.translation() -
                                     truth.world_from_object.translation())
                                        .norm());
      }
    }
    return nearest;
  }
  const ObjectReport& Causal(ObjectId id) const { return last_.at(id.value); }
  const ObjectReport* CausalArmchair() const {
    for (const auto& [id, report] : last_) {
      if (report.state == ObjectState::kConfirmed && report.label == scene_.Label("armchair"))
        return &report;
    }
    return nullptr;
  }

 private:
  Walk() {
    setup_.camera = scene_.camera();
    setup_.floor_in_world = scene_.map().floor_in_world;
    setup_.database = scene_.database();
    setup_.scorer = scene_.scorer();
    setup_.seed = 5;
    const auto mapper = Mapper::Create(setup_).value();
    for (int i = 0; i < kFrames; ++i) {
      for (const ObjectReport& object : mapper->Step(Input(i)).objects)
        last_[object.id.value] = object;
    }
  }
  static std::int64_t Stamp(int frame) { return 100'000'000LL * (frame + 1); }
  static Eigen::Isometry3d Camera(int frame) {
    const double angle = -0.9 + 0.045 * frame;
    return LookAt({3.2 * std::sin(angle), -3.2 * std::cos(angle), 1.5}, {0, 0, 0.4});
  }
  MapperInput Input(int frame) const {
    MapperInput input = scene_.Input(frame, Camera(frame), truth_);
    if (frame < kFirstBoxOfArmchair) {
      std::vector<PlacedModel> boxed = truth_;
      boxed.pop_back();
      input.detections = DetectionsFromProposals(scene_.Boxes(Camera(frame), boxed));
    }
    return input;
  }

  MappingScene& scene_ = MappingScene::Get();
  std::vector<PlacedModel> truth_ = {scene_.Place("table", 0.1, 0.5, 20, 1),
                                     scene_.Place("chair", -0.9, -0.3, 70, 2),
                                     scene_.Place("armchair", 0.9, -0.4, -40, 3)};
  MapperSetup setup_;
  std::map<int, ObjectReport> last_;
};

const SmoothedMap& Smoothed() {
  static const SmoothedMap map = Smooth(Walk::Get().Task(), {}).value();
  return map;
}

TEST(Smoother, IsNoWorseThanTheRunAndKeepsWhatItFound) {
  double causal = 0, smoothed = 0;
  int confirmed = 0;
  for (const SmoothedObject& object : Smoothed().objects) {
    const ObjectReport& before = Walk::Get().Causal(object.belief.id);
    if (before.state != ObjectState::kConfirmed) continue;
    ASSERT_EQ(object.belief.state, ObjectState::kConfirmed);
    ++confirmed;
    causal += Walk::Get().Error(before);
    smoothed += Walk::Get().Error(object.belief);
    EXPECT_LT(Walk::Get().Error(object.belief), 0.01) << object.belief.id.value;
    EXPECT_GT(object.views, 3);
    EXPECT_GT(object.belief.covariance(0, 0), 0);
  }
  EXPECT_GE(confirmed, 2);
  EXPECT_LE(smoothed, causal + 0.001 * confirmed)
      << "edges are drawn to a pixel, 7 mm at this distance: both are at the limit of that";
}

TEST(Smoother, ScoresAnObjectThatWasFoundLateInTheFramesBefore) {
  const ObjectReport* causal = Walk::Get().CausalArmchair();
  ASSERT_NE(causal, nullptr);
  ASSERT_GE(causal->first_frame, kFirstBoxOfArmchair);
  for (const SmoothedObject& object : Smoothed().objects) {
    if (object.belief.id != causal->id) continue;
    EXPECT_LT(object.belief.first_frame, 5);
    EXPECT_GT(object.looks_before, 5);
    EXPECT_GT(object.looks, object.looks_before);
    EXPECT_EQ(object.spawned_frame, causal->first_frame);
    return;
  }
  FAIL() << "it is gone";
}

TEST(Smoother, GivesTheSameAgain) {
  const SmoothedMap again = Smooth(Walk::Get().Task(), {}).value();
  ASSERT_EQ(again.objects.size(), Smoothed().objects.size());
  for (std::size_t i = 0; i < again.objects.size(); ++i) {
    const ObjectReport &a = again.objects[i].belief, &b = Smoothed().objects[i].belief;
    EXPECT_EQ(a.world_from_object.matrix(), b.world_from_object.matrix());
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.log_evidence, b.log_evidence);
  }
}

TEST(Smoother, CanBeCancelled) {
  std::stop_source stop;
  int stages = 0;
  WorkContext work;
  work.stop = stop.get_token();
  work.report = [&](const Progress& progress) {
    if (progress.stage == "looking back" && ++stages == 3) stop.request_stop();
  };
  const Result<SmoothedMap> map = Smooth(Walk::Get().Task(), work);
  ASSERT_FALSE(map.ok());
  EXPECT_EQ(map.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(stages, 3);
}

TEST(Smoother, RefusesARunThatUsedNoFrame) {
  SmoothingTask task = Walk::Get().Task();
  task.frames.clear();
  EXPECT_EQ(Smooth(task, {}).error().code, ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace plumbline
