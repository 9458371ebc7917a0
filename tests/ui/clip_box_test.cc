// SPDX-License-Identifier: Apache-2.0
// The box that cuts the map.

#include "ui/inspect/map/clip_box.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/inspect/panel_table.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

/// The map, wide enough for all its switches, seen from in front and above.
class ClippedMap : public testing::Test {
 protected:
  ClippedMap() {
    ImGui::GetIO().DisplaySize = {1500, 800};
    harness.size = {1400, 700};
    harness.ShowFrame(20);
    harness.scene.view.distance_m = 12;
    harness.scene.view.focus_in_world = {0, 0, 1};
    harness.scene.view.view_from_world << 1, 0, 0,  //
        0, 0.5, std::sqrt(0.75),                    //
        0, -std::sqrt(0.75), 0.5;
    harness.Click(*panel, "scene.clip");
  }
  const Eigen::AlignedBox3d& Box() { return harness.scene.content.clip->in_upright; }

  PanelHarness harness;
  std::unique_ptr<Panel> panel = MakeInspectPanel("scene");
};

TEST_F(ClippedMap, BeginsAroundEverything) {
  ASSERT_TRUE(harness.scene.content.clip);
  for (const double x : {-2.0, 2.0}) EXPECT_TRUE(harness.scene.content.clip->Holds({x, x, 2}));
  EXPECT_FALSE(harness.scene.content.clip->Holds({2.2, 0, 1}));
  harness.Click(*panel, "scene.clip");
  EXPECT_FALSE(harness.scene.content.clip) << "switched off";
}

TEST_F(ClippedMap, MovesTheSideThatIsDraggedAndNeitherTurnsNorSelects) {
  ASSERT_TRUE(harness.scene.content.clip);
  const Eigen::AlignedBox3d before = Box();
  harness.sink.commands.clear();
  harness.Drag(*panel, "scene.clip.x1", {0.5f, 0.5f}, {-5, 0.5f}, 0);
  const Eigen::AlignedBox3d after = Box();
  EXPECT_LT(after.max().x(), before.max().x() - 0.3);
  EXPECT_EQ(after.min(), before.min());
  EXPECT_EQ(after.max().tail<2>(), before.max().tail<2>());
  EXPECT_EQ(harness.scene.orbit_x, 0);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>(), nullptr);
  harness.Drag(*panel, "scene.clip.x0", {0.5f, 0.5f}, {200, 0.5f}, 0);
  EXPECT_GT(Box().max().x() - Box().min().x(), 0.05) << "sides do not pass one another";
  harness.Click(*panel, "scene.clip.whole");
  EXPECT_EQ(Box().max(), before.max());
}

TEST_F(ClippedMap, KeepsItsBoxForTheSequence) {
  harness.Drag(*panel, "scene.clip.top", {0.5f, 0.5f}, {0.5f, 4}, 0);
  const Vector3d cut = Box().max();
  harness.Click(*panel, "scene.clip");
  harness.Click(*panel, "scene.clip");
  EXPECT_EQ(Box().max(), cut) << "switched off and on";
  ++harness.context.source_version;
  harness.Draw(*panel, 2);
  EXPECT_FALSE(harness.scene.content.clip) << "another sequence";
}

TEST_F(ClippedMap, IsNotInTheWayOfTheCamerasOwnView) {
  harness.context.look_through = true;
  harness.Draw(*panel, 2);
  EXPECT_FALSE(harness.scene.content.clip);
}

TEST(ClipBox, GoesAroundAnObjectWithItsSurroundings) {
  PanelHarness harness;
  harness.ShowFrame(20);
  SequenceView sequence = *harness.context.sequence;
  sequence.models.at(0).bounds = {Eigen::Vector3f(-0.5f, -0.5f, 0), Eigen::Vector3f(0.5f, 0.5f, 1)};
  harness.context.sequence = std::make_shared<const SequenceView>(sequence);
  ObjectReport object = harness.context.snapshot->report.objects.at(0);
  object.label = {0};
  object.scale = 1;
  object.world_from_object.setIdentity();
  object.world_from_object.translation() = Vector3d(1, 2, 0);
  const auto box = ClipAroundObject(harness.context, object);
  ASSERT_TRUE(box);
  EXPECT_TRUE(box->Holds({1.9, 2.9, 1.4}));
  EXPECT_FALSE(box->Holds({2.1, 2, 0.5}));
  object.label = {99};
  EXPECT_FALSE(ClipAroundObject(harness.context, object)) << "no shape, no size";
}

TEST_F(ClippedMap, ComesBackWithWhatItIsTheBoxOf) {
  harness.context.source = "kitchen.plb";
  ++harness.context.source_version;
  harness.Draw(*panel);
  harness.Click(*panel, "scene.clip");
  harness.Drag(*panel, "scene.clip.x1", {0.5f, 0.5f}, {-5, 0.5f}, 0);
  ASSERT_TRUE(harness.scene.content.clip);
  const ClipBox box = *harness.scene.content.clip;
  const nlohmann::json kept = nlohmann::json::parse(panel->SaveState().dump());
  const auto next = MakeInspectPanel("scene");
  next->LoadState(kept);
  harness.Draw(*next, 2);
  ASSERT_TRUE(harness.scene.content.clip);
  EXPECT_LT((harness.scene.content.clip->in_upright.max() - box.in_upright.max()).norm(), 1e-9);
  EXPECT_LT((harness.scene.content.clip->in_upright.min() - box.in_upright.min()).norm(), 1e-9);
  harness.context.source = "office.plb";
  ++harness.context.source_version;
  harness.Draw(*next, 2);
  EXPECT_FALSE(harness.scene.content.clip) << "that is another room";
  for (const char* broken : {R"({"of": "office.plb", "on": true})",
                             R"({"of": "office.plb", "on": true, "low": [0, 0, 0], "high": "x",
                                 "world_from_upright": 5})"}) {
    next->LoadState({{"clip", nlohmann::json::parse(broken)}});
    harness.Draw(*next, 2);
    EXPECT_FALSE(harness.scene.content.clip) << broken;
  }
}

}  // namespace
}  // namespace plumbline
