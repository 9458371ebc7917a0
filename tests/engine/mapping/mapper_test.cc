// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/mapper.h"

#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

class MapperTest : public testing::Test {
 protected:
  std::unique_ptr<Mapper> NewMapper(const MapperOptions& options = {},
                                    std::vector<FloorLevel> levels = {}) {
    MapperSetup setup;
    setup.camera = scene_.camera();
    setup.floor_in_world = scene_.map().floor_in_world;
    setup.database = scene_.database();
    setup.scorer = scene_.scorer();
    setup.options = options;
    setup.floor_levels = std::move(levels);
    return Mapper::Create(setup).value();
  }
  /// A frame of a walk about the origin, 12 cm and 3.4 degrees from the one before.
  MapperInput Seen(int frame, std::span<const PlacedModel> objects) {
    const double angle = 0.3 + 0.06 * frame;
    return scene_.Input(frame, LookAt({2 * std::cos(angle), 2 * std::sin(angle), 1.4}, {0, 0, 0.4}),
                        objects);
  }
  /// The best object of the last frame that has one, after so many in which `thing` is seen.
  ObjectReport AfterSeeing(const PlacedModel& thing, int frames, const MapperOptions& options) {
    const auto mapper = NewMapper(options);
    ObjectReport last;
    for (int frame = 0; frame < frames; ++frame) {
      const FrameReport report = mapper->Step(Seen(frame, {&thing, 1}));
      if (const ObjectReport* best = Best(report)) last = *best;
    }
    return last;
  }
  static const ObjectReport* Best(const FrameReport& report) {
    const ObjectReport* best = nullptr;
    for (const ObjectReport& object : report.objects)
      if (best == nullptr || object.log_evidence > best->log_evidence) best = &object;
    return best;
  }

  MappingScene& scene_ = MappingScene::Get();
};

/// The chairs of the scene are things that move by themselves.
class MapperOfMoversTest : public MapperTest {
 protected:
  std::unique_ptr<Mapper> NewMapperOfMovers(const MapperOptions& options = {}) {
    std::vector<CadModel> models = scene_.database()->models();
    for (CadModel& model : models)
      if (model.category == "chair") model.category = "dog";
    MapperSetup setup;
    setup.camera = scene_.camera();
    setup.floor_in_world = scene_.map().floor_in_world;
    setup.database = ModelDatabase::FromModels(std::move(models));
    setup.scorer = scene_.scorer();
    setup.options = options;
    return Mapper::Create(setup).value();
  }
  /// Of a walk past it, 12 cm a frame.
  MapperInput Passed(int frame, const PlacedModel& dog, float score = 0.8f) {
    MapperInput input = scene_.Input(
        frame, LookAt({0.12 * frame - 2, -2.2, 1.4}, {0.12 * frame - 0.5, 0.5, 0.3}), {&dog, 1});
    std::vector<Detection> boxes;
    for (const Detection& box : input.detections->proposals())
      boxes.push_back({box.box, "dog", score});
    input.detections = DetectionsFromProposals(std::move(boxes));
    return input;
  }
  static bool HasConfirmed(const FrameReport& report) {
    const ObjectReport* best = Best(report);
    return best != nullptr && best->state == ObjectState::kConfirmed;
  }
};

TEST_F(MapperOfMoversTest, WhatStandsIsMappedAndWhatWalksAlongIsNot) {
  constexpr int kFrames = 24;
  for (const double step_m : {0.0, 0.12}) {
    const auto mapper = NewMapperOfMovers();
    int confirmed = 0;
    for (int frame = 0; frame < kFrames; ++frame)
      confirmed += HasConfirmed(
          mapper->Step(Passed(frame, scene_.Place("chair", step_m * frame - 0.5, 0.3, 30))));
    if (step_m > 0)
      EXPECT_EQ(confirmed, 0);
    else
      EXPECT_GT(confirmed, 0);
  }
}

