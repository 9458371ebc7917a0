// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/street.h"

#include <gtest/gtest.h>

#include <map>

#include "engine/synthetic/cars.h"
#include "engine/synthetic/ray_tracer.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

Eigen::Vector3f SizeOf(const PaintedMesh& mesh) {
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : mesh.vertices) bounds.extend(vertex);
  return bounds.sizes();
}

TEST(Cars, StandOnTheRoadAndHaveTheMeasuresTheyWereGiven) {
  for (const CarKind& kind : CarKinds()) {
    const PaintedBody body = CarBody(kind.shape, {});
    Eigen::AlignedBox3f bounds;
    for (const Vector3f& vertex : body.mesh.vertices) bounds.extend(vertex);
    EXPECT_NEAR(bounds.min().z(), 0, 1e-5) << kind.name;
    EXPECT_NEAR(bounds.max().z(), kind.shape.height, 0.01) << kind.name;
    // Plates stand out by some centimetres, mirrors by some 20 on each side.
    EXPECT_NEAR(bounds.sizes().x(), kind.shape.length, 0.08) << kind.name;
    EXPECT_GT(bounds.sizes().y(), kind.shape.width) << kind.name;
    EXPECT_LT(bounds.sizes().y(), kind.shape.width + 0.4) << kind.name;
    EXPECT_NEAR(bounds.center().x(), 0, 1e-5) << kind.name;
    EXPECT_NEAR(bounds.center().y(), 0, 1e-5) << kind.name;
  }
}

TEST(Cars, AreSolidsWhoseFacesLookOutwards) {
  // By the divergence theorem the flux of x through the surface is the volume: positive, and that
  // of a body which fills most of its box, only if faces turn outwards.
  for (const CarKind& kind : CarKinds()) {
    const PaintedBody body = CarBody(kind.shape, {});
    double volume = 0;
    for (const Eigen::Vector3i& t : body.mesh.triangles) {
      const auto at = [&](int k) {
        return body.mesh.vertices[static_cast<std::size_t>(t[k])].cast<double>();
      };
      volume += at(0).dot(at(1).cross(at(2))) / 6;
    }
    const Vector3f size = SizeOf(body.mesh);
    EXPECT_GT(volume, 0.45 * size.prod()) << kind.name;
    EXPECT_LT(volume, 0.9 * size.prod()) << kind.name;
    for (std::size_t i = 0; i < body.mesh.normals.size(); ++i)
      EXPECT_NEAR(body.mesh.normals[i].norm(), 1, 1e-4);
  }
}

TEST(Cars, OfTheFamilyDifferAndAreNearestToTheirLikes) {
  for (std::size_t i = 0; i < CarKinds().size(); ++i)
    EXPECT_EQ(NearestKind(CarKinds()[i].shape), i);
  Random random({.seed = 3});
  double least = 1e9, most = 0;
  for (int i = 0; i < 200; ++i) {
    const CarShape shape = DrawCar(random);
    const double off = OutlineDifference(shape, CarKinds()[NearestKind(shape)].shape);
    least = std::min(least, off);
    most = std::max(most, off);
    EXPECT_GT(shape.length, 3.2);
    EXPECT_LT(shape.length, 6);
    CarBody(shape, {});  // none is refused
  }
  EXPECT_GT(least, 0.002) << "none is the generic shape itself";
  EXPECT_LT(most, 0.6) << "each has a generic shape that is like it";
}

TEST(Cars, OutlineDifferenceIsZeroForItselfAndGrowsWithHeight) {
  CarShape shape = CarKinds()[1].shape, higher = shape;
  EXPECT_EQ(OutlineDifference(shape, shape), 0);
  higher.width += 0.1f;
  EXPECT_NEAR(OutlineDifference(shape, higher), 0.05, 1e-6);
}

SyntheticOptions OptionsOf(SyntheticScene scene, std::uint64_t seed) {
  SyntheticOptions options = OptionsFor(scene);
  options.seed = seed;
  return options;
}

class Streets : public testing::TestWithParam<SyntheticScene> {};

TEST_P(Streets, HaveParkedCarsThatStandFreeAndOthersThatMove) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Result<Room> room = FurnishRoom(OptionsOf(GetParam(), seed));
    ASSERT_TRUE(room.ok()) << room.error().message;
    int parked = 0, moving = 0;
    std::vector<Footprint> places;
    for (const RoomInstance& instance : room->instances) {
      EXPECT_EQ(instance.category, "car");
      EXPECT_TRUE(std::any_of(room->catalogue.begin(), room->catalogue.end(),
                              [&](const auto& model) { return model.name == instance.model; }));
      const auto right =
          std::find_if(room->right_catalogue.begin(), room->right_catalogue.end(),
                       [&](const auto& model) { return model.name == instance.right_model; });
      ASSERT_NE(right, room->right_catalogue.end());
      ASSERT_TRUE(instance.size_m.has_value());
      EXPECT_LT((SizeOf(right->body.mesh).cast<double>() - *instance.size_m).norm(), 1e-4);
      moving += instance.moves();
      parked += !instance.moves();
      if (!instance.moves())
        places.push_back(FootprintOf(right->body.mesh, instance.room_from_object));
    }
    EXPECT_GE(parked, 15);
    EXPECT_GE(moving, 4);
    for (std::size_t a = 0; a < places.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const Eigen::Vector2d off = places[a].center - places[b].center;
        EXPECT_TRUE(std::abs(off.x()) > places[a].half_size.x() + places[b].half_size.x() ||
                    std::abs(off.y()) > 3);
      }
    }
    EXPECT_EQ(StillParts(*room).size() + static_cast<std::size_t>(moving), room->parts.size());
  }
}

