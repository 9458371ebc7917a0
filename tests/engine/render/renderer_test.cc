// SPDX-License-Identifier: Apache-2.0
#include "engine/render/renderer.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>

#include "engine/models/model_database.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d Pose(const Vector3d& translation, double angle = 0,
                const Vector3d& axis = Vector3d::UnitY()) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translate(translation).rotate(Eigen::AngleAxisd(angle, axis.normalized()));
  return pose;
}

enum class DrawnBy { kOpenGl, kProcessor };

class RendererTest : public testing::TestWithParam<DrawnBy> {
 protected:
  void SetUp() override {
    options_.contour = true;
    if (GetParam() == DrawnBy::kProcessor) {
      renderer_ = Renderer::CreateOnProcessor();
      return;
    }
    Result<std::unique_ptr<RenderContext>> context = RenderContext::CreateHeadless();
    ASSERT_TRUE(context.ok()) << context.error().message;
    context_ = std::move(*context);
    Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*context_);
    ASSERT_TRUE(renderer.ok()) << renderer.error().message;
    renderer_ = std::move(*renderer);
  }

  RenderedMaps Both(const std::vector<TriangleMesh>& meshes,
                    const std::vector<RenderInstance>& instances, const PinholeCamera& camera) {
    std::vector<const TriangleMesh*> pointers;
    std::vector<RenderInstance> uploaded = instances;
    std::vector<int> handles;
    for (const TriangleMesh& mesh : meshes) {
      pointers.push_back(&mesh);
      handles.push_back(renderer_->AddMesh(mesh));
    }
    for (RenderInstance& instance : uploaded)
      instance.mesh = handles.at(static_cast<std::size_t>(instance.mesh));
    options_.contour_pass = ContourPass::kProcessor;
    const cv::Mat by_processor = renderer_->Render(camera, uploaded, options_).contour;
    options_.contour_pass = ContourPass::kShader;
    RenderedMaps maps = renderer_->Render(camera, uploaded, options_);
    EXPECT_LE(cv::countNonZero(maps.contour != by_processor), 2)
        << "shader and processor follow one rule";
    ExpectSame(maps, RayCast(camera, pointers, instances, options_));
    return maps;
  }

  /// Equal away from contours, where a hair's breadth decides which surface a pixel centre hits.
  void ExpectSame(const RenderedMaps& gl, const RenderedMaps& cpu) {
    cv::Mat doubtful;
    cv::dilate(cpu.contour, doubtful, cv::Mat());
    int compared = 0, depth_differs = 0, id_differs = 0, contour_differs = 0;
    for (int y = 0; y < gl.depth.rows; ++y) {
      for (int x = 0; x < gl.depth.cols; ++x) {
        contour_differs += gl.contour.at<uchar>(y, x) != cpu.contour.at<uchar>(y, x);
        if (doubtful.at<uchar>(y, x) != 0) continue;
        ++compared;
        const float a = gl.depth.at<float>(y, x), b = cpu.depth.at<float>(y, x);
        depth_differs += std::abs(a - b) > 1e-3f * std::max(a, b);
        id_differs += gl.id.at<ushort>(y, x) != cpu.id.at<ushort>(y, x);
      }
    }
    EXPECT_LE(depth_differs, 0.001 * compared);
    EXPECT_EQ(id_differs, 0);
    EXPECT_LE(contour_differs, 2 + 0.02 * cv::countNonZero(cpu.contour));
    if (!gl.second_id.empty()) {
      EXPECT_LE(cv::countNonZero(gl.second_id != cpu.second_id),
                0.001 * static_cast<double>(gl.id.total()));
    }
  }

  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<Renderer> renderer_;
  RenderOptions options_;
  PinholeCamera camera_{320, 240, 260, 270, 141.3, 128.8};
};

