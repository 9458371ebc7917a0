// SPDX-License-Identifier: Apache-2.0
// "Confirmed only" in the views made of pixels and in the timeline; map, rows and boxes are in
// panels_test.cc.

#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/playback_view.h"
#include "ui/inspect/image/edge_difference.h"
#include "ui/inspect/image/overlays.h"
#include "ui/inspect/panel_table.h"
#include "ui/inspect/timeline/timeline_lanes.h"

#include <gmock/gmock.h>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

/// Frame 20, in which nothing but object 2 is confirmed.
void ShowOneConfirmed(PanelHarness& harness) {
  harness.ShowFrame(20);
  MapSnapshot snapshot = *harness.context.snapshot;
  for (ObjectReport& object : snapshot.report.objects)
    object.state = object.id == ObjectId{2} ? ObjectState::kConfirmed : ObjectState::kTentative;
  harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
}

cv::Point PixelOf(const cv::Mat& id, int object) {
  for (int i = 0; i < static_cast<int>(id.total()); ++i) {
    if (id.ptr<std::uint16_t>()[i] == object) return {i % id.cols, i / id.cols};
  }
  return {-1, -1};
}

int OtherVisibleObject(const cv::Mat& id) {
  for (int object = 1; object < 20; ++object) {
    if (object != 2 && PixelOf(id, object).x >= 0) return object;
  }
  return 0;
}

TEST(ConfirmedOnly, TakesThePixelsOfTheOthersOutOfMasksAndDepth) {
  PanelHarness harness;
  ShowOneConfirmed(harness);
  const MapSnapshot& snapshot = *harness.context.snapshot;
  const int other = OtherVisibleObject(snapshot.id);
  ASSERT_GT(other, 0);
  EXPECT_TRUE(LeftOut(harness.context).empty());
  EXPECT_EQ(WithoutObjects(snapshot.depth, snapshot.id, {}).data, snapshot.depth.data) << "no copy";

  harness.context.confirmed_only = true;
  const std::vector<ObjectId> left_out = LeftOut(harness.context);
  EXPECT_THAT(left_out, testing::Contains(ObjectId{other}));
  EXPECT_THAT(left_out, testing::Not(testing::Contains(ObjectId{2})));
  const cv::Mat shown = WithoutObjects(snapshot.depth, snapshot.id, left_out);
  EXPECT_EQ(shown.at<float>(PixelOf(snapshot.id, other)), 0);
  EXPECT_GT(shown.at<float>(PixelOf(snapshot.id, 2)), 0);
  harness.context.selection.object = {other};
  EXPECT_THAT(LeftOut(harness.context), testing::Not(testing::Contains(ObjectId{other})));
}

TEST(ConfirmedOnly, MakesThePicturesAgainOnlyWhenItIsSwitched) {
  for (const char* id : {"masks", "depth"}) {
    SCOPED_TRACE(id);
    PanelHarness harness;
    const auto panel = MakeInspectPanel(id);
    ShowOneConfirmed(harness);
    harness.Draw(*panel, 3);
    EXPECT_EQ(harness.textures.pictures_made, 1);
    harness.context.confirmed_only = true;
    harness.Draw(*panel, 3);
    EXPECT_EQ(harness.textures.pictures_made, 2);
    harness.context.selection.object = {OtherVisibleObject(harness.context.snapshot->id)};
    harness.Draw(*panel, 3);
    EXPECT_EQ(harness.textures.pictures_made, 3);
  }
}

TEST(ConfirmedOnly, LeavesNothingToClickWhereAnObjectIsLeftOut) {
  for (const char* id : {"image", "masks", "depth"}) {
    SCOPED_TRACE(id);
    PanelHarness harness;
    const auto panel = MakeInspectPanel(id);
    ShowOneConfirmed(harness);
    const cv::Mat& map = harness.context.snapshot->id;
    const int other = OtherVisibleObject(map);
    const cv::Point pixel = PixelOf(map, other);
    const float x = (static_cast<float>(pixel.x) + 0.5f) / static_cast<float>(map.cols),
                y = (static_cast<float>(pixel.y) + 0.5f) / static_cast<float>(map.rows);
    const std::string view = std::string(id) + ".view";
    harness.Click(*panel, view, x, y);
    ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
    EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{other});
    harness.context.confirmed_only = true;
    harness.Click(*panel, view, x, y);
    EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{});
  }
}

TEST(ConfirmedOnly, ExpectsNoEdgesOfWhatIsLeftOut) {
  MapSnapshot snapshot;
  snapshot.edge_probability = cv::Mat::zeros(60, 80, CV_8U);
  snapshot.outlines.push_back({{3}, {{{20, 20}, {50, 20}, {50, 40}, {20, 40}}}});
  const cv::Vec3b red = EdgeDifferencePicture(snapshot, {}).at<cv::Vec3b>(20, 35);
  snapshot.edge_probability.at<std::uint8_t>(50, 70) = 255;
  EXPECT_NE(EdgeDifferencePicture(snapshot, {}).at<cv::Vec3b>(20, 35),
            EdgeDifferencePicture(snapshot, {{3}}).at<cv::Vec3b>(20, 35));
  EXPECT_EQ(EdgeDifferencePicture(snapshot, {{3}}).at<cv::Vec3b>(20, 35), red)
      << "without edges nothing is called missing, either";
}

TEST(ConfirmedOnly, LeavesTheLaneOfThoseNeverConfirmedOut) {
  const std::vector<FrameEvent> events = {{1, {EventKind::kSpawned, {1}, {}, ""}},
                                          {5, {EventKind::kConfirmed, {1}, {}, ""}},
                                          {6, {EventKind::kSpawned, {2}, {}, ""}},
                                          {7, {EventKind::kSpawned, {3}, {}, ""}}};
  const auto ids = [](const std::vector<ObjectLane>& lanes) {
    std::vector<int> values;
    for (const ObjectLane& lane : lanes) values.push_back(lane.id.value);
    return values;
  };
  const int none = ObjectId{}.value;
  EXPECT_THAT(ids(LanesOf(events, {})), testing::ElementsAre(1, none));
  EXPECT_THAT(ids(LanesOf(events, {}, true)), testing::ElementsAre(1));
  EXPECT_THAT(ids(LanesOf(events, {3}, true)), testing::ElementsAre(1, 3)) << "the selected one";
}

TEST(ConfirmedOnly, ReachesTheTimeline) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {1200, 260};
  harness.ShowFrame(20);
  PlaybackView playback = *harness.context.playback;
  const std::vector<FrameEvent> events = {{1, {EventKind::kSpawned, {1}, {}, ""}},
                                          {2, {EventKind::kSpawned, {2}, {}, ""}},
                                          {5, {EventKind::kConfirmed, {2}, {}, ""}}};
  playback.events = std::make_shared<const std::vector<FrameEvent>>(events);
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  harness.Draw(*panel, 3);
  const int before = harness.vertices;
  harness.context.confirmed_only = true;
  harness.Draw(*panel, 3);
  EXPECT_LT(harness.vertices, before);
  EXPECT_NE(harness.widgets.Find("timeline.lane.2"), nullptr);
}

}  // namespace
}  // namespace plumbline
