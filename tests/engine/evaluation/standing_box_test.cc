// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/standing_box.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/engine/evaluation/test_scene.h"

namespace plumbline {
namespace {

class StandingBoxes : public testing::Test {
 protected:
  /// A cube of 1 m on the floor.
  CadModel Cube() const {
    CadModel model;
    model.mesh = BoxMesh(1, 1, 1);
    return model;
  }
  StandingBox Box(const Eigen::Isometry3d& pose, double scale = 1) const {
    return BoxOf(Cube(), pose, scale, upright_);
  }

  UprightFrame upright_{Eigen::Vector3d(0, 0, -1)};
};

TEST_F(StandingBoxes, OverlapByTheClosedForms) {
  const StandingBox box = Box(UprightPose(0, 0, 0, 0));
  EXPECT_NEAR(box.volume(), 1, 1e-12);
  EXPECT_NEAR(Iou(box, box), 1, 1e-12);
  EXPECT_NEAR(Iou(box, Box(UprightPose(0.5, 0, 0, 0))), 0.5 / 1.5, 1e-12);
  EXPECT_NEAR(Iou(box, Box(UprightPose(0.5, 0.5, 0.5, 0))), 0.125 / 1.875, 1e-12);
  EXPECT_EQ(Iou(box, Box(UprightPose(1.2, 0, 0, 0))), 0);
  EXPECT_EQ(Iou(box, Box(UprightPose(0, 0, 1.2, 0))), 0);
  EXPECT_NEAR(Iou(box, Box(UprightPose(0, 0, 0, 90))), 1, 1e-9);
  // Turned by 45 degrees about the same middle they share an octagon of area 2 (sqrt(2) - 1).
  const double octagon = 2 * (std::numbers::sqrt2 - 1);
  EXPECT_NEAR(Iou(box, Box(UprightPose(0, 0, 0, 45))), octagon / (2 - octagon), 1e-6)
      << "vertices are floats";
  EXPECT_NEAR(Iou(box, Box(UprightPose(0, 0, 0, 0), 0.5)), 0.125, 1e-12) << "one inside the other";
}

TEST_F(StandingBoxes, StandUprightRoundATiltedModel) {
  Eigen::Isometry3d tilted = UprightPose(0, 0, 0, 30);
  tilted.rotate(Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitY()));
  // Tilted by 45 degrees about its own y: sqrt(2) high and wide, 1 m deep.
  EXPECT_NEAR(Box(tilted).volume(), 2, 1e-6);
  EXPECT_NEAR(Box(tilted).top_m - Box(tilted).bottom_m, std::numbers::sqrt2, 1e-6);
}

TEST_F(StandingBoxes, DoNotDependOnTheDirectionOfGravity) {
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  turn.translation() = Eigen::Vector3d(3, -1, 2);
  const UprightFrame turned(turn.linear() * Eigen::Vector3d(0, 0, -1));
  const Eigen::Isometry3d a = UprightPose(0, 0, 0, 10), b = UprightPose(0.2, 0.3, 0.1, 50);
  EXPECT_NEAR(Iou(BoxOf(Cube(), turn * a, 1, turned), BoxOf(Cube(), turn * b, 1, turned)),
              Iou(Box(a), Box(b)), 1e-6);
}

}  // namespace
}  // namespace plumbline
