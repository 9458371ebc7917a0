// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "engine/render/renderer.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

constexpr double kStep_m = 0.04;

struct Maps {
  cv::Mat depth = cv::Mat(40, 60, CV_32F, cv::Scalar(2.0));
  cv::Mat id = cv::Mat(40, 60, CV_16U, cv::Scalar(1));
};

TEST(Contour, LiesOnTheNearSideOfAStepAndNotOnTheImageBorder) {
  Maps maps;
  const cv::Rect front(20, 10, 15, 12);
  maps.depth(front).setTo(1.9);
  const cv::Mat contour = ContourOf(maps.depth, maps.id, kStep_m);
  cv::Mat expected(contour.size(), CV_8U, cv::Scalar(0));
  cv::rectangle(expected, front, cv::Scalar(255));
  EXPECT_EQ(cv::norm(contour, expected, cv::NORM_INF), 0.0);
}

TEST(Contour, AStepBelowTheThresholdIsNone) {
  Maps maps;
  maps.depth(cv::Rect(20, 10, 15, 12)).setTo(1.97);
  EXPECT_EQ(cv::countNonZero(ContourOf(maps.depth, maps.id, kStep_m)), 0);
}

TEST(Contour, SilhouetteIsThatOfTheNearerObjectHoweverSmallTheStep) {
  Maps maps;
  const cv::Rect front(20, 10, 15, 12);
  maps.depth(front).setTo(1.99);
  maps.id(front).setTo(2);
  const cv::Mat contour = ContourOf(maps.depth, maps.id, kStep_m);
  EXPECT_EQ(cv::countNonZero(contour), 2 * (15 + 12) - 4);
  EXPECT_EQ(cv::countNonZero(contour(front)), cv::countNonZero(contour));
}

TEST(Contour, ObjectThatFillsTheImageHasNone) {
  Maps maps;
  EXPECT_EQ(cv::countNonZero(ContourOf(maps.depth, maps.id, kStep_m)), 0);
}

TEST(Contour, GrazingPlaneHasNoInteriorContour) {
  // A floor 1.2 m below the camera up to 25 m away: far rows are half a metre of depth apart.
  const PinholeCamera camera{320, 240, 300, 300, 160, 60};
  const TriangleMesh floor = MakeParallelogram({-40, 1.2f, 0.5f}, {80, 0, 0}, {0, 0, 24.5f});
  const std::array<const TriangleMesh*, 1> meshes = {&floor};
  const RenderInstance instance{0, Eigen::Isometry3d::Identity(), 1};
  RenderOptions options;
  options.contour = true;
  const RenderedMaps maps = RayCast(camera, meshes, std::span(&instance, 1), options);
  cv::Mat rows;
  cv::reduce(maps.contour, rows, 1, cv::REDUCE_MAX);
  EXPECT_EQ(cv::countNonZero(rows), 1) << "only the far end, against nothing";
}

TEST(Contour, CreaseBetweenASquareAndAGrazingFaceIsNone) {
  // A table seen from just above its top: the front face meets the top, whose rows lie more than 4
  // cm apart.
  const PinholeCamera camera{320, 240, 300, 300, 160, 60};
  const TriangleMesh table = MakeBox({-1, 0.3f, 3}, {1, 0.8f, 6});
  const std::array<const TriangleMesh*, 1> meshes = {&table};
  const RenderInstance instance{0, Eigen::Isometry3d::Identity(), 1};
  RenderOptions options;
  options.contour = true;
  const RenderedMaps maps = RayCast(camera, meshes, std::span(&instance, 1), options);
  const int front_row = static_cast<int>(std::floor(camera.Project({0, 0.3, 3}).y()));
  ASSERT_GT(maps.depth.at<float>(front_row - 1, 160) - maps.depth.at<float>(front_row, 160),
            kStep_m);
  EXPECT_EQ(cv::countNonZero(maps.contour(cv::Rect(130, front_row - 4, 60, 9))), 0);
}

}  // namespace
}  // namespace plumbline
