// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/sequence_alignment.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Neither frame is z-up, so that nothing is right by accident.
class SequenceAlignmentTest : public testing::Test {
 protected:
  SequenceAlignmentTest() {
    scan_from_level_ =
        Eigen::Translation3d(1, 2, 3) * AngleAxisd(0.4, Vector3d(1, 0.3, 0.2).normalized());
    world_from_level_ = Eigen::Translation3d(-2, 0.5, 1) * AngleAxisd(2.1, Vector3d::UnitZ()) *
                        AngleAxisd(-0.6, Vector3d(0.2, 1, 0).normalized());
    truth_ = scan_from_level_ * world_from_level_.inverse();
    gravity_.in_scan = -scan_from_level_.linear().col(2);
    gravity_.in_world = -world_from_level_.linear().col(2);
  }

  Vector3d InRoom() {
    return {4 * uniform_(random_) - 2, 4 * uniform_(random_) - 2, 2 * uniform_(random_)};
  }
  PickedPair Point(double noise_m) {
    const Vector3d in_level = InRoom();
    return {scan_from_level_ * in_level,
            Vector3d(world_from_level_ * in_level +
                     noise_m * Vector3d(normal_(random_), normal_(random_), normal_(random_)))};
  }
  PickedPair Click(const Vector3d& eye_in_level, double noise_px) {
    constexpr double kPixel_rad = 1.0 / 525;
    const Vector3d in_level = InRoom();
    Vector3d direction = in_level - eye_in_level;
    const double depth = direction.norm();
    direction += depth * kPixel_rad * noise_px *
                 Vector3d(normal_(random_), normal_(random_), normal_(random_));
    WorldRay ray{world_from_level_ * eye_in_level,
                 (world_from_level_.linear() * direction).normalized(), kPixel_rad};
    return {scan_from_level_ * in_level, ray};
  }
  void ExpectUpright(const Isometry3d& scan_from_world) const {
    EXPECT_LT((scan_from_world.linear() * gravity_.in_world - gravity_.in_scan).norm(), 1e-9);
  }

  Isometry3d scan_from_level_, world_from_level_, truth_;
  GravityPair gravity_;
  std::mt19937 random_{3};
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::normal_distribution<double> normal_{0, 1};
};

TEST_F(SequenceAlignmentTest, FindsThePlaceFromTwoExactPoints) {
  const auto found = AlignByPairs({Point(0), Point(0)}, gravity_);
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(found->scan_from_world, IsometryNear(truth_, 1e-5, 1e-6));
  ExpectUpright(found->scan_from_world);
}

TEST_F(SequenceAlignmentTest, FindsThePlaceFromThreeExactClicksInTwoImages) {
  const Vector3d a(3, 1, 1.5), b(-3, -0.5, 1.2);
  const auto found = AlignByPairs({Click(a, 0), Click(a, 0), Click(b, 0)}, gravity_);
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(found->scan_from_world, IsometryNear(truth_, 1e-4, 1e-5));
  ExpectUpright(found->scan_from_world);
  for (const double residual : found->residuals) EXPECT_LT(residual, 1e-3);
}

TEST_F(SequenceAlignmentTest, SaysHowSureItIsOfNoisyPairsOfBothSorts) {
  // Over many trials the errors are what the covariance says, within a factor of two.
  double squares = 0, expected = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<PickedPair> pairs;
    for (int i = 0; i < 3; ++i) pairs.push_back(Point(0.02));
    for (int i = 0; i < 6; ++i) pairs.push_back(Click({3, 1.0 * i - 3, 1.5}, 2));
    const auto found = AlignByPairs(pairs, gravity_);
    ASSERT_TRUE(found.ok()) << found.error().message;
    ExpectUpright(found->scan_from_world);
    const double turn =
        AngleAxisd(found->scan_from_world.linear().transpose() * truth_.linear()).angle();
    squares += turn * turn;
    expected += found->azimuth_std_rad * found->azimuth_std_rad;
    EXPECT_EQ(found->residuals.size(), pairs.size());
    EXPECT_LT(turn, 1.5 * kRadPerDeg);
  }
  EXPECT_LT(squares, 4 * expected);
  EXPECT_GT(squares, expected / 4);
}

TEST_F(SequenceAlignmentTest, RefusesPairsThatDoNotShowTheTurn) {
  EXPECT_EQ(AlignByPairs({Point(0)}, gravity_).error().code, ErrorCode::kInvalidInput);
  PickedPair low = Point(0), high = low;  // one above the other
  high.in_scan -= gravity_.in_scan;
  std::get<Vector3d>(high.in_world) -= gravity_.in_world;
  EXPECT_EQ(AlignByPairs({low, high}, gravity_).error().code, ErrorCode::kDegenerate);
  const Vector3d eye(3, 1, 1.5);
  EXPECT_EQ(AlignByPairs({Click(eye, 0)}, gravity_).error().code, ErrorCode::kInvalidInput);
}