TEST_F(MapperOfMoversTest, BoxesOfBeforeItWasSpawnedTellThatItStands) {
  // Boxes below min_spawn_score spawn nothing, but are remembered.
  constexpr int kSpawnedFrom = 10;
  MapperOptions options;
  options.confirm_age_s = 1.5;  // 15 frames
  const PlacedModel chair = scene_.Place("chair", 0, 0.3, 30);
  const auto frames_until_confirmed = [&](int first_frame) {
    const auto mapper = NewMapperOfMovers(options);
    for (int frame = first_frame; frame < 30; ++frame) {
      MapperInput input = Passed(frame, chair, frame < kSpawnedFrom ? 0.3f : 0.8f);
      // From then on every other image has none, so that enough of them take their time.
      if (frame > kSpawnedFrom && (frame - kSpawnedFrom) % 2 == 1)
        input.detections = DetectionsFromProposals({});
      if (HasConfirmed(mapper->Step(input))) return frame - kSpawnedFrom;
    }
    return 100;
  };
  const int with = frames_until_confirmed(0);
  EXPECT_LT(with, 15);
  EXPECT_LT(with, frames_until_confirmed(kSpawnedFrom));
}

TEST_F(MapperOfMoversTest, WhatIsPassedIsNotKnownByTheImageThatItLeavesAlone) {
  MapperOptions options;
  options.room_thing_m = 0.5;  // so that chairs are large
  const PlacedModel chair = scene_.Place("chair", 0, 0.3, 30);
  const auto mapper = NewMapperOfMovers(options);
  double seen = 0, most = 0;
  bool confirmed = false;
  for (int frame = 0; frame < 24; ++frame) {
    const double x = 0.25 * frame - 5;
    MapperInput input =
        scene_.Input(frame, LookAt({x, -0.9, 1.4}, {x + 3, -0.2, 0.3}), {&chair, 1});
    std::vector<Detection> boxes;
    for (const Detection& box : input.detections->proposals())
      boxes.push_back({box.box, "dog", 0.8f});
    input.detections = DetectionsFromProposals(std::move(boxes));
    const FrameReport report = mapper->Step(input);
    const ObjectReport* best = Best(report);
    if (best == nullptr || best->state != ObjectState::kConfirmed) continue;
    confirmed = true;
    const Result<MapObject> object = FromReport(*best, *scene_.database());
    ASSERT_TRUE(object.ok());
    seen = most = 0;
    for (const ObjectView& view : object->views) {
      seen += view.weight;
      most = std::max(most, view.weight);
    }
    EXPECT_LT(
        (best->world_from_object.translation() - chair.world_from_object.translation()).norm(),
        0.05)
        << "frame " << frame;
  }
  ASSERT_TRUE(confirmed);
  EXPECT_LT(most, 0.3 * seen);
}

/// Takes a millisecond for every question.
class SlowDetections : public FrameDetections {
 public:
  SlowDetections(std::shared_ptr<const FrameDetections> detections, int* questions)
      : detections_(std::move(detections)), questions_(questions) {}
  std::span<const Detection> proposals() const override { return detections_->proposals(); }
  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    ++*questions_;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    detections_->ScoreBoxes(category, boxes, scores);
  }

 private:
  std::shared_ptr<const FrameDetections> detections_;
  int* questions_;
};

TEST_F(MapperTest, TopDownScoresAreAStageOfTheirOwn) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto mapper = NewMapper();
  for (int frame = 0; frame < 3; ++frame) {
    int questions = 0;
    MapperInput input = Seen(frame, {&chair, 1});
    input.detections = std::make_shared<SlowDetections>(input.detections, &questions);
    const FrameReport report = mapper->Step(input);
    const StageTiming& boxes = report.timings.front();
    EXPECT_EQ(boxes.stage, "score boxes");
    EXPECT_GE(boxes.milliseconds, questions);
    EXPECT_TRUE(frame == 0 || questions > 0);
  }
}

