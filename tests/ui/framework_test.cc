// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <imgui_internal.h>

#include "tests/ui/panel_harness.h"
#include "ui/framework/actions.h"
#include "ui/framework/layout.h"
#include "ui/framework/pictures.h"
#include "ui/framework/theme.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {
namespace {

TEST(Pictures, ShowNearThingsBrighterAndNothingDark) {
  cv::Mat depth(1, 3, CV_32F);
  depth.at<float>(0) = 0;
  depth.at<float>(1) = 1.1f;
  depth.at<float>(2) = 3.8f;
  const DepthRange range = RangeOf(depth);
  EXPECT_DOUBLE_EQ(range.near_m, 1.0);
  EXPECT_DOUBLE_EQ(range.far_m, 4.0);
  const cv::Mat picture = DepthPicture(depth, range);
  const auto sum = [&](int i) {
    const auto c = picture.at<cv::Vec3b>(i);
    return c[0] + c[1] + c[2];
  };
  EXPECT_LT(sum(0), 60);
  EXPECT_GT(sum(1), sum(2));
}

TEST(Pictures, LeaveAnEmptyZBufferEmpty) {
  EXPECT_TRUE(RangeOf(cv::Mat()).empty());
  EXPECT_TRUE(RangeOf(cv::Mat(2, 2, CV_32F, cv::Scalar(0))).empty());
  EXPECT_EQ(DepthPicture(cv::Mat(2, 2, CV_32F, cv::Scalar(0)), {}).size(), cv::Size(2, 2));
}

TEST(Pictures, ShadeMasksDarkerTheCloser) {
  const cv::Mat image(1, 2, CV_8UC3, cv::Scalar(100, 100, 100));
  cv::Mat depth(1, 2, CV_32F), id(1, 2, CV_16U, cv::Scalar(1));
  depth.at<float>(0) = 1;
  depth.at<float>(1) = 3;
  const cv::Mat picture = MaskPicture(image, depth, id, {1, 3}, {});
  EXPECT_LT(cv::norm(picture.at<cv::Vec3b>(0)), cv::norm(picture.at<cv::Vec3b>(1)));
}

TEST(Pictures, TakeMapsOfHalfSize) {
  const cv::Mat image(4, 6, CV_8UC3, cv::Scalar(100, 100, 100));
  cv::Mat depth(2, 3, CV_32F, cv::Scalar(0)), id(2, 3, CV_16U, cv::Scalar(0));
  depth.at<float>(1, 2) = 2;
  id.at<std::uint16_t>(1, 2) = 1;
  const cv::Mat picture = MaskPicture(image, depth, id, {1, 3}, {});
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(45, 45, 45));
  EXPECT_NE(picture.at<cv::Vec3b>(3, 5), cv::Vec3b(45, 45, 45));
}

TEST(Pictures, ColourEdgesByDirection) {
  cv::Mat probability(1, 3, CV_8U, cv::Scalar(255)), angle(1, 3, CV_8U, cv::Scalar(0));
  probability.at<std::uint8_t>(0) = 0;
  angle.at<std::uint8_t>(2) = 128;
  const cv::Mat picture = EdgePicture(probability, angle);
  EXPECT_EQ(picture.at<cv::Vec3b>(0), cv::Vec3b(0, 0, 0));
  EXPECT_NE(picture.at<cv::Vec3b>(1), picture.at<cv::Vec3b>(2));
}

TEST(Theme, GivesAnObjectOneColourInBothThemes) {
  PanelHarness harness;
  harness.context.looks =
      std::make_shared<const ObjectLooks>(ObjectLooks{{{1}, {0, false}}, {{2}, {3, false}}});
  const ImU32 dark = harness.context.ColorOf({1});
  EXPECT_NE(dark, harness.context.ColorOf({2}));
  EXPECT_EQ(harness.context.ColorOf({7}), ColorOfLook({})) << "never confirmed: neutral";
  ApplyTheme(1.0, true);
  EXPECT_EQ(harness.context.ColorOf({1}), dark);
  ApplyTheme(1.0, false);
}

