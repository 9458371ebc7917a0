// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/imu_file.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ImuFile : public testing::Test {
 protected:
  Result<ImuRecording> Read(const std::string& text) {
    WriteText(file_, text);
    return ReadImuFile(file_);
  }
  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "imu.csv";
};

TEST_F(ImuFile, TakesSecondsAndNanosecondsExactly) {
  const auto imu = Read(
      "t,wx,wy,wz,ax,ay,az\n1403636579763555584,0.1,-0.2,0.3,1,2,9.8\n"
      "1403636579.768555585,0,0,0,0,0,9.8\n");
  ASSERT_TRUE(imu.ok()) << imu.error().message;
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_EQ(imu->samples[0].stamp_ns, 1403636579763555584);
  EXPECT_EQ(imu->samples[1].stamp_ns, 1403636579768555585);
  EXPECT_EQ(imu->samples[0].angular_velocity_rad_s, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(imu->samples[0].specific_force_m_s2, Eigen::Vector3d(1, 2, 9.8));
  EXPECT_TRUE(imu->warnings.empty());
}

TEST_F(ImuFile, SortsDropsDoublesAndSaysSo) {
  const auto imu = Read(
      "0.2,1,0,0,0,0,0\n0.1,2,0,0,0,0,0\n0.2,3,0,0,0,0,0\n0.3,4,0,0,0,0\n"
      "0.4,nan,0,0,0,0,0\n");
  ASSERT_TRUE(imu.ok()) << imu.error().message;
  ASSERT_EQ(imu->samples.size(), 2u);
  EXPECT_EQ(imu->samples[0].angular_velocity_rad_s.x(), 2);
  EXPECT_EQ(imu->samples[1].angular_velocity_rad_s.x(), 1);
  EXPECT_THAT(imu->warnings,
              ElementsAre(HasSubstr("line 4: not a row 't,wx,wy,wz,ax,ay,az'"),
                          HasSubstr("line 5: a number is not finite"), HasSubstr("do not rise"),
                          HasSubstr("1 IMU samples with the stamp of another")));
}

TEST_F(ImuFile, WithoutAUsableRowIsAnErrorThatNamesIt) {
  EXPECT_EQ(Read("").error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(Read("hello\nworld\n").error().message, HasSubstr("imu.csv"));
  EXPECT_EQ(ReadImuFile(folder_.path() / "none.csv").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace plumbline
