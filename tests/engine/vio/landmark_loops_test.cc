// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/landmark_loops.h"

#include <cmath>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

/// A round of 4 m across in 200 poses, told by a filter that turns 3 degrees and climbs 6 cm too
/// much on the way and says so.
struct Walk {
  std::vector<Eigen::Isometry3d> truth;
  std::vector<PoseEstimate> told;
};

Walk MakeWalk() {
  Walk walk;
  Eigen::Isometry3d told = Eigen::Isometry3d::Identity();
  for (int k = 0; k < 200; ++k) {
    const double angle = 2 * M_PI * k / 199;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()))
                        .toRotationMatrix();
    pose.translation() << 2 * std::cos(angle), 2 * std::sin(angle), 1.4;
    const Eigen::Isometry3d step =
        k == 0 ? pose : Eigen::Isometry3d(walk.truth.back().inverse() * pose);
    told = told * step;
    if (k > 0) {
      told.linear() = Eigen::AngleAxisd(0.05 / 199, Eigen::Vector3d::UnitZ()) * told.linear();
      told.translation().z() += 0.06 / 199;
    }
    PoseEstimate estimate{PoseId{k}, std::int64_t{k} * 100'000'000, told, {}, 0};
    auto variance = estimate.uncertainty.drift.diagonal();
    variance.head<3>().setConstant(k * 0.03 * 0.03 / 200);
    variance(5) = k * 0.02 * 0.02 / 200;
    walk.truth.push_back(pose);
    walk.told.push_back(estimate);
  }
  return walk;
}

LandmarkEdge EdgeBetween(const Walk& walk, int from, int to) {
  LandmarkEdge edge;
  edge.object = ObjectId{3};
  edge.from = PoseId{from};
  edge.to = PoseId{to};
  const auto at = [&](int k) { return walk.truth[static_cast<std::size_t>(k)]; };
  edge.from_cam_from_to_cam = at(from).inverse() * at(to);
  edge.covariance = Eigen::Vector4d(1e-4, 1e-4, 1e-4, 1e-4).asDiagonal();
  edge.moved_m = 0.1;
  return edge;
}

double ErrorAt(const Walk& walk, const std::vector<PoseEstimate>& poses, int k) {
  const auto at = static_cast<std::size_t>(k);
  return (poses[at].world_from_cam.translation() - walk.truth[at].translation()).norm();
}

TEST(LandmarkLoops, AnObjectSeenAgainBringsTheWalkBack) {
  const Walk walk = MakeWalk();
  LandmarkLoops loops({});
  for (const PoseEstimate& pose : walk.told) {
    EXPECT_TRUE(loops.AtItsTime(pose).world_from_cam.isApprox(pose.world_from_cam, 0));
    loops.See(pose);
  }
  EXPECT_TRUE(loops.empty());
  const double before = ErrorAt(walk, walk.told, 199);
  ASSERT_GT(before, 0.1);
  const LandmarkEdge edge = EdgeBetween(walk, 5, 199);
  ASSERT_TRUE(loops.Add({&edge, 1}));
  const std::vector<PoseEstimate> known = loops.Known();
  EXPECT_LT(ErrorAt(walk, known, 199), 0.03);
  EXPECT_LT(ErrorAt(walk, known, 100), 0.7 * ErrorAt(walk, walk.told, 100));
  EXPECT_TRUE(known[0].world_from_cam.isApprox(walk.told[0].world_from_cam, 1e-9));
  EXPECT_EQ(known[199].epoch, 1);
  EXPECT_EQ(known[5].epoch, 1);
  // It knows better now where it is, and where it was.
  EXPECT_LT(known[199].uncertainty.drift(0, 0), 0.5 * walk.told[199].uncertainty.drift(0, 0));
  // A pose to come goes on from there; one that was before the correction was told as it was.
  PoseEstimate later = walk.told[199];
  later.id = PoseId{200};
  later.world_from_cam.translation().x() += 0.1;
  const PoseEstimate next = loops.AtItsTime(later);
  const Eigen::Isometry3d step = walk.told[199].world_from_cam.inverse() * later.world_from_cam;
  EXPECT_LT((next.world_from_cam.matrix() - (known[199].world_from_cam * step).matrix()).norm(),
            1e-9);
  EXPECT_EQ(next.epoch, 1);
  EXPECT_EQ(loops.AtItsTime(walk.told[150]).epoch, 0);
}

TEST(LandmarkLoops, GivesAnObjectUpThatWasMoved) {
  const Walk walk = MakeWalk();
  LandmarkLoops loops({});
  for (const PoseEstimate& pose : walk.told) loops.See(pose);
  LandmarkEdge moved = EdgeBetween(walk, 5, 199);
  moved.from_cam_from_to_cam.translation().x() += 1.5;
  const LandmarkEdge edges[] = {moved, EdgeBetween(walk, 7, 199), EdgeBetween(walk, 9, 198)};
  ASSERT_TRUE(loops.Add(edges));
  EXPECT_LT(ErrorAt(walk, loops.Known(), 199), 0.05);
}

TEST(LandmarkLoops, OfPosesThatNobodyToldThereIsNothingToCorrect) {
  const Walk walk = MakeWalk();
  LandmarkLoops loops({});
  loops.See(walk.told[0]);
  const LandmarkEdge edge = EdgeBetween(walk, 5, 199);
  EXPECT_FALSE(loops.Add({&edge, 1}));
  EXPECT_TRUE(loops.empty());
  EXPECT_FALSE(loops.Known(PoseId{5}));
}

TEST(LandmarkEdges, ComeBackFromTextAndDamageIsSaid) {
  const Walk walk = MakeWalk();
  const LandmarkEdge edges[] = {EdgeBetween(walk, 5, 199), EdgeBetween(walk, 7, 150)};
  const std::string text = LandmarkEdgesToText(edges);
  const auto read = LandmarkEdgesFromText(text);
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read->size(), 2u);
  EXPECT_TRUE((*read)[1].from_cam_from_to_cam.isApprox(edges[1].from_cam_from_to_cam, 0));
  EXPECT_TRUE((*read)[0].covariance.isApprox(edges[0].covariance, 0));
  EXPECT_EQ((*read)[0].to, PoseId{199});
  EXPECT_EQ(DescribeLandmarkEdges(edges),
            "poses corrected: object 3 was seen 10.0 cm from where it stood, object 3 was seen "
            "10.0 cm from where it stood");
  for (const char* bad : {"", "{}", "[]", R"({"landmarks":[{"object":1}]})",
                          R"({"landmarks":[{"object":1,"from":0,"to":1,"moved_m":0,
                              "from_cam_from_to_cam":[1],"covariance":[]}]})"})
    EXPECT_FALSE(LandmarkEdgesFromText(bad).ok()) << bad;
  LandmarkEdge impossible = edges[0];
  impossible.covariance(0, 0) = -1;
  EXPECT_FALSE(LandmarkEdgesFromText(LandmarkEdgesToText({&impossible, 1})).ok());
}

}  // namespace
}  // namespace plumbline