TEST(Theme, DrawsALikelyGhostMore) {
  EXPECT_LT(GhostShare(-3), GhostShare(0));
  EXPECT_LT(GhostShare(0), GhostShare(3));
  EXPECT_GT(GhostShare(-30), 0.05) << "still there";
  EXPECT_LE(GhostShare(30), 0.5) << "never as solid as a confirmed one";
}

/// Three labels that want the same place, and a crowd.
class CountingLabels : public Panel {
 public:
  CountingLabels() {
    PanelInfo info;
    info.id = "counting_labels";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink&) override {
    using Need = PictureLabels::Need;
    const ImVec2 low = ImGui::GetCursorScreenPos(), high(low.x + 300, low.y + 100);
    PictureLabels labels(context, low, high);
    const ImVec2 middle(low.x + 100, low.y + 50), beside(low.x + 200, low.y + 50);
    drawn = labels.Add({middle}, IM_COL32_WHITE, "first");
    drawn += labels.Add({middle}, IM_COL32_WHITE, "second", Need::kIfFree);
    drawn += labels.Add({middle, beside}, IM_COL32_WHITE, "third", Need::kIfFree);
    PictureLabels crowd(context, low, high);
    in_a_crowd = 0;
    for (int i = 0; i < 40; ++i) {
      const ImVec2 at(low.x + static_cast<float>(i % 5) * 60,
                      low.y + 20 + static_cast<float>(i / 5) * 12);
      in_a_crowd += crowd.Add({at}, IM_COL32_WHITE, "crowd", Need::kIfFree);
    }
  }
  int drawn = 0, in_a_crowd = 0;
};

/// A button whose label says how often it was drawn.
class CountingButton : public Panel {
 public:
  CountingButton() {
    PanelInfo info;
    info.id = "counting_button";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink&) override {
    const std::string label = "Frame " + std::to_string(++drawn_);
    clicks += Button(context, "counting", label.c_str(), "");
  }
  int clicks = 0;

 private:
  int drawn_ = 0;
};

TEST(Button, IsPressedThoughItsLabelChangesUnderTheMouse) {
  PanelHarness harness;
  CountingButton panel;
  harness.Click(panel, "counting");
  EXPECT_EQ(panel.clicks, 1);
}

/// A button, maybe with a dialog below it.
class ExplainedButton : public Panel {
 public:
  ExplainedButton() {
    PanelInfo info;
    info.id = "explained";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink&) override {
    ImGui::SetCursorScreenPos(at);
    Button(context, "explained.button", "Export", "Writes it now. The project does not change.");
    if (!dialog) return;
    ImGui::SetNextWindowPos({at.x - 50, at.y + 40});
    ImGui::SetNextWindowSize({400, 200});
    ImGui::Begin("a dialog", nullptr, ImGuiWindowFlags_NoDecoration);
    ImGui::End();
  }
  ImVec2 at{100, 100};
  bool dialog = false;
};

ImRect TooltipRect() {
  const ImGuiWindow* tooltip = ImGui::FindWindowByName("##Tooltip_00");
  return tooltip != nullptr && tooltip->WasActive ? tooltip->Rect() : ImRect();
}

TEST(Tooltip, KeepsOffWhatItExplainsAndOffDialogs) {
  for (const ImVec2 at : {ImVec2(100, 100), ImVec2(100, 740), ImVec2(900, 400), ImVec2(900, 740)}) {
    SCOPED_TRACE(std::to_string(at.x) + " " + std::to_string(at.y));
    PanelHarness harness;
    harness.size = {960, 760};
    ExplainedButton panel;
    panel.at = at;
    harness.Point(panel, "explained.button");
    harness.Draw(panel, 3);
    const WidgetLog::Rect* button = harness.widgets.Find("explained.button");
    const ImRect tooltip = TooltipRect();
    EXPECT_GT(tooltip.GetArea(), 100);
    EXPECT_FALSE(tooltip.Overlaps({button->low, button->high}));
    EXPECT_TRUE(ImRect({0, 0}, ImGui::GetIO().DisplaySize).Contains(tooltip));
  }
  PanelHarness harness;
  harness.size = {960, 760};
  ExplainedButton panel;
  panel.at = {300, 300};
  panel.dialog = true;
  harness.Point(panel, "explained.button");
  harness.Draw(panel, 3);
  const ImRect tooltip = TooltipRect(), dialog = ImGui::FindWindowByName("a dialog")->Rect();
  EXPECT_GT(tooltip.GetArea(), 100);
  EXPECT_FALSE(tooltip.Overlaps(dialog));
}