TEST_F(SequenceAlignmentTest, LaysSparsePointsOntoAScanFromNothingKnown) {
  // A floor, two walls of different length and a box.
  TriangleMesh scan;
  const auto add = [&](const Vector3d& in_level) {
    scan.vertices.push_back((scan_from_level_ * in_level).cast<float>());
  };
  std::vector<Eigen::Vector3f> sparse;
  for (int i = 0; i < 30000; ++i) {
    const double u = uniform_(random_), v = uniform_(random_);
    const Vector3d in_level = i % 4 == 0   ? Vector3d(5 * u, 3 * v, 0)
                              : i % 4 == 1 ? Vector3d(5 * u, 0, 2 * v)
                              : i % 4 == 2 ? Vector3d(0, 3 * u, 2 * v)
                                           : Vector3d(1 + u, 1.8, 0.8 * v);
    add(in_level);
    if (i % 19 != 5) continue;
    const Vector3d noise(normal_(random_), normal_(random_), normal_(random_));
    sparse.push_back((world_from_level_ * (in_level + 0.01 * noise)).cast<float>());
  }
  for (int i = 0; i < 150; ++i)
    sparse.push_back((world_from_level_ * (2 * InRoom())).cast<float>());
  const auto target =
      ScanTarget::Prepare(scan, {scan_from_level_ * Vector3d(2.5, 1.5, 1.2)}).value();
  const auto near = AlignByPoints(sparse, *target, gravity_, truth_);
  ASSERT_TRUE(near.ok());
  EXPECT_THAT(near->scan_from_world, IsometryNear(truth_, 0.5, 0.05));
  const auto found = AlignByPoints(sparse, *target, gravity_, std::nullopt);
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(
      found->scan_from_world * (world_from_level_ * Vector3d(2.5, 1.5, 1)),
      testing::ResultOf(
          [&](const Vector3d& p) { return (p - scan_from_level_ * Vector3d(2.5, 1.5, 1)).norm(); },
          testing::Lt(0.01)));
  EXPECT_LT(AngleAxisd(found->scan_from_world.linear().transpose() * truth_.linear()).angle(),
            0.5 * kRadPerDeg);
  ExpectUpright(found->scan_from_world);
  EXPECT_GT(found->share, 0.7);
  EXPECT_LT(found->share, 0.97) << "far points are left out";
  // The middle of what was compared is known to well under the 10 mm of one point, and not wrong
  // by more than it says.
  const Vector3d middle(1.6, 1.2, 0.7);
  const double off =
      ((found->scan_from_world * world_from_level_).inverse() * scan_from_level_ * middle - middle)
          .norm();
  EXPECT_LT(found->position_std_m.norm(), 0.003);
  EXPECT_LT(off, 4 * found->position_std_m.norm());
}

TEST_F(SequenceAlignmentTest, MatchesMappedObjectsToAnnotatedOnesOfTheirKind) {
  std::vector<PosedObject> annotated, mapped;
  const auto add = [&](const char* kind, double x, double y, double azimuth_deg, bool is_mapped) {
    const Isometry3d in_level =
        Eigen::Translation3d(x, y, 0) * AngleAxisd(azimuth_deg * kRadPerDeg, Vector3d::UnitZ());
    annotated.push_back({kind, scan_from_level_ * in_level});
    if (!is_mapped) return;
    const Isometry3d off =
        Eigen::Translation3d(0.03 * normal_(random_), 0.03 * normal_(random_), 0) *
        AngleAxisd(0.05 * normal_(random_), Vector3d::UnitZ());
    mapped.push_back({kind, world_from_level_ * in_level * off});
  };
  add("chair", 0, 0, 10, true);
  add("chair", 1.1, 0, 100, true);
  add("chair", 1.2, 2.4, 190, false);
  add("table", 0.6, 0.9, 0, true);
  add("sofa", -1, 2, 270, true);
  mapped.push_back(
      {"chair", world_from_level_ * Isometry3d(Eigen::Translation3d(-3, -3, 0))});  // none
  mapped.push_back({"tv", world_from_level_});
  const auto found = AlignByObjects(mapped, annotated, gravity_);
  ASSERT_TRUE(found.ok()) << found.error().message;
  const Vector3d middle = scan_from_level_ * Vector3d(0.4, 0.9, 0);
  EXPECT_LT((found->scan_from_world * truth_.inverse() * middle - middle).norm(), 0.06);
  EXPECT_LT(AngleAxisd(found->scan_from_world.linear().transpose() * truth_.linear()).angle(),
            4 * kRadPerDeg);
  ExpectUpright(found->scan_from_world);
  ASSERT_EQ(found->residuals.size(), 6u);
  for (int i = 0; i < 4; ++i) EXPECT_LT(found->residuals[static_cast<std::size_t>(i)], 0.12);
  EXPECT_LT(found->residuals[4], 0);
  EXPECT_LT(found->residuals[5], 0);
  EXPECT_EQ(AlignByObjects({mapped[5]}, annotated, gravity_).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace plumbline
