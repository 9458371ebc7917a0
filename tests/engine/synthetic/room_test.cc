// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/room.h"

#include <gtest/gtest.h>

#include <numbers>

#include "engine/synthetic/traced_scene.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

SyntheticOptions OptionsOf(SyntheticScene scene, std::uint64_t seed) {
  SyntheticOptions options = OptionsFor(scene);
  options.seed = seed;
  return options;
}

/// Indoors; street_test.cc has the others.
class EveryScene : public testing::TestWithParam<int> {
 protected:
  SyntheticScene scene() const { return static_cast<SyntheticScene>(GetParam()); }
  /// The others are furnished in their own way.
  bool is_living_room() const {
    return scene() < SyntheticScene::kWall || scene() == SyntheticScene::kRates;
  }
};

/// Number of vertices of a that lie inside the solid b. Where solids overlap one enters twice
/// before leaving twice.
int VerticesInside(const TracedScene& a, const TracedScene& b) {
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : b.vertices()) bounds.extend(vertex);
  const Vector3f up = Vector3f(0.013f, 0.017f, 1).normalized();
  int count = 0;
  for (std::size_t i = 0; i < a.vertices().size(); ++i) {
    // Two millimetres inside its own body: things may touch.
    Vector3f from = a.vertices()[i] - 0.002f * a.ShadingNormalAt(static_cast<int>(i));
    if (!bounds.contains(from)) continue;
    int depth = 0;
    for (int step = 0; step < 60; ++step) {
      const TracedScene::Hit hit = b.Trace(from, up);
      if (!hit.valid()) break;
      depth += b.FaceNormal(hit.triangle).dot(up) > 0 ? 1 : -1;
      from += (hit.distance + 1e-5f) * up;
    }
    count += depth > 0;
  }
  return count;
}

TEST_P(EveryScene, HasObjectsThatDoNotInterpenetrate) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Result<Room> room = FurnishRoom(OptionsOf(scene(), seed));
    ASSERT_TRUE(room.ok()) << room.error().message;
    EXPECT_GE(room->instances.size(), 5u);
    EXPECT_LE(room->instances.size(), is_living_room() ? 8u : 20u);
    std::vector<std::unique_ptr<TracedScene>> bodies;
    for (const RoomPart& part : room->parts) {
      if (part.instance > 0) bodies.push_back(std::make_unique<TracedScene>(std::span(&part, 1)));
    }
    ASSERT_EQ(bodies.size(), room->instances.size());
    for (std::size_t a = 0; a < bodies.size(); ++a) {
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (a == b) continue;
        EXPECT_EQ(VerticesInside(*bodies[a], *bodies[b]), 0)
            << room->instances[a].id << " in " << room->instances[b].id << ", seed " << seed;
      }
    }
  }
}

