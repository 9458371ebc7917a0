// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/networks_sheet.h"

#include <gtest/gtest.h>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

/// The sheet as something that the harness can draw.
class SheetPanel : public Panel {
 public:
  SheetPanel() { sheet.Open(true); }
  void Draw(const FrameContext& context, CommandSink& sink) override { sheet.Draw(context, sink); }
  NetworksSheet sheet;
};

class NetworksSheetTest : public testing::Test {
 protected:
  NetworksSheetTest() {
    harness_.ShowFrame(0);
    PlaybackView playback = *harness_.context.playback;
    playback.edges = "builtin";
    playback.detector = "/networks/yolox_nano.onnx";
    Play(playback);
    Know({{{"yolox_s", "the larger", ""}, {"yolox_nano", "the smaller", playback.detector}}, {}});
  }
  void Play(const PlaybackView& playback) {
    harness_.context.playback = std::make_shared<const PlaybackView>(playback);
  }
  void Know(const NetworksView& networks) {
    harness_.context.networks = std::make_shared<const NetworksView>(networks);
  }
  const UseNetworksCommand* Clicked(const std::string& widget) {
    harness_.Draw(panel_, 3);  // until it has found its size
    harness_.sink.commands.clear();
    harness_.Click(panel_, widget);
    return harness_.sink.Last<UseNetworksCommand>();
  }

  PanelHarness harness_;
  SheetPanel panel_;
};

TEST_F(NetworksSheetTest, AsksForWhatIsClickedUnlessItIsUsedOrNotThere) {
  const UseNetworksCommand* use = Clicked("networks.edges.gradient");
  ASSERT_NE(use, nullptr);
  EXPECT_EQ(use->edges, "gradient");
  EXPECT_EQ(use->detector, "");
  EXPECT_EQ(Clicked("networks.edges.builtin"), nullptr) << "the run uses it";
  EXPECT_EQ(Clicked("networks.edges.dataset"), nullptr) << "the sequence has none";
  use = Clicked("networks.detector.builtin");
  ASSERT_NE(use, nullptr);
  EXPECT_EQ(use->detector, "builtin");
  EXPECT_EQ(Clicked("networks.detector.yolox_nano"), nullptr) << "the run uses it";
  EXPECT_EQ(Clicked("networks.detector.yolox_s"), nullptr) << "it has not been fetched";
}

TEST_F(NetworksSheetTest, FetchesAndStopsAndSaysWhyNot) {
  harness_.Draw(panel_, 3);
  EXPECT_EQ(harness_.widgets.Find("networks.fetch.yolox_nano"), nullptr) << "it is there";
  harness_.Click(panel_, "networks.fetch.yolox_s");
  const auto* fetch = harness_.sink.Last<FetchNetworkCommand>();
  ASSERT_NE(fetch, nullptr);
  EXPECT_EQ(fetch->name, "yolox_s");
  NetworksView networks = *harness_.context.networks;
  networks.detectors[0].fetching = "downloading 3 %";
  Know(networks);
  harness_.Draw(panel_, 3);
  harness_.Click(panel_, "networks.fetch.yolox_s");
  EXPECT_NE(harness_.sink.Last<StopFetchingCommand>(), nullptr);
  networks.detectors[0].fetching = "";
  networks.detectors[0].problem = "cannot reach it";
  Know(networks);
  harness_.Draw(panel_, 3);
  EXPECT_NE(harness_.widgets.Find("networks.fetch.yolox_s.problem"), nullptr);
}

TEST_F(NetworksSheetTest, OffersAFileOfOnesOwnForWhatItFinds) {
  NetworksView networks = *harness_.context.networks;
  networks.file = {
      .file = "/mine.onnx", .known = true, .edges = true, .what = "edge", .guessed = true};
  Know(networks);
  const UseNetworksCommand* use = Clicked("networks.use");
  ASSERT_NE(use, nullptr);
  EXPECT_EQ(use->edges, "/mine.onnx");
  EXPECT_EQ(use->detector, "");
  networks.file.problem = "'/mine.onnx' is damaged";
  Know(networks);
  harness_.Draw(panel_, 2);
  EXPECT_EQ(harness_.widgets.Find("networks.use"), nullptr);
  EXPECT_NE(harness_.widgets.Find("networks.problem"), nullptr);
}

TEST_F(NetworksSheetTest, ARecordedRunKeepsItsNetworks) {
  PlaybackView recorded = *harness_.context.playback;
  recorded.recorded = true;
  Play(recorded);
  EXPECT_EQ(Clicked("networks.edges.gradient"), nullptr);
  EXPECT_EQ(harness_.widgets.Find("networks.file"), nullptr);
  harness_.Click(panel_, "networks.close");
  EXPECT_FALSE(panel_.sheet.is_open());
}

}  // namespace
}  // namespace plumbline
