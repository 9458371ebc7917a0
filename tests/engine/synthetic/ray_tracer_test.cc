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
    const std::vector<Isometry3d> poses = {pose_, pose_};
    const cv::Mat radiance = (*tracer)->Photograph(camera_, poses, 3, 5, 9);
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
  const std::vector<Isometry3d> poses = {pose_};
  const FilmOptions film{(*tracer)->exposure(), 3};
  const cv::Mat picture = DevelopFilm((*tracer)->Photograph(camera_, poses, 2, 1, 0), film);
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

TEST(LightMap, GivesTheLightOfASmallLampByTheInverseSquareLaw) {
  RoomPart floor;
  AddQuad(floor.body.mesh, floor.body.Paint({.color = {0, 0, 0}}), {-1, -1, 0}, {2, 0, 0},
          {0, 2, 0});
  const TracedScene scene(std::span(&floor, 1));
  const std::vector<AreaLight> lights = {
      {{-0.05f, -0.05f, 1.5f}, {0, 0.1f, 0}, {0.1f, 0, 0}, {1, 2, 3}}};
  const auto map = LightMap::Compute(scene, lights, std::nullopt, {16, 1}, {});
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
  const auto map = LightMap::Compute(scene, {}, sun, {16, 1}, {});
  ASSERT_TRUE(map.ok());
  EXPECT_NEAR(map->At(scene.Trace({0.1f, 0.1f, 0.3f}, {0, 0, -1})).y(), 0, 1e-6);
  EXPECT_NEAR(map->At(scene.Trace({0.6f, 0.1f, 0.3f}, {0, 0, -1})).y(), 1, 1e-3);
}

}  // namespace
}  // namespace plumbline