TEST_P(EveryScene, IsWalkedThroughSmoothlyAndClearOfEverything) {
  for (const std::uint64_t seed : {1, 5, 6}) {
    const SyntheticOptions options = OptionsOf(scene(), seed);
    const Result<Room> room = FurnishRoom(options);
    ASSERT_TRUE(room.ok()) << room.error().message;
    const Result<Walk> walk = Walk::Plan(*room, seed, options.rate_hz);
    ASSERT_TRUE(walk.ok());
    constexpr double kStep = 1.0 / 30;
    double turned = 0;
    double last_direction = 0;
    for (int i = 0; i * kStep <= options.frames / options.rate_hz; ++i) {
      const Eigen::Isometry3d now = walk->RoomFromCam(i * kStep),
                              next = walk->RoomFromCam((i + 1) * kStep),
                              third = walk->RoomFromCam((i + 2) * kStep);
      const Eigen::Vector2d stand = now.translation().head<2>();
      EXPECT_GT(Clearance(*room, stand), 0.28);
      EXPECT_GT(now.translation().z(), 1.2);
      EXPECT_LT(now.translation().z(), 1.6);
      EXPECT_TRUE((now.linear().transpose() * now.linear()).isIdentity(1e-12));
      EXPECT_GT(now.linear().determinant(), 0);
      const double speed = (next.translation() - now.translation()).norm() / kStep;
      EXPECT_GT(speed, 0.2);
      EXPECT_LT(speed, 0.8);
      const Eigen::Vector3d acceleration =
          (third.translation() - 2 * next.translation() + now.translation()) / (kStep * kStep);
      EXPECT_LT(acceleration.norm(), 3);
      if (scene() != SyntheticScene::kBlur) {
        EXPECT_LT(Eigen::AngleAxisd(now.linear().transpose() * next.linear()).angle() / kStep, 1.0);
      }
      const Eigen::Vector2d from_focus = stand - room->walk.focus;
      const double direction = std::atan2(from_focus.y(), from_focus.x());
      if (i > 0) turned += std::remainder(direction - last_direction, 2 * std::numbers::pi);
      last_direction = direction;
    }
    if (room->walk.route.empty()) {
      EXPECT_GT(std::abs(turned), 2.75) << "about 180 degrees round the main group, seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene,
                         testing::Range(0, static_cast<int>(SyntheticScene::kStreet)),
                         [](const auto& tested) {
                           return std::string(NameOf(static_cast<SyntheticScene>(tested.param)));
                         });

TEST(Room, DiffersBySeedAndRepeatsForOne) {
  const Result<Room> first = FurnishRoom(OptionsOf(SyntheticScene::kRoom, 7)),
                     again = FurnishRoom(OptionsOf(SyntheticScene::kRoom, 7)),
                     other = FurnishRoom(OptionsOf(SyntheticScene::kRoom, 8));
  ASSERT_TRUE(first.ok() && again.ok() && other.ok());
  ASSERT_EQ(first->instances.size(), again->instances.size());
  for (std::size_t i = 0; i < first->instances.size(); ++i) {
    EXPECT_EQ(first->instances[i].model, again->instances[i].model);
    EXPECT_EQ(first->instances[i].room_from_object.matrix(),
              again->instances[i].room_from_object.matrix());
  }
  EXPECT_NE(first->instances[0].room_from_object.matrix(),
            other->instances[0].room_from_object.matrix());
  EXPECT_NE(first->size, other->size);
}

// What was drawn last shows whether all before it was drawn in one order. These rooms are GCC's, as
// the published figures are: compilers evaluate the arguments of a call in other orders.
TEST(Room, IsTheSameByEveryCompiler) {
  struct Last {
    SyntheticScene scene;
    const char* model;
    double x, y, cos_azimuth;
  };
  for (const Last& last :
       {Last{SyntheticScene::kRoom, "tv_wide", -3.344322, -0.040705, 0.997538},
        Last{SyntheticScene::kRows, "monitor_desk", 4.15, -0.150700, -0.999677},
        Last{SyntheticScene::kOffice, "plant_tall", 3.202817, 2.988268, -0.796547}}) {
    const Result<Room> room = FurnishRoom(OptionsOf(last.scene, 5));
    ASSERT_TRUE(room.ok());
    EXPECT_EQ(room->instances.back().model, last.model);
    const Eigen::Isometry3d& pose = room->instances.back().room_from_object;
    EXPECT_NEAR(pose.translation().x(), last.x, 1e-6);
    EXPECT_NEAR(pose.translation().y(), last.y, 1e-6);
    EXPECT_NEAR(pose.linear()(0, 0), last.cos_azimuth, 1e-6);
  }
}

TEST(Room, VariantShowsAChairWithoutTheArmRestsOfItsModel) {
  const Result<Room> room = FurnishRoom(OptionsOf(SyntheticScene::kVariant, 2));
  ASSERT_TRUE(room.ok());
  ASSERT_GT(room->main_instance, 0);
  const RoomInstance& chair = room->instances[static_cast<std::size_t>(room->main_instance - 1)];
  for (const RoomPart& part : room->parts) {
    if (part.instance != room->main_instance) continue;
    for (const FurnitureModel& model : room->catalogue) {
      if (model.name != chair.model) continue;
      EXPECT_LT(part.body.mesh.triangles.size(), model.body.mesh.triangles.size());
    }
  }
}

}  // namespace
}  // namespace plumbline
