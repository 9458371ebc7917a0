// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/reference_states.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

TEST(ReferenceStates, AreThoseOfTheBodyWithVelocityAndBiases) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "groundtruth.csv";
  WriteText(file,
            "#t,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz\n"
            "0.5,1,2,3,0,0,1,0,4,5,6,7,8,9,10,11,12\n0.6,1,2,3,0,0,2,0,4,5,6,7,8,9,10,11,12\n");
  const auto read = ReadReferenceStates(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->states.size(), 1u);
  const ReferenceState& state = read->states[0];
  EXPECT_EQ(state.stamp_ns, 500000000);
  EXPECT_EQ(state.world_from_body.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((state.world_from_body * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 2, 3)).norm(),
            1e-12);
  EXPECT_EQ(state.velocity_in_world, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(state.gyro_bias, Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(state.accel_bias, Eigen::Vector3d(10, 11, 12));
  EXPECT_THAT(read->warnings, testing::ElementsAre(testing::HasSubstr("not of unit length")));
}

}  // namespace
}  // namespace plumbline