TEST_F(MapperTest, WhatIsSpawnedLateIsJudgedByTheViewsBefore) {
  constexpr int kSpawnedFrom = 14, kEnd = 20;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  // Until then boxes are too weak to spawn anything, or there are none.
  const auto log_odds_after = [&](bool boxed) {
    const auto mapper = NewMapper();
    double log_odds = 0;
    for (int frame = 0; frame < kEnd; ++frame) {
      MapperInput input = Seen(frame, {&chair, 1});
      if (frame < kSpawnedFrom) {
        std::vector<Detection> boxes;
        for (const Detection& box : input.detections->proposals())
          if (boxed) boxes.push_back({box.box, box.category, 0.3f});
        input.detections = DetectionsFromProposals(std::move(boxes));
      }
      const FrameReport report = mapper->Step(input);
      if (const ObjectReport* best = Best(report)) log_odds = best->log_evidence;
    }
    return log_odds;
  };
  const double without = log_odds_after(false);
  EXPECT_GT(log_odds_after(true), without + 1) << "it was in full view without a box";
  EXPECT_GT(without, MapperOptions().confirm_evidence);
}

TEST_F(MapperTest, WhatIsPlantedHasToEarnItsPlace) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto planted_at = [&](const PlacedModel& place) {
    const auto mapper = NewMapper();
    mapper->Plant(place.label, place.world_from_object, 1, "planted by a test");
    FrameReport report;
    for (int frame = 0; frame < 25; ++frame) {
      MapperInput input = Seen(frame, {&chair, 1});
      input.detections = DetectionsFromProposals({});  // nobody else is born
      report = mapper->Step(input);
      if (frame > 0) continue;
      EXPECT_EQ(report.events.front().text, "planted by a test");
      EXPECT_EQ(report.objects.front().state, ObjectState::kTentative);
    }
    return report;
  };
  const FrameReport there = planted_at(chair);
  ASSERT_EQ(there.objects.size(), 1u);
  EXPECT_LT(
      (there.objects[0].world_from_object.translation() - chair.world_from_object.translation())
          .norm(),
      0.02);
  const FrameReport nowhere = planted_at(scene_.Place("chair", -1.3, 0.9, 200));
  const double evidence = nowhere.objects.empty() ? -10 : nowhere.objects.front().log_evidence;
  EXPECT_GT(there.objects[0].log_evidence, evidence + 1);
}

TEST_F(MapperTest, AnObjectLargerThanItsModelIsFoundAtItsScale) {
  constexpr int kEnd = 30;
  for (const double scale : {0.96, 1.04}) {
    PlacedModel chair = scene_.Place("chair", 0, 0, 30);
    chair.scale = scale;
    const auto found = [&](double scale_std) {
      MapperOptions options;
      options.scale_std = scale_std;
      return AfterSeeing(chair, kEnd, options);
    };
    const ObjectReport fixed = found(0), free = found(0.03);
    EXPECT_EQ(fixed.scale, 1);
    EXPECT_EQ(fixed.scale_std, 0);
    EXPECT_NEAR(free.scale, scale, 0.015);
    EXPECT_GT(free.scale_std, 0.001);
    EXPECT_LT(free.scale_std, 0.03) << "better known than before";
    EXPECT_LT(free.world_from_object.translation().norm(), 0.03);
    EXPECT_EQ(free.label, chair.label);
  }
}

TEST_F(MapperTest, ShapesAreToldApartAsSharplyAsTheirTemperatureSays) {
  constexpr int kEnd = 40;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto found = [&](double temperature) {
    MapperOptions options;
    options.shape_temperature = temperature;
    return AfterSeeing(chair, kEnd, options);
  };
  const ObjectReport cold = found(1), warm = found(100), hot = found(1000);
  ASSERT_EQ(cold.state, ObjectState::kConfirmed);
  const auto told = [&](const ObjectReport& object) {
    EXPECT_EQ(object.label, chair.label);
    EXPECT_EQ(object.label_probability.front().label, chair.label);
    double sum = 0;
    for (const LabelProbability& label : object.label_probability) sum += label.probability;
    EXPECT_NEAR(sum, 1, 1e-9);
    return object.label_probability.front().probability;
  };
  const double others = static_cast<double>(scene_.database()->OfCategory("chair").size()) - 1;
  ASSERT_GE(others, 1);
  EXPECT_GT(told(cold), 0.999);
  EXPECT_LT(told(warm), told(cold));
  EXPECT_GT(told(warm), told(hot));
  EXPECT_NEAR(told(hot), 1 / (1 + others), 0.05);
  // It is told, and changes nothing of what is believed.
  EXPECT_TRUE(cold.world_from_object.isApprox(hot.world_from_object, 0));
  EXPECT_EQ(cold.log_evidence, hot.log_evidence);
}

