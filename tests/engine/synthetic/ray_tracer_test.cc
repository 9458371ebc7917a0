// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/ray_tracer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numbers>

#include <opencv2/imgproc.hpp>

#include "engine/render/renderer.h"
#include "engine/synthetic/film.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3f;

constexpr LightQuality kQuickLight{4, 10};

/// A small camera in a room of the given seed.
class Pictures : public testing::Test {
 protected:
  void SetUp() override {
    options_.seed = 2;
    Result<Room> room = FurnishRoom(options_);
    ASSERT_TRUE(room.ok());
    room_ = std::move(*room);
    pose_ = Walk::Plan(room_, options_.seed, 30)->RoomFromCam(2.0);
  }

  SyntheticOptions options_;
  Room room_;
  Isometry3d pose_;
  PinholeCamera camera_{241, 127, 140, 141, 122.3, 60.8};
};

TEST_F(Pictures, DepthAndIdsEqualThoseOfTheReferenceRayCaster) {
  const auto tracer = RayTracer::Create(room_, kQuickLight, {});
  ASSERT_TRUE(tracer.ok());
  const SurfaceMaps maps = (*tracer)->Look(camera_, pose_);
  std::vector<TriangleMesh> meshes;
  std::vector<const TriangleMesh*> pointers;
  std::vector<RenderInstance> instances;
  meshes.reserve(room_.parts.size());
  for (const RoomPart& part : room_.parts) {
    TriangleMesh mesh;
    mesh.vertices = part.body.mesh.vertices;
    mesh.triangles = part.body.mesh.triangles;
    meshes.push_back(mesh);
    pointers.push_back(&meshes.back());
    instances.push_back({static_cast<int>(meshes.size()) - 1, pose_.inverse(),
                         part.instance > 0 ? part.instance : 1000});
  }
  const RenderedMaps reference = RayCast(camera_, pointers, instances, {});
  int different = 0;
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      const int id = reference.id.at<std::uint16_t>(y, x);
      const bool same =
          (id == 1000 ? 0 : id) == maps.instance.at<std::uint16_t>(y, x) &&
          std::abs(reference.depth.at<float>(y, x) - maps.depth.at<float>(y, x)) < 1e-3;
      different += !same;
    }
  }
  // Only rays that graze an edge may decide differently.
  EXPECT_LT(different, 0.001 * camera_.width * camera_.height);
}

TEST_F(Pictures, AreTheSameForAnyNumberOfThreads) {
  std::vector<cv::Mat> images, depths;
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto tracer = RayTracer::Create(room_, kQuickLight, {});
    ASSERT_TRUE(tracer.ok());
    const cv::Mat radiance = (*tracer)->Photograph(camera_, pose_, 3, 5, 9);
    const FilmOptions film{(*tracer)->exposure(), 3};
    images.push_back(ExposeSensor(DevelopFilm(radiance, film), film, 5, 9));
    depths.push_back((*tracer)->Look(camera_, pose_).depth);
  }
  EXPECT_EQ(cv::norm(images[0], images[1], cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(depths[0], depths[1], cv::NORM_INF), 0);
}

TEST_F(Pictures, UseTheRangeOfTheSensor) {
  const auto tracer = RayTracer::Create(room_, kQuickLight, {});
  ASSERT_TRUE(tracer.ok());
  const FilmOptions film{(*tracer)->exposure(), 3};
  const cv::Mat picture = DevelopFilm((*tracer)->Photograph(camera_, pose_, 2, 1, 0), film);
  cv::Scalar mean, spread;
  cv::meanStdDev(picture, mean, spread);
  EXPECT_GT(mean[1], 0.25);
  EXPECT_LT(mean[1], 0.75);
  EXPECT_GT(spread[1], 0.08);
}

TEST_F(Pictures, StopWhenAskedTo) {
  std::stop_source stop;
  stop.request_stop();
  const auto tracer = RayTracer::Create(room_, kQuickLight, {.stop = stop.get_token()});
  ASSERT_FALSE(tracer.ok());
  EXPECT_EQ(tracer.error().code, ErrorCode::kCancelled);
}

/// A camera that turns to the right about the vertical axis, at the origin; at 0 s it looks along
/// y.
Isometry3d Turning(double rate_rad_s, double t_s) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  pose.linear() =
      Eigen::AngleAxisd(-rate_rad_s * t_s, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
      pose.linear();
  return pose;
}

/// A dark room with one white pole, 8 cm wide, upright 2 m in front of the origin.
Room RoomWithAPole() {
  RoomPart pole;
  AddQuad(pole.body.mesh, pole.body.Paint({.color = {1, 1, 1}, .emission = 1}), {-0.04f, 2, -2},
          {0.08f, 0, 0}, {0, 0, 4});
  pole.instance = 1;
  Room room;
  room.parts.push_back(pole);
  room.lights.push_back({{-1, 0, 3}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}});
  return room;
}

