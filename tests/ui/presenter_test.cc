// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/presenter.h"

#include <gtest/gtest.h>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

/// The demo mode as the only panel of a window.
class Presented : public Panel {
 public:
  explicit Presented(FrameContext& context) : context_(context) {
    PanelInfo info;
    info.id = "presented";
    set_info(info);
  }
  void Draw(const FrameContext&, CommandSink& sink) override {
    presenter.Draw(context_, {600, 400}, {}, sink);
  }
  void Start(CommandSink& sink) { presenter.Start(context_, {}, sink); }
  Presenter presenter;

 private:
  FrameContext& context_;
};

class DemoMode : public testing::Test {
 protected:
  void SetUp() override { harness_.ShowFrame(0); }

  /// The frame that shows has no image, no edges and no objects.
  void ShowNothing() {
    MapSnapshot empty = *harness_.context.snapshot;
    empty.image = empty.edge_probability = cv::Mat();
    empty.report.objects.clear();
    harness_.context.snapshot = std::make_shared<const MapSnapshot>(std::move(empty));
  }
  /// What is known of the run: so many confirmed objects in this frame, none in others.
  void KnowObjects(int frame, int count) {
    auto sample = std::make_shared<FrameSample>();
    sample->frame = frame;
    for (int i = 0; i < count; ++i) {
      ObjectSample object;
      object.id = {i + 1};
      object.state = ObjectState::kConfirmed;
      sample->objects.push_back(object);
    }
    auto history = std::make_shared<RunHistory>();
    history->frames = {std::make_shared<const FrameSample>(), sample};
    PlaybackView playback = *harness_.context.playback;
    playback.history = history;
    harness_.context.playback = std::make_shared<const PlaybackView>(playback);
  }

  PanelHarness harness_;
  Presented shown_{harness_.context};
};

TEST_F(DemoMode, PassesOverViewsThatWouldBeEmptyAndSeeksAFrameForTheNext) {
  ShowNothing();
  KnowObjects(7, 1);
  shown_.Start(harness_.sink);
  EXPECT_EQ(shown_.presenter.shot(), 4u) << "the first that needs no image now, but an object";
  harness_.Draw(shown_);
  ASSERT_NE(harness_.sink.Last<SeekCommand>(), nullptr);
  EXPECT_EQ(harness_.sink.Last<SeekCommand>()->frame, 7);
  // Not again with every frame of the window: the mapper needs time to get there.
  const std::size_t sent = harness_.sink.commands.size();
  harness_.Draw(shown_, 3);
  EXPECT_EQ(harness_.sink.commands.size(), sent);
}

TEST_F(DemoMode, StaysWhereThereIsSomethingToSee) {
  KnowObjects(7, 1);
  shown_.Start(harness_.sink);
  harness_.Draw(shown_, 3);
  EXPECT_EQ(shown_.presenter.shot(), 0u);
  EXPECT_EQ(harness_.sink.Last<SeekCommand>(), nullptr);
}

TEST_F(DemoMode, LeavesAViewThatBecomesEmptyForOneThatIsNot) {
  KnowObjects(7, 0);
  shown_.Start(harness_.sink);
  ASSERT_EQ(shown_.presenter.shot(), 0u);
  // The image is gone; objects stay.
  MapSnapshot blind = *harness_.context.snapshot;
  blind.image = blind.edge_probability = cv::Mat();
  ASSERT_FALSE(blind.report.objects.empty());
  for (ObjectReport& object : blind.report.objects) object.state = ObjectState::kConfirmed;
  harness_.context.snapshot = std::make_shared<const MapSnapshot>(std::move(blind));
  harness_.Draw(shown_, 2);
  EXPECT_EQ(shown_.presenter.shot(), 4u);
  EXPECT_EQ(harness_.sink.Last<SeekCommand>(), nullptr);
}

TEST_F(DemoMode, ARunWithNothingToShowAtAllIsEnduredInPeace) {
  ShowNothing();
  KnowObjects(7, 0);
  shown_.Start(harness_.sink);
  harness_.Draw(shown_, 3);
  EXPECT_EQ(harness_.sink.Last<SeekCommand>(), nullptr);
}

}  // namespace
}  // namespace plumbline