TEST_F(MapperTest, AChairOnAPlatformIsFoundThereIfThePlatformIsTold) {
  constexpr int kEnd = 30;
  PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  chair.world_from_object.translation().z() = 0.3;
  const auto off = [&](std::vector<FloorLevel> levels) {
    const auto mapper = NewMapper({}, std::move(levels));
    double off_m = 10;
    for (int frame = 0; frame < kEnd; ++frame) {
      const FrameReport report = mapper->Step(Seen(frame, {&chair, 1}));
      if (const ObjectReport* best = Best(report); best != nullptr && best->confirmed_frame)
        off_m =
            (best->world_from_object.translation() - chair.world_from_object.translation()).norm();
    }
    return off_m;
  };
  EXPECT_LT(off({{0.3, 0, {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}}}), 0.02);
  EXPECT_LT(off({{0.3, 0.01, {}}}), 0.02) << "without an outline it may be anywhere";
  EXPECT_GT(off({}), 0.1) << "nothing stands 30 cm above the only floor";
}

TEST_F(MapperTest, PointsBeforeAnObjectExcuseItsAbsence) {
  constexpr int kSeen = 16, kEnd = 20;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto log_odds_lost = [&](bool points) {
    const auto mapper = NewMapper();
    double before = 0, after = 0;
    for (int frame = 0; frame < kEnd; ++frame) {
      const FrameReport report =
          mapper->Step(Seen(frame, {&chair, frame < kSeen ? std::size_t{1} : std::size_t{0}}));
      const ObjectReport* best = Best(report);
      if (frame == kSeen - 1) before = best != nullptr ? best->log_evidence : 0;
      if (frame >= kSeen) after = best != nullptr ? best->log_evidence : -10;
      if (frame != kSeen - 1 || !points) continue;
      // A curtain half way between the walk and the chair.
      std::vector<Eigen::Vector3f> curtain;
      for (float angle = 0; angle < 3; angle += 0.02f) {
        for (float z = 0; z < 1.6f; z += 0.02f)
          curtain.emplace_back(1.2f * std::cos(angle), 1.2f * std::sin(angle), z);
      }
      mapper->AddPoints({}, curtain);
    }
    EXPECT_GT(before, 0) << "the chair was found";
    return before - after;
  };
  const double without = log_odds_lost(false);
  EXPECT_GT(without, 1);
  EXPECT_LT(log_odds_lost(true), 0.5 * without);
}

TEST_F(MapperTest, AConfirmedObjectThatIsLostIsGivenUpAfterSomeLooks) {
  constexpr int kSeen = 16;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30), twin = scene_.Place("chair", 1, 0, 30);
  const auto mapper = NewMapper();
  FrameReport report;
  for (int frame = 0; frame < kSeen; ++frame) report = mapper->Step(Seen(frame, {&chair, 1}));
  ASSERT_EQ(report.objects.size(), 1u);
  ObjectReport& object = report.objects.front();
  ASSERT_EQ(object.state, ObjectState::kConfirmed);
  // Half of the belief goes to an equal chair, which all images show from now on, those before too;
  // and they hardly count, or the belief would soon be in one of the two.
  std::vector<Particle> torn = *object.particles;
  for (std::size_t i = 0; i < torn.size(); i += 2) {
    PoseHypothesis moved = ToHypothesis(torn[i], object.world_from_reference_cam);
    moved.center_in_world += Eigen::Vector3d::UnitX();
    const float log_weight = torn[i].log_weight;
    torn[i] = ToParticle(moved, object.world_from_reference_cam);
    torn[i].log_weight = log_weight;
  }
  object.particles = std::make_shared<const std::vector<Particle>>(std::move(torn));
  const std::vector<PlacedModel> both = {chair, twin};
  const auto load = [&](int frame) -> Result<MapperInput> {
    MapperInput input = Seen(frame, both);
    input.detections = DetectionsFromProposals({});
    return input;
  };
  MapperOptions blind;
  blind.alpha = blind.beta = 1e-3;
  const auto resumed = NewMapper(blind);
  ASSERT_TRUE(resumed->Restore(report, load).ok());
  int gone = -1;
  for (int frame = kSeen; frame < kSeen + 12 && gone < 0; ++frame) {
    for (const auto& event : resumed->Step(*load(frame)).events) {
      if (event.kind != EventKind::kRetired) continue;
      EXPECT_EQ(event.text, "in view, and no longer known where it stands");
      gone = frame - kSeen;
    }
  }
  EXPECT_GE(gone, 2) << "one image may mislead";
}

