// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/outline_projection.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/engine/annotation/checked_room.h"

namespace plumbline {
namespace {

std::shared_ptr<const OutlineModel> Prepared(const TriangleMesh& mesh) {
  return OutlineModel::Prepare(mesh).value();
}

/// Length of the lines of a kind [px].
double Length(const ModelOutline& outline, OutlineKind kind, bool hidden) {
  double length = 0;
  for (const OutlinePolyline& line : outline.lines) {
    if (line.kind != kind || line.hidden != hidden) continue;
    for (std::size_t i = 1; i < line.pixels.size(); ++i) {
      length += (line.pixels[i] - line.pixels[i - 1]).norm();
    }
  }
  return length;
}

double Distance(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm(); }

class BoxOutline : public testing::Test {
 protected:
  Eigen::Vector2d Pixel(double x, double y, double z) const {
    return camera_.Project(scan_from_cam_.inverse() * Eigen::Vector3d(x, y, z));
  }

  PinholeCamera camera_ = TestCamera();
  std::shared_ptr<const OutlineModel> box_ = Prepared(BoxMesh({0.6f, 0.4f, 0.5f}));
  Eigen::Isometry3d scan_from_cam_ = LookAt({2, 1.5, 1.4}, {0, 0, 0.25});
};

TEST_F(BoxOutline, IsTheHexagonAndThreeCreases) {
  const ModelOutline outline =
      ProjectOutline(*box_, Eigen::Isometry3d::Identity(), scan_from_cam_, camera_, {});
  const double x = 0.3, y = 0.2, z = 0.5;
  const Eigen::Vector2d hexagon[6] = {Pixel(x, -y, 0), Pixel(x, y, 0),   Pixel(-x, y, 0),
                                      Pixel(-x, y, z), Pixel(-x, -y, z), Pixel(x, -y, z)};
  double contour = 0, creases = 0;
  for (int i = 0; i < 6; ++i) contour += Distance(hexagon[i], hexagon[(i + 1) % 6]);
  for (const int i : {1, 3, 5}) creases += Distance(Pixel(x, y, z), hexagon[i]);
  // Lines end at most a sample early at each of their ends.
  EXPECT_NEAR(Length(outline, OutlineKind::kContour, false), contour, 8);
  EXPECT_NEAR(Length(outline, OutlineKind::kCrease, false), creases, 8);
  EXPECT_EQ(Length(outline, OutlineKind::kContour, true), 0);
  // Every sample lies where its point of the object is seen, and a contour's normal points out.
  const Eigen::Vector2d middle = Pixel(0, 0, 0.25);
  for (const OutlineSample& sample : outline.samples) {
    const Eigen::Vector3d point = sample.in_object.cast<double>();
    EXPECT_LT(Distance(Pixel(point.x(), point.y(), point.z()), sample.pixel.cast<double>()), 0.01);
    if (sample.kind != OutlineKind::kContour) continue;
    EXPECT_GT((sample.pixel.cast<double>() - middle).dot(sample.normal.cast<double>()), 0);
  }
}

TEST_F(BoxOutline, DoesNotDependOnTheOrderOfCorners) {
  TriangleMesh mesh = BoxMesh({0.6f, 0.4f, 0.5f});
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  }
  const auto pose = Eigen::Isometry3d::Identity();
  const ModelOutline expected = ProjectOutline(*box_, pose, scan_from_cam_, camera_, {});
  const ModelOutline turned = ProjectOutline(*Prepared(mesh), pose, scan_from_cam_, camera_, {});
  ASSERT_EQ(turned.samples.size(), expected.samples.size());
  for (std::size_t i = 0; i < expected.samples.size(); ++i) {
    EXPECT_EQ(turned.samples[i].pixel, expected.samples[i].pixel);
  }
}

TEST_F(BoxOutline, EndsAtTheBorderOfTheImage) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = scan_from_cam_.linear() * Eigen::Vector3d(1.4, 0, 0);
  const ModelOutline outline = ProjectOutline(*box_, pose, scan_from_cam_, camera_, {});
  EXPECT_GT(outline.samples.size(), 10u);
  for (const OutlinePolyline& line : outline.lines) {
    for (const Eigen::Vector2f& pixel : line.pixels) EXPECT_LT(pixel.x(), 639 + 4);
  }
  pose.translation() = scan_from_cam_ * Eigen::Vector3d(0, 0, -2);
  EXPECT_TRUE(ProjectOutline(*box_, pose, scan_from_cam_, camera_, {}).samples.empty());
}