/// A picture with a part that is explained while the mouse is in it.
class ExplainedPicture : public Panel {
 public:
  ExplainedPicture() {
    PanelInfo info;
    info.id = "picture";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink&) override {
    ImGui::InvisibleButton("picture.view", ImGui::GetContentRegionAvail());
    context.widgets->Add("picture.part", part.Min, part.Max);
    if (!ImGui::IsItemHovered()) return;
    PutTooltipBeside(context, part.Min, part.Max);
    ImGui::SetTooltip("%s", "chair, score 0.83\nit explains a part of this picture");
  }
  ImRect part;
};

TEST(Tooltip, KeepsOffThePartOfAPictureThatItExplains) {
  for (const ImVec2 at : {ImVec2(60, 60), ImVec2(700, 60), ImVec2(60, 500), ImVec2(700, 500)}) {
    SCOPED_TRACE(std::to_string(at.x) + " " + std::to_string(at.y));
    PanelHarness harness;
    harness.size = {960, 700};
    ExplainedPicture panel;
    panel.part = {at, {at.x + 200, at.y + 160}};
    harness.Point(panel, "picture.part");
    harness.Draw(panel, 4);
    const ImRect tooltip = TooltipRect();
    EXPECT_GT(tooltip.GetArea(), 100);
    EXPECT_FALSE(tooltip.Overlaps(panel.part));
    EXPECT_TRUE(ImRect({0, 0}, ImGui::GetIO().DisplaySize).Contains(tooltip));
  }
}

TEST(Theme, ColoursOfTheDataCanBeReadOnPanelsOfBothThemes) {
  PanelHarness harness;
  for (const bool light : {false, true}) {
    ApplyTheme(1.0, light);
    for (int color = -1; color < static_cast<int>(kLookColors.size()); ++color) {
      const ImU32 ink = ColorOfLook({color, false}), shown = OnPanel(ink);
      EXPECT_GE(ContrastOf(shown, colors::kPanel), light ? 3.0 : 2.5) << color;
      EXPECT_GE(ContrastOf(shown, colors::kInset), light ? 3.0 : 2.5) << color;
      const ImVec4 a = ImGui::ColorConvertU32ToFloat4(ink),
                   b = ImGui::ColorConvertU32ToFloat4(shown);
      float hue_a = 0, hue_b = 0, saturation = 0, value = 0;
      ImGui::ColorConvertRGBtoHSV(a.x, a.y, a.z, hue_a, saturation, value);
      ImGui::ColorConvertRGBtoHSV(b.x, b.y, b.z, hue_b, saturation, value);
      const float apart = std::abs(hue_a - hue_b);
      if (color >= 0) {
        EXPECT_LT(std::min(apart, 1 - apart), 0.04f) << color;
      }
      if (!light) {
        EXPECT_EQ(shown, ink) << "dark panels show them as they are";
      }
    }
    EXPECT_GE(ContrastOf(OnPanel(colors::kTruth), colors::kPanel), 3.0);
  }
  ApplyTheme(1.0, false);
}

TEST(Layout, FillsTheWindowWithoutOverlap) {
  for (const ImVec2 size : {ImVec2(1024, 700), ImVec2(1600, 1000), ImVec2(3840, 2160)}) {
    const InspectLayout layout = ComputeInspectLayout(size, size.x > 3000 ? 1.75 : 1.0, {});
    const LayoutRect* rects[] = {&layout.top_bar, &layout.timeline,  &layout.status_bar,
                                 &layout.image,   &layout.edges,     &layout.depth,
                                 &layout.masks,   &layout.particles, &layout.scene,
                                 &layout.objects, &layout.details,   &layout.timings};
    double area = 0;
    for (const LayoutRect* a : rects) {
      EXPECT_GT(a->width(), 100);
      EXPECT_GT(a->height(), 20);
      area += a->width() * a->height();
      for (const LayoutRect* b : rects) {
        if (a == b) continue;
        const bool apart = a->high.x <= b->low.x || b->high.x <= a->low.x ||
                           a->high.y <= b->low.y || b->high.y <= a->low.y;
        EXPECT_TRUE(apart);
      }
    }
    EXPECT_GT(area, 0.93 * size.x * size.y);
  }
}

