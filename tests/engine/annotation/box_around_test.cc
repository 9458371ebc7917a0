// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/box_around.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/dataset/ground_truth.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_database.h"
#include "engine/registration/floor.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// A floor, a wall 2.2 m high along y = 1, a table of 1.0 x 0.6 x 0.72 m turned by 0.4 with a cup
/// on it, and a cabinet of 0.6 x 0.4 x 0.9 m against the wall.
class Room : public testing::Test {
 protected:
  void SetUp() override {
    TriangleMesh room = MakeGrid({-2, -2, 0}, {4, 0, 0}, {0, 3, 0}, 200);
    Append(MakeGrid({-2, 1, 0}, {4, 0, 0}, {0, 0, 2.2f}, 200), room);
    const Eigen::Isometry3d table =
        Eigen::Translation3d(0.2, -0.6, 0) * Eigen::AngleAxisd(0.4, Vector3d::UnitZ());
    Append(Transformed(MakeGrid({-0.5f, -0.3f, 0.72f}, {1, 0, 0}, {0, 0.6f, 0}, 60), table), room);
    for (const float x : {-0.46f, 0.46f})
      for (const float y : {-0.26f, 0.26f})
        for (const float z : {0.0f, 0.24f, 0.48f})
          Append(Transformed(MakeFineBox({0.05f, 0.05f, 0.24f}),
                             table * Eigen::Translation3d(x, y, z)),
                 room);
    Append(Transformed(MakeFineBox({0.08f, 0.08f, 0.1f}),
                       Eigen::Isometry3d(Eigen::Translation3d(0.2, -0.6, 0.72))),
           room);
    Append(MakeGrid({-1.5f, 0.58f, 0}, {0.6f, 0, 0}, {0, 0, 0.9f}, 60), room);
    Append(MakeGrid({-1.5f, 0.58f, 0.9f}, {0.6f, 0, 0}, {0, 0.4f, 0}, 60), room);
    for (const float x : {-1.5f, -0.9f})
      Append(MakeGrid({x, 0.58f, 0}, {0, 0.4f, 0}, {0, 0, 0.9f}, 60), room);
    scan_ = *ScanTarget::Prepare(room);
  }
  Result<CropBox> At(const Vector3d& point) const {
    BoxSurroundings known;
    known.floor_in_scan = Eigen::Vector4d(0, 0, 1, 0);
    return BoxAround(*scan_, point, known);
  }

  std::shared_ptr<const ScanTarget> scan_;
};

TEST_F(Room, ATableIsTakenWithoutTheFloorAndInItsOwnDirection) {
  const auto box = At({0.45, -0.5, 0.72});
  ASSERT_TRUE(box.ok()) << box.error().message;
  EXPECT_NEAR(box->size_m.maxCoeff(), 1.02, 0.06);
  EXPECT_NEAR(box->size_m.head<2>().minCoeff(), 0.62, 0.06);
  EXPECT_NEAR(box->center_in_scan.z() - 0.5 * box->size_m.z(), 0, 0.02) << "it stands on the floor";
  const double quarter = 0.5 * std::numbers::pi;
  EXPECT_NEAR(std::remainder(box->azimuth_rad - 0.4, quarter), 0, 0.05);
  EXPECT_LT(std::abs(box->azimuth_rad), 0.8) << "its front is the side towards the eye";
}

TEST_F(Room, ACupIsTakenWithoutItsTable) {
  const auto box = At({0.2, -0.6, 0.82});
  ASSERT_TRUE(box.ok()) << box.error().message;
  EXPECT_LT(box->size_m.head<2>().maxCoeff(), 0.15);
  EXPECT_NEAR(box->size_m.z(), 0.1, 0.04);
}

TEST_F(Room, ACabinetIsTakenWithoutTheWallBehindIt) {
  const auto box = At({-1.2, 0.58, 0.5});
  ASSERT_TRUE(box.ok()) << box.error().message;
  EXPECT_NEAR(box->size_m.z(), 0.92, 0.05);
  EXPECT_LT(box->size_m.head<2>().maxCoeff(), 0.75);
}

TEST_F(Room, FloorAndWallsAreNoThings) {
  for (const Vector3d& point : {Vector3d(1.2, -1.2, 0), Vector3d(1, 1, 1.2)}) {
    const auto box = At(point);
    ASSERT_FALSE(box.ok());
    EXPECT_THAT(box.error().message, HasSubstr("floor or wall"));
  }
}

TEST_F(Room, WhatGoesOnBeyondItsSurroundingsIsNotBoxed) {
  TriangleMesh rail = MakeGrid({-2, 0, 0.5f}, {4, 0, 0}, {0, 0, 0.1f}, 600);
  const auto scan = ScanTarget::Prepare(rail);
  ASSERT_TRUE(scan.ok());
  const auto box = BoxAround(**scan, {0, 0, 0.55}, {});
  ASSERT_FALSE(box.ok());
  EXPECT_THAT(box.error().message, HasSubstr("hangs together"));
}

/// Clicks on what of each given object lies highest, and compares with the box of the given model.
TEST(BoxAroundKitchen, FitsTheGivenObjects) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto kitchen = *shared / "data/kitchen";
  const auto mesh = ReadMesh(kitchen / "scene.ply");
  const auto truth = ReadGroundTruth(kitchen / "ground_truth.json");
  const auto models = ModelDatabase::Load(kitchen / "models");
  ASSERT_TRUE(mesh.ok() && truth.ok() && models.ok());
  const auto scan = *ScanTarget::Prepare(*mesh);
  BoxSurroundings known;
  known.up_in_scan = -truth->gravity_in_world;
  const auto floor = FindFloor(*scan, {{}, known.up_in_scan});
  ASSERT_TRUE(floor.ok());
  known.floor_in_scan = (Eigen::Vector4d() << floor->up_in_scan, floor->offset_m).finished();
  const UprightFrame frame(truth->gravity_in_world);
  int fitted = 0, close = 0;
  for (const GroundTruthInstance& instance : truth->instances) {
    const CadModel& model = (*models)->model(*(*models)->Find(instance.model));
    Vector3d highest(0, 0, -1e9);
    for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
      const Vector3d at = instance.world_from_object * vertex.cast<double>();
      if (known.up_in_scan.dot(at) > known.up_in_scan.dot(highest) || highest.z() < -1e8)
        highest = at;
    }
    const auto box = BoxAround(*scan, highest, known);
    const Vector3d size = model.bounds.sizes().cast<double>();
    if (!box.ok()) {
      std::printf("%s: %s\n", instance.id.c_str(), box.error().message.c_str());
      continue;
    }
    ++fitted;
    const Eigen::Matrix3d box_from_scan =
        frame.WorldFromObjectRotation(box->azimuth_rad).transpose();
    Eigen::AlignedBox3d bounds;
    for (const Eigen::Vector3f& vertex : model.mesh.vertices)
      bounds.extend(Vector3d(box_from_scan * (instance.world_from_object * vertex.cast<double>())));
    const double off_m = (bounds.sizes() - box->size_m).cwiseAbs().maxCoeff();
    close += off_m < 0.1;
    std::printf("%s (%.2f x %.2f x %.2f m): %.2f x %.2f x %.2f m, at most %.2f m off the model\n",
                instance.id.c_str(), size.x(), size.y(), size.z(), box->size_m.x(), box->size_m.y(),
                box->size_m.z(), off_m);
  }
  std::printf("%d of %zu fitted, %d of them within 10 cm\n", fitted, truth->instances.size(),
              close);
  EXPECT_GE(close, 4);
}

}  // namespace
}  // namespace plumbline
