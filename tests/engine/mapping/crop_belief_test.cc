// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/crop_belief.h"

#include <gmock/gmock.h>

#include <numbers>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

using testing::DoubleNear;

const std::vector<ModelId> kLabels = {ModelId{2}, ModelId{5}};
/// Of label 2 at four turns, then of label 5.
const std::vector<std::optional<double>> kLikeness = {.9, .5, .8, .5, .7, .6, .6, .6};

TEST(CropBelief, WithoutAViewSaysNothing) {
  const CropBelief crops;
  EXPECT_EQ(crops.Likeness(ModelId{2}, 0.3), 0);
}

TEST(CropBelief, AsksForEveryShapeAtQuarterTurnsFromWhereItFirstWas) {
  CropBelief crops;
  const auto asked = crops.Candidates(kLabels, 0.2);
  ASSERT_EQ(asked.size(), kLikeness.size());
  EXPECT_EQ(asked[0].label, ModelId{2});
  EXPECT_EQ(asked[7].label, ModelId{5});
  EXPECT_THAT(asked[1].azimuth_rad, DoubleNear(0.2 + std::numbers::pi / 2, 1e-12));
  crops.Add(Eigen::Isometry3d::Identity(), kLabels, 0.2, kLikeness);
  EXPECT_THAT(crops.Candidates(kLabels, 0.3)[0].azimuth_rad, DoubleNear(0.2, 1e-12));
}

TEST(CropBelief, TellsTurnsAndShapesButNotFineAngles) {
  CropBelief crops;
  crops.Add(Eigen::Isometry3d::Identity(), kLabels, 0.2, kLikeness);
  EXPECT_EQ(crops.Likeness(ModelId{2}, 0.2), 0);
  EXPECT_EQ(crops.Likeness(ModelId{2}, 0.2 + 25 * kRadPerDeg), 0);
  EXPECT_EQ(crops.Likeness(ModelId{2}, 0.2 - 25 * kRadPerDeg), 0);
  EXPECT_THAT(crops.Likeness(ModelId{2}, 0.2 + std::numbers::pi), DoubleNear(-0.1, 1e-12));
  EXPECT_THAT(crops.Likeness(ModelId{2}, 0.2 + std::numbers::pi / 4),
              DoubleNear(-0.2, 1e-12));  // between
  EXPECT_THAT(crops.Likeness(ModelId{5}, 0.2 - std::numbers::pi / 2), DoubleNear(-0.3, 1e-12));
  EXPECT_THAT(crops.Likeness(ModelId{9}, 0.2), DoubleNear(-0.4, 1e-12));  // as the least like
}

TEST(CropBelief, ViewsAddUpAndALookThatDoesNotShowAllIsNone) {
  CropBelief crops;
  crops.Add(Eigen::Isometry3d::Identity(), kLabels, 0.2, kLikeness);
  auto part = kLikeness;
  part[3] = std::nullopt;
  crops.Add(Eigen::Isometry3d::Identity(), kLabels, 0.2, part);
  EXPECT_EQ(crops.views(), 1);
  EXPECT_EQ(crops.looked_from().size(), 2u);
  crops.Add(Eigen::Isometry3d::Identity(), kLabels, 0.9, kLikeness);
  EXPECT_EQ(crops.views(), 2);
  EXPECT_THAT(crops.Likeness(ModelId{2}, 0.2 + std::numbers::pi), DoubleNear(-0.2, 1e-12));
}

TEST(CropBelief, IsRestoredAsItWas) {
  CropBelief crops;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(1, 2, 3);
  crops.Add(pose, kLabels, 0.2, kLikeness);
  ByteWriter out;
  crops.Save(out);
  const std::string bytes = out.Take();
  ByteReader in(bytes);
  CropBelief again;
  again.Restore(in);
  EXPECT_TRUE(in.ok() && in.rest().empty());
  EXPECT_EQ(again.views(), 1);
  ASSERT_EQ(again.looked_from().size(), 1u);
  EXPECT_TRUE(again.looked_from()[0].isApprox(pose));
  for (const double angle : {0.0, 0.7, 1.9, 3.0, -2.0})
    EXPECT_EQ(again.Likeness(ModelId{5}, angle), crops.Likeness(ModelId{5}, angle));
}

}  // namespace
}  // namespace plumbline