TEST_F(MapperTest, WhatIsLessLikelyThereThanNotIsWithdrawn) {
  constexpr int kSeen = 16;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto mapper = NewMapper();
  FrameReport report;
  for (int frame = 0; frame < kSeen; ++frame) report = mapper->Step(Seen(frame, {&chair, 1}));
  ASSERT_EQ(report.objects.size(), 1u);
  ASSERT_EQ(report.objects.front().state, ObjectState::kConfirmed);
  report.objects.front().log_evidence = 0.1f;
  const auto load = [&](int frame) -> Result<MapperInput> { return Seen(frame, {&chair, 1}); };
  const auto resumed = NewMapper();
  ASSERT_TRUE(resumed->Restore(report, load).ok());
  // It has been taken away.
  int gone = -1;
  for (int frame = kSeen; frame < kSeen + 30 && gone < 0; ++frame) {
    report = resumed->Step(Seen(frame, {}));
    for (const ObjectReport& object : report.objects)
      EXPECT_TRUE(object.state != ObjectState::kConfirmed || object.log_evidence >= 0) << frame;
    for (const auto& event : report.events)
      if (event.kind == EventKind::kRetired) gone = frame;
  }
  EXPECT_GE(gone, kSeen);
}

TEST_F(MapperTest, OfTwoInOnePlaceTheOneInViewStays) {
  constexpr int kSeen = 16;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto load = [&](int frame) -> Result<MapperInput> { return Seen(frame, {&chair, 1}); };
  const auto mapper = NewMapper();
  FrameReport report;
  for (int frame = 0; frame < kSeen; ++frame) report = mapper->Step(*load(frame));
  ASSERT_EQ(report.objects.size(), 1u);
  const ObjectId seen = report.objects.front().id;
  // Another one that reaches into it has more evidence, and is beyond the border from here on.
  ObjectReport other = report.objects.front();
  other.id = ObjectId{77};
  other.log_evidence += 5;
  other.modes.front().world_from_object.pretranslate(Eigen::Vector3d(0, 0.38, 0));
  report.objects.push_back(other);
  const auto resumed = NewMapper();
  ASSERT_TRUE(resumed->Restore(report, load).ok());
  for (int frame = kSeen; frame < kSeen + 4; ++frame) {
    const Eigen::Vector3d from(2 + 0.1 * (frame - kSeen), 0, 1.4);
    report = resumed->Step(scene_.Input(frame, LookAt(from, {0, -1.5, 0.4}), {&chair, 1}));
  }
  ASSERT_EQ(report.objects.size(), 1u);
  EXPECT_EQ(report.objects.front().id, seen);
}

TEST_F(MapperTest, WhatHidesASettledObjectDoesNotMoveIt) {
  constexpr int kSeen = 16, kEnd = 48;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  // What is seen of it later are edges of another thing, a little to the side, that no box tells
  // of.
  const PlacedModel other = scene_.Place("armchair", 0.25, 0.15, 75, 2);
  const auto mapper = NewMapper();
  double std_before_m = 0;
  for (int frame = 0; frame < kEnd; ++frame) {
    MapperInput input = Seen(frame, {frame < kSeen ? &chair : &other, 1});
    if (frame >= kSeen) input.detections = DetectionsFromProposals({});
    const FrameReport report = mapper->Step(input);
    ASSERT_FALSE(report.objects.empty());
    const ObjectReport& object = report.objects.front();
    if (frame < kSeen - 1) continue;
    ASSERT_EQ(object.state, ObjectState::kConfirmed) << "frame " << frame;
    const double std_m = object.modes.front().position_std_m;
    if (frame == kSeen - 1) std_before_m = std_m;
    EXPECT_LT(std_m, 1.7 * std_before_m) << "frame " << frame;
    EXPECT_LT(
        (object.world_from_object.translation() - chair.world_from_object.translation()).norm(),
        0.02)
        << "frame " << frame;
  }
}