TEST_P(RendererTest, AgreesWithRayCasting) {
  options_.second_layer = true;
  const std::vector<TriangleMesh> meshes = {MakeBox({-0.3f, -0.4f, -0.2f}, {0.3f, 0.4f, 0.2f}),
                                            MakeSphere(0.35f, 24),
                                            MakeParallelogram({-5, 1, 1}, {10, 0, 0}, {0, 0, 9})};
  const RenderedMaps maps = Both(meshes,
                                 {{0, Pose({-0.2, 0.1, 2}, 0.7, {1, 2, 3}), 7},
                                  {1, Pose({0.2, 0.2, 2.6}), 300},
                                  {0, Pose({0.9, -0.3, 3}, 1.9, {-1, 1, 0}), 65535},
                                  {2, Pose({0, 0, 0}), 2}},
                                 camera_);
  const std::set<int> ids(maps.id.begin<ushort>(), maps.id.end<ushort>());
  EXPECT_EQ(ids, (std::set<int>{0, 2, 7, 300, 65535}));
}

TEST_P(RendererTest, OffCentrePrincipalPointPutsCornersWhereTheyProject) {
  const PinholeCamera camera{200, 150, 180, 190, 31.7, 118.2};
  const TriangleMesh box = MakeBox({-0.1f, -0.5f, 2}, {0.7f, 0.05f, 2.5f});
  const RenderedMaps maps = Both({box}, {{0, Isometry3d::Identity(), 1}}, camera);
  // Of the front face, seen squarely: exactly the pixel centres between the projected corners.
  const Eigen::Vector2d low = camera.Project({-0.1, -0.5, 2}),
                        high = camera.Project({0.7, 0.05, 2});
  const cv::Mat front = (maps.depth > 1.9f) & (maps.depth < 2.0001f);
  const cv::Rect box_px = cv::boundingRect(front);
  EXPECT_EQ(box_px.x, static_cast<int>(std::ceil(low.x())));
  EXPECT_EQ(box_px.y, static_cast<int>(std::ceil(low.y())));
  EXPECT_EQ(box_px.br().x - 1, static_cast<int>(std::floor(high.x())));
  EXPECT_EQ(box_px.br().y - 1, static_cast<int>(std::floor(high.y())));
  EXPECT_EQ(cv::countNonZero(front), box_px.area());
}

TEST_P(RendererTest, ClipsTrianglesAtTheNearPlane) {
  // A floor that runs from behind the camera to in front of it.
  const std::vector<TriangleMesh> meshes = {
      MakeParallelogram({-9, 0.8f, -7}, {18, 0, 0}, {0, 0, 13})};
  const RenderedMaps maps = Both(meshes, {{0, Isometry3d::Identity(), 1}}, camera_);
  const int last_row = camera_.height - 1;
  const double expected = 0.8 / camera_.Bearing({0.0, static_cast<double>(last_row)}).y();
  EXPECT_NEAR(maps.depth.at<float>(last_row, 100), expected, 1e-3 * expected);
  double nearest = 0;
  cv::minMaxLoc(maps.depth, &nearest, nullptr, nullptr, nullptr, maps.depth > 0);
  EXPECT_GE(nearest, options_.near_m);
}

TEST_P(RendererTest, CutsAwayWhatIsNearerThanTheNearPlane) {
  options_.near_m = 1.0;
  const std::vector<TriangleMesh> meshes = {MakeBox({-0.2f, -0.2f, 0.5f}, {0.2f, 0.2f, 3})};
  const RenderedMaps maps = Both(meshes, {{0, Isometry3d::Identity(), 1}}, camera_);
  // Through the missing front one sees the inside of the far wall.
  EXPECT_NEAR(maps.depth.at<float>(129, 141), 3.0, 3e-3);
}

TEST_P(RendererTest, DrawsNothingOfObjectsBehindOrBesideTheCamera) {
  const int box = renderer_->AddMesh(MakeBox({-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f}));
  const int nothing = renderer_->AddMesh(TriangleMesh{});
  const std::vector<RenderInstance> instances = {{box, Pose({0, 0, -2}), 1},
                                                 {box, Pose({9, 0, 2}), 2},
                                                 {box, Pose({0, -9, 2}), 3},
                                                 {nothing, Pose({0, 0, 2}), 4}};
  const RenderedMaps maps = renderer_->Render(camera_, instances, options_);
  EXPECT_EQ(cv::countNonZero(maps.id), 0);
  EXPECT_EQ(cv::countNonZero(maps.depth), 0);
  EXPECT_EQ(cv::countNonZero(maps.contour), 0);
}

