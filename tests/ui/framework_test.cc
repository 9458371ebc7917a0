// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/ui/panel_harness.h"
#include "ui/framework/actions.h"
#include "ui/framework/layout.h"
#include "ui/framework/pictures.h"
#include "ui/framework/theme.h"
#include "ui/framework/widgets.h"

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
  const cv::Mat picture = MaskPicture(image, depth, id, {1, 3});
  EXPECT_LT(cv::norm(picture.at<cv::Vec3b>(0)), cv::norm(picture.at<cv::Vec3b>(1)));
}

TEST(Pictures, TakeMapsOfHalfSize) {
  const cv::Mat image(4, 6, CV_8UC3, cv::Scalar(100, 100, 100));
  cv::Mat depth(2, 3, CV_32F, cv::Scalar(0)), id(2, 3, CV_16U, cv::Scalar(0));
  depth.at<float>(1, 2) = 2;
  id.at<std::uint16_t>(1, 2) = 1;
  const cv::Mat picture = MaskPicture(image, depth, id, {1, 3});
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

TEST(Theme, GivesNeighbouringObjectsDifferentColours) {
  std::set<ImU32> colors;
  for (int id = 1; id <= 8; ++id) colors.insert(ObjectColor({id}));
  EXPECT_EQ(colors.size(), 8u);
  EXPECT_EQ(ObjectColor({3}), ObjectColor({3}));
}

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
