// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/imu.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace plumbline {
namespace {

TEST(ImuCalibration, ReadsWhatIsThereAndKeepsDefaultsForTheRest) {
  const auto imu = ImuCalibrationFromJson({{"rate_hz", 201.4},
                                           {"accel_bias_walk", 0.012},
                                           {"time_offset_s", -0.003},
                                           {"saturation_gyro_rad_s", 7.5},
                                           {"units", "SI"}},
                                          "imu.json");
  ASSERT_TRUE(imu.ok()) << imu.error().message;
  EXPECT_EQ(imu->rate_hz, 201.4);
  EXPECT_EQ(imu->accel_bias_walk, 0.012);
  EXPECT_EQ(imu->time_offset_s, -0.003);
  EXPECT_EQ(imu->saturation_gyro_rad_s, 7.5);
  EXPECT_FALSE(imu->saturation_accel_m_s2);
  EXPECT_EQ(imu->gyro_noise_density, ImuCalibration().gyro_noise_density);
}

TEST(ImuCalibration, RefusesWhatIsNoNumberOfItsRangeAndNamesTheFile) {
  for (const nlohmann::json& json : std::vector<nlohmann::json>{nlohmann::json::array(),
                                                                {{"width", 640}},
                                                                {{"rate_hz", 0}},
                                                                {{"gyro_noise_density", "low"}},
                                                                {{"accel_noise_density", -1}},
                                                                {{"time_offset_s", true}}}) {
    const auto imu = ImuCalibrationFromJson(json, "some/imu.json");
    ASSERT_FALSE(imu.ok()) << json;
    EXPECT_THAT(imu.error().message, testing::HasSubstr("some/imu.json"));
  }
}

}  // namespace
}  // namespace plumbline
