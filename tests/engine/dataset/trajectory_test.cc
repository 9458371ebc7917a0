// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/trajectory.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class TrajectoryFile : public testing::Test {
 protected:
  Result<Trajectory> Read(const std::string& text,
                          std::optional<Eigen::Isometry3d> body_from_cam = std::nullopt) {
    WriteText(file_, text);
    return ReadTrajectory(file_, body_from_cam);
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "trajectory.txt";
};

TEST_F(TrajectoryFile, HoldsQuaternionsInTheOrderXYZW) {
  const Result<Trajectory> trajectory = Read("# comment\n0.5 1 2 3 0 0 0.70710678 0.70710678\n");
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().message;
  Eigen::Isometry3d expected(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  expected.translation() << 1, 2, 3;
  EXPECT_THAT(trajectory->poses.at(0).world_from_cam, IsometryNear(expected, 1e-6, 1e-12));
  EXPECT_EQ(trajectory->poses[0].stamp_ns, 500000000);
  EXPECT_TRUE(trajectory->warnings.empty());
}

TEST_F(TrajectoryFile, AppliesBodyFromCamWhereTheFirstLineSaysSo) {
  Eigen::Isometry3d body_from_cam(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  body_from_cam.translation() << 0, 0, 0.5;
  const std::string text =
      "# world_from_body\n0 1 2 3 0 0 0.70710678118654757 0.70710678118654757\n";
  Eigen::Isometry3d world_from_body(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  world_from_body.translation() << 1, 2, 3;
  const Result<Trajectory> trajectory = Read(text, body_from_cam);
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().message;
  EXPECT_THAT(trajectory->poses.at(0).world_from_cam,
              IsometryNear(world_from_body * body_from_cam, 1e-6, 1e-12));
  const Result<Trajectory> refused = Read(text);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("body_from_cam"));
}

TEST_F(TrajectoryFile, LeavesOutBadRowsAndNamesThem) {
  const Result<Trajectory> trajectory = Read(
      "0 0 0 0 0 0 0 1\n"
      "1 nan 0 0 0 0 0 1\n"
      "2 0 0 0 0 0 0 2\n"
      "3 0 0 0 0 0 0 0\n"
      "soon 0 0 0 0 0 0 1\n"
      "5 0 0 0 0 0\n"
      "6 0 0 0 0 0 0 1.001\n");
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().message;
  ASSERT_EQ(trajectory->poses.size(), 2u);
  EXPECT_NEAR(trajectory->poses[1].world_from_cam.linear().determinant(), 1, 1e-12);
  EXPECT_THAT(trajectory->warnings,
              ElementsAre(HasSubstr("line 2: the pose is not finite"),
                          HasSubstr("line 3 (and 1 more): the quaternion"),
                          HasSubstr("line 5: the stamp"), HasSubstr("line 6: not 8 numbers")));
}

TEST_F(TrajectoryFile, LeavesOutPosesThatAreFartherAwayThanAnyRoomIsLarge) {
  const Result<Trajectory> trajectory = Read(
      "0 0 0 0 0 0 0 1\n"
      "1 1e300 0 0 0 0 0 1\n"
      "2 0 0 -2e6 0 0 0 1\n");
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().message;
  EXPECT_EQ(trajectory->poses.size(), 1u);
  EXPECT_THAT(trajectory->warnings,
              ElementsAre(HasSubstr("line 2 (and 1 more): the pose is more than 1000 km")));
}

TEST_F(TrajectoryFile, SortsRowsAndKeepsTheFirstOfEqualStamps) {
  const Result<Trajectory> trajectory =
      Read("2 2 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 9 0 0 0 0 0 1\n3 3 0 0 0 0 0 1\n");
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().message;
  ASSERT_EQ(trajectory->poses.size(), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(trajectory->poses[i].world_from_cam.translation().x(), i + 1);
  EXPECT_THAT(trajectory->warnings,
              ElementsAre(HasSubstr("line 2: the stamp is before"), HasSubstr("first of each")));
}

TEST_F(TrajectoryFile, FindsTheNearestPoseButNoneTooFar) {
  const Trajectory trajectory = Read("1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n").value();
  const auto x = [&](double seconds) {
    const auto pose = trajectory.Nearest(std::llround(seconds * 1e9), 100000000);
    return pose ? pose->translation().x() : -1.0;
  };
  EXPECT_EQ(x(0.9), 1);
  EXPECT_EQ(x(1.09), 1);
  EXPECT_EQ(x(1.11), -1);
  EXPECT_EQ(x(1.95), 2);
  EXPECT_EQ(x(2.1), 2);
  EXPECT_EQ(x(2.2), -1);
  EXPECT_EQ(Trajectory().Nearest(0, 1000), std::nullopt);
}

TEST_F(TrajectoryFile, WithoutAUsableRowIsAnError) {
  EXPECT_EQ(Read("").error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(Read("\x01\x02garbage\n").error().message, HasSubstr("line 1"));
  std::filesystem::remove(file_);
  EXPECT_EQ(ReadTrajectory(file_, std::nullopt).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace plumbline