TEST_P(Streets, ArePassedAtAnEvenPaceWithTheHorizonInView) {
  const bool drives = GetParam() == SyntheticScene::kStreet;
  const SyntheticOptions options = OptionsOf(GetParam(), 4);
  const Result<Room> room = FurnishRoom(options);
  ASSERT_TRUE(room.ok());
  const Result<Walk> walk = Walk::Plan(*room, options.seed, options.rate_hz);
  ASSERT_TRUE(walk.ok());
  for (int frame = 0; frame + 1 < options.frames; ++frame) {
    const Eigen::Isometry3d now = walk->RoomFromCam(frame / options.rate_hz),
                            next = walk->RoomFromCam((frame + 1) / options.rate_hz);
    EXPECT_GT(Clearance(*room, now.translation().head<2>()), 0.25);
    const double speed = (next.translation() - now.translation()).norm() * options.rate_hz;
    EXPECT_GT(speed, drives ? 6.5 : 1.0);
    EXPECT_LT(speed, drives ? 15.5 : 1.8);
    EXPECT_NEAR(now.translation().z(), *room->camera_height_m, 0.06);
    EXPECT_GT(now.linear().col(2).x(), 0.85) << "it looks along the street";
  }
}

INSTANTIATE_TEST_SUITE_P(Outdoors, Streets,
                         testing::Values(SyntheticScene::kStreet, SyntheticScene::kPavement),
                         [](const auto& tested) { return std::string(NameOf(tested.param)); });

TEST(Street, LastsAMinuteAtMost) {
  SyntheticOptions options = OptionsOf(SyntheticScene::kStreet, 1);
  options.frames = 601;
  ASSERT_EQ(options.Validate().size(), 1U);
  EXPECT_NE(options.Validate().front().find("minute"), std::string::npos);
  options.rate_hz = 20;
  EXPECT_TRUE(options.Validate().empty());
}

/// A ball-like box that moves over a plate, under a sun at the zenith.
class MovingThings : public testing::Test {
 protected:
  void SetUp() override {
    RoomPart plate;
    AddQuad(plate.body.mesh, plate.body.Paint({}), {-5, -5, 0}, {10, 0, 0}, {0, 10, 0});
    plate.light_spacing_m = 0.5f;
    room_.parts.push_back(plate);
    RoomPart box;
    AddBox(box.body.mesh, box.body.Paint({.color = {0.9f, 0.1f, 0.1f}}),
           {.center = {0, 0, 0.5f}, .size = {1, 1, 1}});
    box.instance = 1;
    box.velocity_m_s = {2, 0, 0};
    room_.parts.push_back(box);
    RoomInstance instance;
    instance.velocity_m_s = box.velocity_m_s;
    room_.instances.push_back(instance);
    room_.sun = SunLight{Vector3f::UnitZ(), Vector3f::Constant(2), 0.01f};
    room_.sky = SkyLight{};
    // From 8 m above, x of the room to the right.
    room_from_cam_.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    room_from_cam_.translation() << 0, 0, 8;
  }
  Shutter At(double t_s) const {
    Camera camera;
    camera.pinhole = camera_;
    return Shutter([this](double) { return room_from_cam_; }, t_s, 0, camera);
  }

  Room room_;
  Eigen::Isometry3d room_from_cam_ = Eigen::Isometry3d::Identity();
  PinholeCamera camera_{161, 161, 100, 100, 80, 80};
};

TEST_F(MovingThings, ShowWhereTheyAreAndHideWhatIsBehindThem) {
  const auto tracer = RayTracer::Create(room_, {4, 4}, {});
  ASSERT_TRUE(tracer.ok());
  for (const double t_s : {0.0, 1.0}) {
    const SurfaceMaps maps = (*tracer)->Look(camera_, At(t_s));
    for (const double x : {0.0, 2.0}) {
      const int u = static_cast<int>(std::lround(80 + 100 * x / 7));
      const bool there = x == 2 * t_s;
      EXPECT_EQ(maps.instance.at<std::uint16_t>(80, u), there ? 1 : 0);
      EXPECT_NEAR(maps.depth.at<float>(80, u), there ? 7 : 8, 0.01);
      EXPECT_EQ(maps.surface.at<int>(80, u), there ? 1 : 0);
    }
  }
}

TEST_F(MovingThings, CastTheirShadowWhereTheyAre) {
  room_.sun->to_sun = Vector3f(-1, 0, 1).normalized();  // the shadow falls towards +x
  const auto tracer = RayTracer::Create(room_, {16, 4}, {});
  ASSERT_TRUE(tracer.ok());
  const auto light_at = [&](const cv::Mat& picture, double x) {
    const auto& pixel = picture.at<cv::Vec3f>(80, static_cast<int>(std::lround(80 + 100 * x / 8)));
    return (pixel[0] + pixel[1] + pixel[2]) / 3;
  };
  const cv::Mat before = (*tracer)->Photograph(camera_, At(0), 1, 1, 0),
                after = (*tracer)->Photograph(camera_, At(1.5), 1, 1, 0);
  EXPECT_LT(light_at(before, 1.0), 0.6f * light_at(after, 1.0));
  EXPECT_LT(light_at(after, 4.0), 0.6f * light_at(before, 4.0));
}

}  // namespace
}  // namespace plumbline
