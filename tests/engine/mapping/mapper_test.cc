// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/mapper.h"

#include <cmath>

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
  static const ObjectReport* Best(const FrameReport& report) {
    const ObjectReport* best = nullptr;
    for (const ObjectReport& object : report.objects)
      if (best == nullptr || object.log_evidence > best->log_evidence) best = &object;
    return best;
  }

  MappingScene& scene_ = MappingScene::Get();
};

TEST_F(MapperTest, WhatIsSpawnedLateIsJudgedByTheViewsBefore) {
  constexpr int kBoxedFrom = 14, kEnd = 20;
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const auto log_odds_after = [&](int first_frame) {
    const auto mapper = NewMapper();
    double log_odds = 0;
    for (int frame = first_frame; frame < kEnd; ++frame) {
      MapperInput input = Seen(frame, {&chair, 1});
      if (frame < kBoxedFrom) input.detections = DetectionsFromProposals({});
      const FrameReport report = mapper->Step(input);
      if (const ObjectReport* best = Best(report)) log_odds = best->log_evidence;
    }
    return log_odds;
  };
  EXPECT_GT(log_odds_after(0), log_odds_after(kBoxedFrom) + 1);
}

TEST_F(MapperTest, AnObjectLargerThanItsModelIsFoundAtItsScale) {
  constexpr int kEnd = 30;
  for (const double scale : {0.96, 1.04}) {
    PlacedModel chair = scene_.Place("chair", 0, 0, 30);
    chair.scale = scale;
    const auto found = [&](double scale_std) {
      MapperOptions options;
      options.scale_std = scale_std;
      const auto mapper = NewMapper(options);
      ObjectReport last;
      for (int frame = 0; frame < kEnd; ++frame) {
        const FrameReport report = mapper->Step(Seen(frame, {&chair, 1}));
        if (const ObjectReport* best = Best(report)) last = *best;
      }
      return last;
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
      mapper->AddPoints(curtain);
    }
    EXPECT_GT(before, 0) << "the chair was found";
    return before - after;
  };
  const double without = log_odds_lost(false);
  EXPECT_GT(without, 1);
  EXPECT_LT(log_odds_lost(true), 0.5 * without);
}

}  // namespace
}  // namespace plumbline