TEST_F(MapperTest, WhatStandsOnTheFloorIsNotScoredByTheOutlineOfWhatNeedNot) {
  constexpr int kSeen = 16;
  std::vector<CadModel> models = scene_.database()->models();
  CadModel& raised = models[static_cast<std::size_t>(scene_.Label("armchair").value)];
  raised.category = "tv";
  raised.support = Support::kAny;
  const auto new_mapper = [&] {
    MapperSetup setup;
    setup.camera = scene_.camera();
    setup.floor_in_world = scene_.map().floor_in_world;
    setup.database = ModelDatabase::FromModels(models);
    setup.scorer = scene_.scorer();
    return Mapper::Create(setup).value();
  };
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto load = [&](int frame) -> Result<MapperInput> { return Seen(frame, {&chair, 1}); };
  const auto mapper = new_mapper();
  FrameReport report;
  for (int frame = 0; frame < kSeen; ++frame) report = mapper->Step(*load(frame));
  ASSERT_EQ(report.objects.size(), 1u);
  ASSERT_EQ(report.objects.front().state, ObjectState::kConfirmed);
  // Something else in the same lines, too little nearer to hide the chair.
  const Eigen::Isometry3d camera = load(kSeen)->world_from_cam;
  ObjectReport other = report.objects.front();
  other.id = ObjectId{77};
  other.category = raised.category;
  other.modes.front().label = scene_.Label("armchair");
  Eigen::Isometry3d& place = other.modes.front().world_from_object;
  place.pretranslate(0.03 * (camera.translation() - place.translation()).normalized());
  const auto edges_of_chair = [&](const FrameReport& last) {
    const auto resumed = new_mapper();
    EXPECT_TRUE(resumed->Restore(last, load).ok());
    return resumed->Step(*load(kSeen)).objects.front().phi_edge;
  };
  const float alone = edges_of_chair(report);
  EXPECT_GT(alone, 0.5);
  report.objects.push_back(other);
  EXPECT_LT(edges_of_chair(report), 0.5 * alone);
}

TEST_F(MapperTest, ACorrectedTrajectoryTakesItsObjectsAlong) {
  // Mapped in a world that has drifted; then a loop closes, and the chair is seen from where it
  // was.
  constexpr int kDrifted = 16, kEnd = 24;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  Eigen::Isometry3d drift = Eigen::Isometry3d::Identity();
  drift.translate(Eigen::Vector3d(0.4, -0.25, 0));
  drift.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  const auto confirmed_after = [&](bool correct, bool resume) {
    auto mapper = NewMapper();
    FrameReport report;
    for (int frame = 0; frame < kEnd; ++frame) {
      MapperInput input = Seen(frame, {&chair, 1});
      input.pose_id = PoseId{frame};
      const Eigen::Isometry3d truth = input.world_from_cam;
      if (frame < kDrifted) input.world_from_cam = drift * truth;
      if (frame == kDrifted && correct) {
        for (int past = 0; past < kDrifted; ++past) {
          PoseEstimate pose{PoseId{past}, 0, Seen(past, {&chair, 1}).world_from_cam, {}, 1};
          mapper->Correct(pose);
          mapper->Correct(pose);  // told twice it is the same
        }
      }
      input.pose_epoch = frame < kDrifted ? 0 : 1;
      report = mapper->Step(input);
      if (frame == kDrifted && resume) {
        mapper = NewMapper();
        const auto load = [&](int past) -> Result<MapperInput> {
          MapperInput again = Seen(past, {&chair, 1});
          again.pose_id = PoseId{past};
          if (past < kDrifted) again.world_from_cam = drift * again.world_from_cam;
          return again;
        };
        EXPECT_TRUE(mapper->Restore(report, load).ok());
      }
    }
    std::vector<ObjectReport> confirmed;
    for (const ObjectReport& object : report.objects)
      if (object.state == ObjectState::kConfirmed) confirmed.push_back(object);
    return confirmed;
  };
  const auto error_m = [&](const ObjectReport& object) {
    return (object.world_from_object.translation() - chair.world_from_object.translation()).norm();
  };
  const std::vector<ObjectReport> corrected = confirmed_after(true, false);
  ASSERT_EQ(corrected.size(), 1u);
  EXPECT_LT(error_m(corrected[0]), 0.02);
  const std::vector<ObjectReport> resumed = confirmed_after(true, true);
  ASSERT_EQ(resumed.size(), 1u);
  EXPECT_EQ(resumed[0].world_from_object.matrix(), corrected[0].world_from_object.matrix());
  const std::vector<ObjectReport> left = confirmed_after(false, false);
  EXPECT_TRUE(left.empty() || error_m(left[0]) > 0.1) << "then nothing needs to be corrected";
}