TEST(Layout, GivesTheRoomOfWhatIsHiddenToTheOthers) {
  const ImVec2 size(1600, 1000);
  InspectRegions regions;
  regions.timings = regions.about_object = false;
  InspectLayout layout = ComputeInspectLayout(size, 1.0, {}, regions);
  EXPECT_EQ(layout.timings.width() * layout.timings.height(), 0);
  EXPECT_EQ(layout.objects.high.y, layout.below.high.y);
  regions.images = false;
  layout = ComputeInspectLayout(size, 1.0, {}, regions);
  EXPECT_EQ(layout.scene.low.x, layout.main.low.x);
  regions = {};
  regions.map = regions.about_map = regions.about_object = regions.timings = false;
  layout = ComputeInspectLayout(size, 1.0, {}, regions);
  EXPECT_EQ(layout.left.high.x, layout.main.high.x);
  regions = {};
  regions.timeline = false;
  EXPECT_EQ(ComputeInspectLayout(size, 1.0, {}, regions).main.high.y, layout.status_bar.low.y);
}

TEST(Layout, IsCompactInANarrowWindowAndWithLargeText) {
  EXPECT_TRUE(IsCompact({1024, 640}, 1.0));
  EXPECT_FALSE(IsCompact({1200, 800}, 1.0));
  EXPECT_TRUE(IsCompact({1600, 1000}, 2.0));
}

TEST(PictureLabels, LeaveOutWhatWouldCoverOthers) {
  PanelHarness harness;
  CountingLabels panel;
  harness.Draw(panel);
  EXPECT_EQ(panel.drawn, 2) << "one that must be, and one beside it";
  EXPECT_LT(panel.in_a_crowd, 12) << "a sixth of the picture at most";
  EXPECT_GT(panel.in_a_crowd, 2);
}

TEST(Title, ADoubleClickMaximizesThePanel) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("masks");
  harness.ShowFrame(20);
  harness.Click(*panel, "masks.title");
  EXPECT_EQ(harness.sink.Last<MaximizePanelCommand>(), nullptr);
  ImGui::GetIO().MouseDown[0] = true;  // again, at once
  harness.Draw(*panel);
  ImGui::GetIO().MouseDown[0] = false;
  harness.Draw(*panel);
  ASSERT_NE(harness.sink.Last<MaximizePanelCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<MaximizePanelCommand>()->panel, "masks");
  harness.context.maximized = "masks";
  harness.Click(*panel, "panel.restore");
  EXPECT_EQ(harness.sink.Last<MaximizePanelCommand>()->panel, "");
}

TEST(Layout, KeepsSaneRatiosOnly) {
  LayoutRatios ratios;
  RatiosFromJson({{"columns", 0.3}, {"scene", 7}, {"image", "wide"}, {"other", 1}}, ratios);
  EXPECT_DOUBLE_EQ(ratios.columns, 0.3);
  EXPECT_LE(ratios.scene, 0.85);
  EXPECT_DOUBLE_EQ(ratios.image, LayoutRatios().image);
  LayoutRatios again;
  RatiosFromJson(RatiosToJson(ratios), again);
  EXPECT_DOUBLE_EQ(again.columns, ratios.columns);
}

TEST(Keys, HaveNamesBothWays) {
  EXPECT_EQ(KeyByName("space"), keys::kSpace);
  EXPECT_EQ(KeyByName("f"), keys::kF);
  EXPECT_EQ(KeyByName("no such key"), -1);
  EXPECT_EQ(NameOf(KeyStroke{keys::kLeft, true}), "Shift + Left");
  EXPECT_EQ(NameOf(KeyStroke{keys::kL, false, true}), "Ctrl + L");
}

}  // namespace
}  // namespace plumbline
