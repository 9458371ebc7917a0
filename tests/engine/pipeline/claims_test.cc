// SPDX-License-Identifier: Apache-2.0
// The situations in which the paper claims strength, each with its claim.

#include <gmock/gmock.h>

#include "tests/support/room_run.h"

namespace plumbline {
namespace {

RoomRun Map(SyntheticScene scene, int frames = 180, const std::string& edges = "gradient") {
  SyntheticOptions options = QuicklyLit(scene, 5);
  options.frames = frames;
  return MapRoom(options, edges);
}

double ErrorOf(const ObjectReport& object, const RunInstance& instance) {
  return (object.world_from_object.translation() - instance.truth.world_from_object.translation())
      .norm();
}

/// First frame in which the instance is confirmed; -1 never.
int ConfirmedFrame(const RoomRun& run, const RunInstance& instance) {
  for (const FrameReport& report : run.reports) {
    if (run.Find(report, instance) != nullptr) return report.frame;
  }
  return -1;
}

bool Proposed(const FrameReport& report, const ObjectReport& object) {
  return std::any_of(report.proposals.begin(), report.proposals.end(), [&](const auto& proposal) {
    return proposal.category == object.category && Iou(proposal.box, object.visible_box) > 0.3f;
  });
}

/// Nearly all furniture is found with its right shape, and nothing else.
void ExpectFurnished(const RoomRun& run, double mean_m, double mean_deg) {
  const RoomFigures figures = Judge(run);
  SCOPED_TRACE(figures.text);
  ASSERT_GT(figures.found, 0);
  EXPECT_GE(figures.right, figures.instances - 1);
  EXPECT_LT(figures.sum_m / figures.found, mean_m);
  EXPECT_LT(figures.sum_deg / figures.found, mean_deg);
  EXPECT_LE(figures.spurious, 1);
}

TEST(Claims, AHiddenObjectStaysWhereItIsThroughSixtyFramesWithoutADetection) {
  const RoomRun run = Map(SyntheticScene::kOcclusion, 300, "dataset");
  const RunInstance& chair = run.Instance(run.main_instance);
  const int confirmed = ConfirmedFrame(run, chair);
  ASSERT_GE(confirmed, 0);
  int longest = 0;
  for (const FrameRun& hidden : chair.hidden) {
    if (hidden.first < confirmed) continue;
    int undetected = 0;
    for (int frame = hidden.first; frame <= hidden.last; ++frame) {
      const FrameReport& report = run.reports.at(static_cast<std::size_t>(frame));
      const ObjectReport* object = run.Find(report, chair);
      ASSERT_NE(object, nullptr) << "frame " << frame;
      EXPECT_LT(ErrorOf(*object, chair), 0.05) << "frame " << frame;
      undetected = Proposed(report, *object) ? 0 : undetected + 1;
      longest = std::max(longest, undetected);
    }
  }
  EXPECT_GE(longest, 60);
  const ObjectReport* last = run.Find(run.reports.back(), chair);
  ASSERT_NE(last, nullptr);
  EXPECT_LT(ErrorOf(*last, chair), 0.05);
}

TEST(Claims, ClutterIsNotTakenForFurniture) {
  ExpectFurnished(Map(SyntheticScene::kClutter, 180, "dataset"), 0.03, 3);
}

TEST(Claims, WhatIsConfirmedOutlastsBlur) {
  const RoomRun run = Map(SyntheticScene::kBlur, 300);
  ASSERT_FALSE(run.shaken.empty());
  int kept = 0;
  for (const FrameRun& shaken : run.shaken) {
    if (shaken.last + 1 >= static_cast<int>(run.reports.size())) continue;
    for (const RunInstance& instance : run.instances) {
      const ObjectReport* before =
          run.Find(run.reports[static_cast<std::size_t>(shaken.first)], instance);
      if (before == nullptr || ErrorOf(*before, instance) > 0.05) continue;
      const ObjectReport* after =
          run.Find(run.reports[static_cast<std::size_t>(shaken.last)], instance);
      ASSERT_NE(after, nullptr) << instance.truth.id << " is lost by frame " << shaken.last;
      EXPECT_LT(ErrorOf(*after, instance), 0.06) << instance.truth.id;
      ++kept;
    }
  }
  EXPECT_GE(kept, 5);
  EXPECT_LE(Judge(run).spurious, 1);
}

TEST(Claims, FurnitureInTheColoursOfTheRoomIsFound) {
  ExpectFurnished(Map(SyntheticScene::kLowContrast), 0.05, 5);
}

TEST(Claims, FurnitureCutByTheImageBorderIsPlaced) {
  const RoomRun run = Map(SyntheticScene::kTruncation);
  const RoomFigures figures = Judge(run);
  SCOPED_TRACE(figures.text);
  ASSERT_GT(figures.found, 0);
  EXPECT_LT(figures.sum_m / figures.found, 0.05);
  int cut = 0, placed = 0;
  for (const RunInstance& instance : run.instances) {
    int frames = 0;
    for (const FrameRun& truncated : instance.truncated)
      frames += truncated.last - truncated.first + 1;
    if (frames < 90 || instance.shown_frames < 90) continue;
    ++cut;
    const ObjectReport* object = run.Find(run.reports.back(), instance);
    placed += object != nullptr && ErrorOf(*object, instance) < 0.05 ? 1 : 0;
  }
  EXPECT_GE(cut, 1);
  EXPECT_GE(placed, cut - 1);
}

TEST(Claims, SplitAndDoubleBoxesMakeNoSecondObject) {
  const RoomRun run = Map(SyntheticScene::kDuplicate);
  for (const FrameReport& report : run.reports) {
    for (const RunInstance& instance : run.instances) {
      int there = 0;
      for (const ObjectReport& object : report.objects) {
        there += object.state == ObjectState::kConfirmed &&
                         object.category == instance.truth.category &&
                         ErrorOf(object, instance) < 0.25
                     ? 1
                     : 0;
      }
      EXPECT_LE(there, 1) << instance.truth.id << " in frame " << report.frame;
    }
  }
  ExpectFurnished(run, 0.03, 3);
}

TEST(Claims, AnObjectThatDiffersModestlyFromItsModelIsPlaced) {
  const RoomRun run = Map(SyntheticScene::kVariant);
  const RunInstance& chair = run.Instance(run.main_instance);
  const ObjectReport* object = run.Find(run.reports.back(), chair);
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(run.database->model(object->label).name, chair.truth.model);
  EXPECT_LT(ErrorOf(*object, chair), 0.05);
}

}  // namespace
}  // namespace plumbline