TEST_F(MapperTest, ASettledObjectTellsHowFarThePosesHaveDrifted) {
  constexpr int kDrifted = 20, kEnd = 32;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  Eigen::Isometry3d drift = Eigen::Isometry3d::Identity();
  drift.translate(Eigen::Vector3d(0.07, -0.05, 0.02));
  drift.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  const auto sightings_with = [&](const Eigen::Isometry3d& moved, double drift_std_m) {
    const auto mapper = NewMapper();
    std::vector<LandmarkSighting> sightings;
    for (int frame = 0; frame < kEnd; ++frame) {
      MapperInput input = Seen(frame, {&chair, 1});
      input.pose_id = PoseId{frame};
      if (frame >= kDrifted) {
        input.world_from_cam = moved * input.world_from_cam;
        auto variance = input.pose_uncertainty.drift.diagonal();
        variance.head<3>().setConstant(drift_std_m * drift_std_m);
        variance(5) = 0.2 * drift_std_m * drift_std_m;
      }
      const FrameReport report = mapper->Step(input);
      EXPECT_TRUE(frame >= kDrifted || report.landmarks.empty());
      for (const LandmarkSighting& one : report.landmarks) sightings.push_back(one);
    }
    return sightings;
  };
  const auto check = [&](const LandmarkSighting& seen, const Eigen::Isometry3d& moved) {
    const Eigen::Vector3d expected = moved * seen.center_in_world - seen.center_in_world;
    EXPECT_LT((seen.center_in_world_now - seen.center_in_world - expected).norm(), 0.02);
    const double turn = std::atan2(moved.linear()(1, 0), moved.linear()(0, 0));
    EXPECT_NEAR(seen.azimuth_now_rad - seen.azimuth_rad, turn, 0.025);
    EXPECT_LT(seen.reference_pose.value, kDrifted);
    EXPECT_GE(seen.present_pose.value, kDrifted);
    Eigen::Vector4d error;
    error << seen.center_in_world_now - seen.center_in_world - expected,
        seen.azimuth_now_rad - seen.azimuth_rad - turn;
    EXPECT_LT(error.dot(seen.covariance.ldlt().solve(error)), 18.5);  // 99.9 %
  };
  const std::vector<LandmarkSighting> drifted = sightings_with(drift, 0.05);
  ASSERT_FALSE(drifted.empty());
  for (const LandmarkSighting& seen : drifted) check(seen, drift);
  // Poses that may have drifted and have not.
  const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
  const std::vector<LandmarkSighting> still = sightings_with(none, 0.05);
  ASSERT_FALSE(still.empty());
  for (const LandmarkSighting& seen : still) check(seen, none);
  // Poses that are known.
  EXPECT_TRUE(sightings_with(none, 0.001).empty());
}

}  // namespace
}  // namespace plumbline