TEST_P(RendererTest, ContourOfASphereIsACircleOfKnownRadius) {
  const PinholeCamera camera{400, 400, 500, 500, 199.5, 199.5};
  const double distance = 2.0, radius = 0.5;
  const RenderedMaps maps =
      Both({MakeSphere(static_cast<float>(radius), 90)}, {{0, Pose({0, 0, distance}), 1}}, camera);
  const double expected = camera.fx * radius / std::sqrt(distance * distance - radius * radius);
  std::vector<cv::Point> pixels;
  cv::findNonZero(maps.contour, pixels);
  ASSERT_GT(pixels.size(), 600u);
  std::set<int> directions;
  for (const cv::Point& pixel : pixels) {
    const double x = pixel.x - camera.cx, y = pixel.y - camera.cy;
    EXPECT_NEAR(std::hypot(x, y), expected - 0.5, 1.0);
    EXPECT_LE(std::hypot(x, y), expected) << "contour pixels lie inside the object";
    directions.insert(static_cast<int>(std::lround(std::atan2(y, x) * 180 / 3.14159265)));
  }
  EXPECT_GE(directions.size(), 360u);
}

TEST_P(RendererTest, GrazingFloorHasNoInteriorContour) {
  const PinholeCamera camera{320, 240, 300, 300, 160, 60};
  const RenderedMaps maps = Both({MakeParallelogram({-40, 1.2f, 0.5f}, {80, 0, 0}, {0, 0, 24.5f})},
                                 {{0, Isometry3d::Identity(), 1}}, camera);
  cv::Mat rows;
  cv::reduce(maps.contour, rows, 1, cv::REDUCE_MAX);
  EXPECT_EQ(cv::countNonZero(rows), 1) << "only the far end, against nothing";
}

TEST_P(RendererTest, BorderOfAnOpenMeshInsideItsSurfaceGivesNoContour) {
  // A board, and a centimetre in front of it a flap of the same open mesh, both wound the other way
  // round.
  TriangleMesh board = MakeParallelogram({-0.5f, -0.5f, 2}, {0, 1, 0}, {1, 0, 0});
  Append(MakeParallelogram({-0.1f, -0.1f, 1.99f}, {0, 0.2f, 0}, {0.2f, 0, 0}), board);
  const RenderedMaps maps = Both({board}, {{0, Isometry3d::Identity(), 1}}, camera_);
  EXPECT_GT(cv::countNonZero((maps.depth > 0) & (maps.depth < 1.995f)), 400);
  const cv::Rect inside(100, 80, 80, 90);
  EXPECT_EQ(cv::countNonZero(maps.contour(inside)), 0);
  EXPECT_GT(cv::countNonZero(maps.contour), 200);
}

TEST_P(RendererTest, SecondLayerIsTheNearestSurfaceOfAnotherObject) {
  options_.second_layer = true;
  // Behind the front wall of box 1 come its own back wall and then box 2.
  const RenderedMaps maps = Both(
      {MakeBox({-0.2f, -0.2f, 2}, {0.2f, 0.2f, 2.4f}), MakeBox({-0.5f, -0.5f, 3}, {0.5f, 0.5f, 4})},
      {{0, Isometry3d::Identity(), 1}, {1, Isometry3d::Identity(), 2}}, camera_);
  EXPECT_EQ(maps.id.at<ushort>(129, 141), 1);
  EXPECT_EQ(maps.second_id.at<ushort>(129, 141), 2);
  EXPECT_NEAR(maps.second_depth.at<float>(129, 141), 3.0, 1e-3);
  const Eigen::Vector2d beside = camera_.Project({0.4, 0.4, 3});
  EXPECT_EQ(maps.id.at<ushort>(static_cast<int>(beside.y()), static_cast<int>(beside.x())), 2);
  EXPECT_EQ(maps.second_id.at<ushort>(static_cast<int>(beside.y()), static_cast<int>(beside.x())),
            0);
}

