// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/imu_lines.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(ImuLines, OfPhonesGiveTheirGyroscopeAndAccelerometerWhateverTheirOrder) {
  const auto reading = ParseImuLine("12.25, 3, 0.1,9.7,0.2, 4, 0.01,-0.02,0.03, 5, 20.1,-3.2,40");
  ASSERT_TRUE(reading.has_value());
  EXPECT_EQ(reading->stamp_ns, 12'250'000'000);
  EXPECT_EQ(reading->specific_force_m_s2, Eigen::Vector3d(0.1, 9.7, 0.2));
  EXPECT_EQ(reading->angular_velocity_rad_s, Eigen::Vector3d(0.01, -0.02, 0.03));
  const auto turned = ParseImuLine("12.25,4,0.01,-0.02,0.03,3,0.1,9.7,0.2");
  ASSERT_TRUE(turned.has_value());
  EXPECT_EQ(turned->specific_force_m_s2, reading->specific_force_m_s2);
  EXPECT_FALSE(ParseImuLine("12.25,3,0.1,9.7,0.2,5,1,2,3").has_value()) << "no gyroscope";
  EXPECT_FALSE(ParseImuLine("12.25,3,0.1,nan,0.2,4,1,2,3").has_value());
}

TEST(ImuLine, IsReadWithAndWithoutAStamp) {
  const auto with = ParseImuLine("12.000000005,1,-2,3e-1,0.1,0.2,9.8\r");
  ASSERT_TRUE(with.has_value());
  EXPECT_EQ(with->stamp_ns, 12'000'000'005);
  EXPECT_EQ(with->angular_velocity_rad_s, Eigen::Vector3d(1, -2, 0.3));
  EXPECT_EQ(with->specific_force_m_s2, Eigen::Vector3d(0.1, 0.2, 9.8));
  const auto without = ParseImuLine("1 2 3\t4 5 6");
  ASSERT_TRUE(without.has_value());
  EXPECT_FALSE(without->stamp_ns.has_value());
  EXPECT_EQ(without->specific_force_m_s2, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(ParseImuLine("1403636579763555584,1,2,3,4,5,6")->stamp_ns, 1403636579763555584);
}

TEST(ImuLine, IsNothingElse) {
  for (const char* text : {"", "t,wx,wy,wz,ax,ay,az", "1,2,3,4,5", "1,2,3,4,5,6,7,8",
                           "1,2,3,4,5,6,x", "1,2,3,nan,5,6,7", "1,2,3,4,inf,6", "{\"ax\": 1}"})
    EXPECT_FALSE(ParseImuLine(text).has_value()) << text;
}

TEST(ClockCarrier, TakesTheLeastDelayForTheClocks) {
  // The IMU's clock is 5 s behind, a reading takes 2 ms and up to 9 ms more.
  ClockCarrier carrier(200);
  constexpr std::int64_t kMillisecond = 1'000'000;
  for (int i = 0; i < 200; ++i) {
    EXPECT_FALSE(carrier.ready());
    const std::int64_t stamp_ns = 5 * kMillisecond * i;
    carrier.See(stamp_ns,
                stamp_ns + 5000 * kMillisecond + 2 * kMillisecond + (i * 37 % 10) * kMillisecond);
  }
  EXPECT_TRUE(carrier.ready());
  EXPECT_EQ(carrier.offset_ns(), 5002 * kMillisecond);
}

TEST(ClockCarrier, TellsAClockThatJumpedFromReadingsThatComeLate) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  ClockCarrier carrier(3);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(carrier.JumpBefore(i * kSecond / 100, 50 * kSecond + i * kSecond / 100), 0);
    carrier.See(i * kSecond / 100, 50 * kSecond + i * kSecond / 100);
  }
  const std::int64_t last_ns = 4 * kSecond / 100, arrived_ns = 50 * kSecond + last_ns;
  EXPECT_EQ(carrier.JumpBefore(last_ns + kSecond / 100, arrived_ns + 10 * kSecond), 0) << "held up";
  EXPECT_EQ(carrier.JumpBefore(last_ns + 10 * kSecond, arrived_ns + 10 * kSecond), 0)
      << "unplugged";
  EXPECT_EQ(carrier.JumpBefore(last_ns - kSecond / 10, arrived_ns), 0) << "out of order";
  EXPECT_NEAR(carrier.JumpBefore(last_ns - 30 * kSecond, arrived_ns + kSecond), -30, 1e-9);
  EXPECT_NEAR(carrier.JumpBefore(last_ns + 7 * kSecond, arrived_ns + 2 * kSecond), 5, 1e-9);

  ClockCarrier next(3);
  next.Know(50 * kSecond);
  EXPECT_TRUE(next.ready());
  EXPECT_EQ(next.JumpBefore(5 * kSecond, 56 * kSecond), 0);
  EXPECT_NEAR(next.JumpBefore(0, 95 * kSecond), -45, 1e-9) << "it began anew";
  EXPECT_NEAR(next.JumpBefore(60 * kSecond, 100 * kSecond), 10, 1e-9) << "ahead of its time";
}

}  // namespace
}  // namespace plumbline