TEST_F(BoxOutline, IsDashedBehindAnotherObjectAndTheScan) {
  const auto pose = Eigen::Isometry3d::Identity();
  const double all = Length(ProjectOutline(*box_, pose, scan_from_cam_, camera_, {}),
                            OutlineKind::kContour, false);
  // A board halfway that covers what lies left of the middle of the image.
  const Eigen::Isometry3d board_pose =
      scan_from_cam_ * Eigen::Translation3d(-0.5, 0.5, 1.2) *
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  const TriangleMesh board = BoxMesh({1.0f, 0.02f, 1.0f});
  const Occluders other{nullptr, {{Prepared(board), board_pose}}};
  const auto scan =
      OccludingScan::Prepare(std::make_shared<TriangleMesh>(Transformed(board, board_pose)));
  ASSERT_TRUE(scan.ok());
  for (const Occluders& occluders : {other, Occluders{*scan, {}}}) {
    const ModelOutline outline = ProjectOutline(*box_, pose, scan_from_cam_, camera_, occluders);
    const double hidden = Length(outline, OutlineKind::kContour, true);
    EXPECT_GT(hidden, 0.3 * all);
    EXPECT_LT(hidden, 0.7 * all);
    EXPECT_NEAR(Length(outline, OutlineKind::kContour, false) + hidden, all, 1);
    for (const OutlineSample& sample : outline.samples) {
      if (std::abs(sample.pixel.x() - 319.5) > 12) {
        EXPECT_EQ(sample.hidden, sample.pixel.x() < 319.5) << sample.pixel.transpose();
      }
    }
  }
}

TEST_F(BoxOutline, IsNotHiddenByItsOwnScan) {
  const TriangleMesh mesh = BoxMesh({0.6f, 0.4f, 0.5f});
  const Eigen::Isometry3d toward =
      Eigen::Isometry3d(Eigen::Translation3d(0.04 * (scan_from_cam_.translation()).normalized()));
  const auto scan =
      OccludingScan::Prepare(std::make_shared<TriangleMesh>(Transformed(mesh, toward)));
  const ModelOutline outline = ProjectOutline(*box_, Eigen::Isometry3d::Identity(), scan_from_cam_,
                                              camera_, Occluders{*scan, {}});
  EXPECT_EQ(Length(outline, OutlineKind::kContour, true), 0);
}

TEST(OutlineModel, SaysThatAPointCloudHasNoOutline) {
  TriangleMesh cloud = BoxMesh({1, 1, 1});
  cloud.triangles.clear();
  EXPECT_EQ(OutlineModel::Prepare(cloud).error().code, ErrorCode::kDegenerate);
  EXPECT_EQ(OccludingScan::Prepare(std::make_shared<TriangleMesh>(cloud)).error().code,
            ErrorCode::kDegenerate);
}

TEST(OutlineModel, TakesTheBorderOfAnOpenMeshForContour) {
  TriangleMesh sheet;
  sheet.vertices = {{-0.5f, -0.5f, 0}, {0.5f, -0.5f, 0}, {0.5f, 0.5f, 0}, {-0.5f, 0.5f, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Eigen::Isometry3d scan_from_cam = LookAt({0.1, 0, 2}, {0, 0, 0});
  const ModelOutline outline = ProjectOutline(*Prepared(sheet), Eigen::Isometry3d::Identity(),
                                              scan_from_cam, TestCamera(), {});
  EXPECT_NEAR(Length(outline, OutlineKind::kContour, false), 4 * 554.0 / 2, 12);
  EXPECT_EQ(Length(outline, OutlineKind::kCrease, false), 0);
}

}  // namespace
}  // namespace plumbline