TEST(ProcessorRendererTest, TellsTheLuminanceOfBothLayers) {
  const auto renderer = Renderer::CreateOnProcessor();
  TriangleMesh near = MakeBox({-0.2f, -0.2f, 2}, {0.2f, 0.2f, 2.4f});
  near.colors.assign(near.vertices.size(), {51, 51, 51});
  TriangleMesh far = MakeBox({-0.5f, -0.5f, 3}, {0.5f, 0.5f, 4});
  far.colors.assign(far.vertices.size(), {255, 0, 0});
  const TriangleMesh bare = MakeBox({-0.6f, -0.9f, 5}, {0.6f, 0.9f, 6});
  std::vector<RenderInstance> instances;
  for (const TriangleMesh& mesh : {near, far, bare}) {
    const int handle = renderer->AddMesh(mesh);
    instances.push_back({handle, Isometry3d::Identity(), 7 + handle});
  }
  const PinholeCamera camera{320, 240, 260, 270, 159.5, 119.5};
  RenderOptions options;
  options.second_layer = true;
  EXPECT_TRUE(renderer->Render(camera, instances, options).luminance.empty()) << "not asked for";
  options.luminance = true;
  const RenderedMaps maps = renderer->Render(camera, instances, options);
  const auto at = [](const cv::Mat& map, int y) { return static_cast<int>(map.at<uchar>(y, 159)); };
  EXPECT_EQ(at(maps.luminance, 120), 51);  // of 254, as 51 of 255
  EXPECT_EQ(at(maps.second_luminance, 120), 76) << ".299 of 254";
  const int above_near = 120 - 40, above_far = 120 - 46;
  EXPECT_EQ(at(maps.luminance, above_near), 76);
  EXPECT_EQ(at(maps.second_luminance, above_near), kUnknownLuminance8) << "without colours";
  EXPECT_EQ(at(maps.luminance, above_far), kUnknownLuminance8);
  EXPECT_EQ(maps.id.at<ushort>(above_far, 159), 9);
  EXPECT_EQ(at(maps.luminance, 2), kUnknownLuminance8) << "nothing there";
  EXPECT_EQ(maps.id.at<ushort>(2, 159), 0);
}

TEST_P(RendererTest, ChangesImageSizeBetweenCalls) {
  const int sphere = renderer_->AddMesh(MakeSphere(0.4f, 16));
  const RenderInstance instance{sphere, Pose({0, 0, 2}), 5};
  for (const double factor : {1.0, 0.5, 1.0, 2.0}) {
    const RenderedMaps maps =
        renderer_->Render(camera_.Scaled(factor), std::span(&instance, 1), options_);
    EXPECT_EQ(maps.depth.cols, static_cast<int>(camera_.width * factor));
    EXPECT_NEAR(cv::countNonZero(maps.id) / (factor * factor),
                260 * 270 * 3.14159 * 0.16 / 4 * 1.04, 700);
  }
}

TEST_P(RendererTest, LeavesNoPixelOutBetweenTrianglesThatShareAnEdge) {
  const PinholeCamera camera{640, 480, 600, 600, 319.5, 239.5};
  const int sphere = renderer_->AddMesh(MakeSphere(0.5f, 200));
  for (const double distance : {0.9, 1.7, 4.0}) {
    const RenderInstance instance{sphere, Pose({0.03, -0.02, distance}, 0.3, {1, 2, 3}), 9};
    const RenderedMaps maps = renderer_->Render(camera, std::span(&instance, 1), options_);
    const double radius = camera.fx * 0.5 / std::sqrt(distance * distance - 0.25);
    cv::Mat inside = cv::Mat::zeros(maps.id.size(), CV_8U);
    const Eigen::Vector2d middle = camera.Project({0.03, -0.02, distance});
    cv::circle(inside, {static_cast<int>(middle.x()), static_cast<int>(middle.y())},
               static_cast<int>(0.9 * radius), 255, cv::FILLED);
    EXPECT_EQ(cv::countNonZero((maps.id == 0) & inside), 0) << distance;
    EXPECT_GT(cv::countNonZero(maps.id), 3000) << distance;
  }
}

INSTANTIATE_TEST_SUITE_P(, RendererTest, testing::Values(DrawnBy::kOpenGl, DrawnBy::kProcessor),
                         [](const auto& drawn) {
                           return drawn.param == DrawnBy::kOpenGl ? "OpenGl" : "Processor";
                         });