TEST(RollingShutter, APoleLeansWhileTheCameraTurns) {
  const auto tracer = RayTracer::Create(RoomWithAPole(), {16, 20}, {});
  ASSERT_TRUE(tracer.ok());
  Camera camera;
  camera.pinhole = {320, 241, 300, 302, 160.3, 118.0};
  constexpr double kRate = 1.2;  // [rad/s]
  for (const double read_out_s : {0.0, 0.03, -0.03}) {
    camera.rolling_shutter_s = read_out_s;
    const Shutter shutter([](double t_s) { return Turning(kRate, t_s - 5); }, 5, 0.004, camera);
    const cv::Mat radiance = (*tracer)->Photograph(camera.pinhole, shutter, 16, 1, 0);
    const SurfaceMaps maps = (*tracer)->Look(camera.pinhole, shutter);
    double furthest_picture = 0, off_mask = 0;
    for (int y = 0; y < camera.pinhole.height; ++y) {
      double light = 0, moment = 0, pixels = 0, columns = 0;
      for (int x = 0; x < camera.pinhole.width; ++x) {
        const double value = radiance.at<cv::Vec3f>(y, x)[1];
        light += value;
        moment += value * x;
        const bool shows = maps.instance.at<std::uint16_t>(y, x) == 1;
        pixels += shows;
        columns += shows * x;
      }
      ASSERT_GT(light, 0);
      ASSERT_GT(pixels, 5);
      // A row is exposed at read_out * (row / 240 - 1/2), when the camera has turned to the right
      // by rate times that and the pole stands by as much to the left.
      const double angle = kRate * read_out_s * (y / 240.0 - 0.5);
      const double expected = camera.pinhole.cx - camera.pinhole.fx * std::tan(angle);
      furthest_picture = std::max(furthest_picture, std::abs(moment / light - expected));
      off_mask += std::abs(columns / pixels - expected) / camera.pinhole.height;
    }
    // Of 12 columns, 16 samples each, the outermost two are lit in part. A mask's are whole pixels,
    // of which a ray along the diagonal of the pole's two triangles may lack one.
    EXPECT_LT(furthest_picture, 0.2) << read_out_s;
    EXPECT_LT(off_mask, 0.35) << read_out_s;
  }
}

TEST(RollingShutter, APointIsSeenAtTheTimeOfItsRow) {
  Camera camera;
  camera.pinhole = {320, 241, 300, 302, 160.3, 118.0};
  camera.rolling_shutter_s = 0.03;
  const auto path = [](double t_s) {
    Isometry3d pose = Turning(1.2, t_s);
    pose.linear() =
        pose.linear() *
        Eigen::AngleAxisd(0.8 * (t_s - 0.4), Eigen::Vector3d::UnitX()).toRotationMatrix();
    pose.translation() << 0.5 * t_s, -0.3 * t_s, 0.2 * t_s;
    return pose;
  };
  const Shutter shutter(path, 0.4, 0, camera);
  for (const double height : {-0.5, 0.0, 0.4}) {
    const Eigen::Vector3d point(0.9, 1.8, height);
    const Isometry3d seen_from = shutter.Seeing(point);
    const double row = camera.pinhole.Project(seen_from.inverse() * point).y();
    const Isometry3d of_row = path(0.4 + 0.03 * (row / 240 - 0.5));
    EXPECT_LT((camera.pinhole.Project(of_row.inverse() * point) -
               camera.pinhole.Project(seen_from.inverse() * point))
                  .norm(),
              1e-3);
    EXPECT_GT((of_row.matrix() - path(0.4).matrix()).norm(), 1e-4);
  }
  EXPECT_EQ(shutter.Seeing({0, -3, 0}).matrix(), path(0.4).matrix());  // behind the camera
}

TEST(LightMap, GivesTheLightOfASmallLampByTheInverseSquareLaw) {
  RoomPart floor;
  AddQuad(floor.body.mesh, floor.body.Paint({.color = {0, 0, 0}}), {-1, -1, 0}, {2, 0, 0},
          {0, 2, 0});
  const TracedScene scene(std::span(&floor, 1));
  const std::vector<AreaLight> lights = {
      {{-0.05f, -0.05f, 1.5f}, {0, 0.1f, 0}, {0.1f, 0, 0}, {1, 2, 3}}};
  const auto map = LightMap::Compute(scene, {lights, {}, {}}, {16, 1}, {});
  ASSERT_TRUE(map.ok());
  for (const float x : {0.0f, 0.4f, 0.8f}) {
    const TracedScene::Hit hit = scene.Trace({x, 0.1f, 1}, {0, 0, -1});
    ASSERT_TRUE(hit.valid());
    const double distance = Eigen::Vector3d(x, 0.1, 1.5).norm(), cosine = 1.5 / distance;
    const double expected = 0.01 * cosine * cosine / (std::numbers::pi * distance * distance);
    EXPECT_NEAR(map->At(hit).x(), expected, 0.01 * expected);
    EXPECT_NEAR(map->At(hit).z(), 3 * expected, 0.03 * expected);
  }
}

TEST(LightMap, LeavesTheShadowOfAnOccluderDark) {
  std::array<RoomPart, 2> parts;
  AddQuad(parts[0].body.mesh, parts[0].body.Paint({.color = {0, 0, 0}}), {-1, -1, 0}, {2, 0, 0},
          {0, 2, 0});
  AddBox(parts[1].body.mesh, parts[1].body.Paint({.color = {0, 0, 0}}),
         {.center = {0, 0, 0.5f}, .size = {0.6f, 0.6f, 0.02f}});
  const TracedScene scene(parts);
  const SunLight sun{{0, 0, 1}, {1, 1, 1}, 0.01f};
  const auto map = LightMap::Compute(scene, {{}, sun, {}}, {16, 1}, {});
  ASSERT_TRUE(map.ok());
  EXPECT_NEAR(map->At(scene.Trace({0.1f, 0.1f, 0.3f}, {0, 0, -1})).y(), 0, 1e-6);
  EXPECT_NEAR(map->At(scene.Trace({0.6f, 0.1f, 0.3f}, {0, 0, -1})).y(), 1, 1e-3);
}

}  // namespace
}  // namespace plumbline
