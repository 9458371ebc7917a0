// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/joint_solution.h"

#include <gtest/gtest.h>

#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

class JointSolutionOf : public testing::Test {
 protected:
  MeasuredObject Measured(const char* name, double x, double z, double std_m, bool on_floor) {
    const ModelId label = map_.database->Find(name).value();
    const CadModel& model = map_.database->model(label);
    MeasuredObject object;
    object.pose = {label, 0, model.center() + Eigen::Vector3d(x, 0, z)};
    object.covariance = std_m * std_m * Eigen::Matrix4d::Identity();
    object.solid = std::make_shared<const SolidModel>(SolidModel::Prepare(model).value());
    object.on_floor = on_floor;
    return object;
  }
  MapFrame map_{UprightFrame({0, 0, -9.81}), Eigen::Vector4d(0, 0, 1, 0), MakeFurnitureDatabase()};
};

TEST_F(JointSolutionOf, PenetratingObjectsGetsThemApartTheLessCertainOneFurther) {
  // Crates are 40 cm long: 8 cm are too much.
  const std::vector<MeasuredObject> crates = {Measured("crate", 0, 0, 0.01, false),
                                              Measured("crate", 0.32, 0, 0.03, false)};
  const JointSolution solution = SolveJointly(crates, map_, {});
  const double a = solution.poses[0].center_in_world.x(), b = solution.poses[1].center_in_world.x();
  EXPECT_GT(b - a, 0.385) << "apart up to a centimetre and the sampling of the surface";
  EXPECT_LT(b - a, 0.41) << "but no further";
  EXPECT_NEAR((b - 0.32) / -a, 9, 1) << "in proportion to their variances";
  EXPECT_NEAR(solution.covariances[0](0, 0), 1e-4, 1e-9) << "contacts make nothing more certain";
}

TEST_F(JointSolutionOf, ObjectsOnOneFloorSharesItsHeight) {
  // The floor is 2 cm lower than was given; one object's images say nothing about its height.
  std::vector<MeasuredObject> objects = {
      Measured("chair", 0, -0.020, 0.004, true), Measured("chair", 2, -0.024, 0.004, true),
      Measured("table", 4, -0.018, 0.004, true), Measured("table", 7, 0.02, 0.05, true),
      Measured("crate", 9, 0.30, 0.004, true)};
  const JointSolution solution = SolveJointly(objects, map_, {});
  EXPECT_EQ(solution.floor_objects, 4) << "the crate stands on something else";
  EXPECT_NEAR(solution.floor_height_m, -0.018, 0.006);
  EXPECT_LT(solution.floor_std_m, 0.008);
  EXPECT_NEAR(map_.BaseHeight(solution.poses[3]), solution.floor_height_m, 0.005);
  EXPECT_LT(std::sqrt(solution.covariances[3](2, 2)), 0.015);
  EXPECT_NEAR(map_.BaseHeight(solution.poses[4]), 0.30, 1e-9);
  map_.floor_in_world.reset();
  EXPECT_NEAR(SolveJointly(objects, map_, {}).floor_height_m, -0.0205, 0.003)
      << "without a floor given, the objects alone say where it is";
}

TEST_F(JointSolutionOf, ObjectsOnAPlatformShareTheFloorBelowIt) {
  map_.levels = {{0.3, 0, {{3, -1, 0}, {9, -1, 0}, {9, 1, 0}, {3, 1, 0}}}};
  const std::vector<MeasuredObject> objects = {Measured("chair", 0, -0.020, 0.004, true),
                                               Measured("chair", 4, 0.276, 0.004, true),
                                               Measured("table", 7, 0.281, 0.004, true)};
  const JointSolution solution = SolveJointly(objects, map_, {});
  EXPECT_EQ(solution.floor_objects, 3);
  EXPECT_NEAR(solution.floor_height_m, -0.020, 0.006);
  EXPECT_NEAR(map_.BaseHeight(solution.poses[2]), 0.3 + solution.floor_height_m, 0.005);
}

TEST_F(JointSolutionOf, FreeObjectsIsWhatWasMeasured) {
  const std::vector<MeasuredObject> objects = {Measured("crate", 0, 0.5, 0.02, false),
                                               Measured("crate", 2, 0.7, 0.02, false)};
  const JointSolution solution = SolveJointly(objects, map_, {});
  for (std::size_t i = 0; i < objects.size(); ++i) {
    EXPECT_LT((solution.poses[i].center_in_world - objects[i].pose.center_in_world).norm(), 1e-9);
    EXPECT_LT((solution.covariances[i] - objects[i].covariance).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace plumbline