TEST(RenderersTest, DrawTheSamePixels) {
  auto context = RenderContext::CreateHeadless();
  ASSERT_TRUE(context.ok()) << context.error().message;
  const std::unique_ptr<Renderer> by_gl = Renderer::Create(**context).value();
  const std::unique_ptr<Renderer> by_processor = Renderer::CreateOnProcessor();
  for (const TriangleMesh& mesh :
       {MakeBox({-0.4f, -0.3f, -0.2f}, {0.4f, 0.3f, 0.2f}), MakeSphere(0.35f, 40),
        MakeBox({-0.02f, -1, -0.5f}, {0.02f, 1, 0.5f})}) {
    by_gl->AddMesh(mesh);
    by_processor->AddMesh(mesh);
  }
  const PinholeCamera camera{320, 240, 262, 262, 159.5, 119.5};
  RenderOptions options;
  options.contour = options.second_layer = true;
  int ids = 0, second_ids = 0, contours = 0;
  for (int scene = 0; scene < 30; ++scene) {
    std::vector<RenderInstance> instances;
    for (int i = 0; i < 6; ++i) {
      const double turn = scene + 1.7 * i;
      instances.push_back(
          {i % 3,
           Pose({1.5 * std::sin(2 * turn), std::sin(3 * turn), 3 + 2 * std::sin(5 * turn)}, turn,
                {std::sin(turn), 1, 0.3}),
           i + 1, 1 + 0.1 * std::sin(turn)});
    }
    const RenderedMaps gl = by_gl->Render(camera, instances, options);
    const RenderedMaps processor = by_processor->Render(camera, instances, options);
    ids += cv::countNonZero(gl.id != processor.id);
    second_ids += cv::countNonZero(gl.second_id != processor.second_id);
    contours += cv::countNonZero(gl.contour != processor.contour);
  }
  // Of 2.3 million pixels: those whose centre is within rounding of an edge.
  EXPECT_LE(ids, 100);
  EXPECT_LE(second_ids, 100);
  EXPECT_LE(contours, 200);
  RecordProperty("ids", ids);
  RecordProperty("second_ids", second_ids);
  RecordProperty("contours", contours);
}

TEST(RenderContextTest, AdoptsTheCurrentContextAndTwoContextsLiveSideBySide) {
  auto context = RenderContext::CreateHeadless();
  ASSERT_TRUE(context.ok()) << context.error().message;
  (*context)->MakeCurrent();
  Result<std::unique_ptr<RenderContext>> adopted = RenderContext::AdoptCurrent();
  ASSERT_TRUE(adopted.ok()) << adopted.error().message;
  EXPECT_EQ((*adopted)->Description(), (*context)->Description());
  std::jthread other([] {
    auto context = RenderContext::CreateHeadless();
    ASSERT_TRUE(context.ok()) << context.error().message;
    auto renderer = Renderer::Create(**context);
    ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  });
}

TEST_P(RendererTest, RefusesUnknownMeshesAndIdZero) {
  const RenderInstance unknown{3, Isometry3d::Identity(), 1};
  EXPECT_THROW(renderer_->Render(camera_, std::span(&unknown, 1), options_), ContractError);
  const RenderInstance no_id{renderer_->AddMesh(MakeSphere(1, 4)), Pose({0, 0, 3}), 0};
  EXPECT_THROW(renderer_->Render(camera_, std::span(&no_id, 1), options_), ContractError);
}

TEST_P(RendererTest, AgreesWithRayCastingOnTheKitchenModels) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto database = ModelDatabase::Load(*shared / "data/kitchen/models");
  ASSERT_TRUE(database.ok());
  const TriangleMesh& chair = (*database)->model(*(*database)->Find("chair")).mesh;
  Isometry3d upright = Isometry3d::Identity();
  upright.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  Both({chair},
       {{0, Pose({0, 0.5, 2.2}, 0.4, {1, 0, 0}) * upright * Pose({0, 0, 0}, 2.1, Vector3d::UnitZ()),
         1}},
       camera_);
}

}  // namespace
}  // namespace plumbline
