// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/looks.h"

#include <gtest/gtest.h>

#include "engine/smoothing/object_views.h"

namespace plumbline {
namespace {

const PinholeCamera kCamera{480, 360, 420, 420, 239.5, 179.5};

TEST(Looks, ARestingCameraLooksOnceAndAWalkingOneAgainAndAgain) {
  std::vector<PassedFrame> resting, walking;
  for (int i = 0; i < 60; ++i) {
    resting.push_back({i, i * 10'000'000LL, Eigen::Isometry3d::Identity()});
    walking.push_back(resting.back());
    walking.back().world_from_cam.translation().x() = 0.05 * i;
  }
  const auto few = ChooseLooks(resting, kCamera, {}), many = ChooseLooks(walking, kCamera, {});
  EXPECT_EQ(few.size(), 1u);
  EXPECT_GT(many.size(), 10u);
  for (const Look& look : many) {
    EXPECT_GT(look.novelty, 0);
    EXPECT_LE(look.novelty, 1);
  }
}

TEST(Looks, TheSteadiestFrameOfAStretchIsChosen) {
  std::vector<PassedFrame> frames;
  double x = 0;
  for (int i = 0; i < 30; ++i) {
    x += i % 6 == 3 ? 0.001 : 0.03;  // it nearly stops now and then
    frames.push_back({i, i * 30'000'000LL, Eigen::Isometry3d::Identity()});
    frames.back().world_from_cam.translation().x() = x;
  }
  int steady = 0;
  const std::vector<Look> looks = ChooseLooks(frames, kCamera, {});
  for (const Look& look : looks) steady += look.at.frame % 6 == 3 ? 1 : 0;
  EXPECT_GE(steady, static_cast<int>(looks.size()) / 2);
}

TEST(Looks, ViewsAreTakenFromAllSides) {
  std::vector<ObjectSight> sights;
  for (int i = 0; i < 40; ++i) {  // many from the front, one from the side
    const double angle = i == 39 ? 1.5 : 0.005 * i;
    sights.push_back({i, 0.8, 1, 1, {std::cos(angle), std::sin(angle), 0}, 2.0});
  }
  const std::vector<std::size_t> chosen = ChooseViews(sights, 3);
  ASSERT_EQ(chosen.size(), 3u);
  EXPECT_EQ(chosen[1], 39u);
  sights.resize(2);
  EXPECT_EQ(ChooseViews(sights, 3).size(), 1u) << "the second one shows nothing new";
  EXPECT_TRUE(ChooseViews({}, 3).empty());
}

}  // namespace
}  // namespace plumbline
