// SPDX-License-Identifier: Apache-2.0
#include "engine/models/textured_mesh.h"

#include <gmock/gmock.h>

#include <cmath>

#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_cleanup.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

/// A square of 1 x 1 with the whole texture on it.
TriangleMesh Square() {
  TriangleMesh square = MakeParallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  square.texture_coordinates = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return square;
}

/// Black but for a white stripe from 30 to 50 % of the width.
cv::Mat Stripe() {
  cv::Mat texture(100, 100, CV_8UC3, cv::Scalar::all(0));
  texture.colRange(30, 50).setTo(cv::Scalar::all(255));
  return texture;
}

double GreyAt(const TriangleMesh& mesh, const Eigen::Vector3i& t, const Eigen::Vector3d& point) {
  const auto at = [&](int c) {
    return mesh.vertices[static_cast<std::size_t>(t[c])].cast<double>();
  };
  const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
  double grey = 0;
  for (int c = 0; c < 3; ++c) {
    const double weight =
        (at((c + 1) % 3) - point).cross(at((c + 2) % 3) - point).dot(normal) / normal.squaredNorm();
    grey += weight * mesh.colors[static_cast<std::size_t>(t[c])][0];
  }
  return grey;
}

TEST(TexturedMesh, TexelsAreReadFromTheLowerLeftAndRepeat) {
  cv::Mat texture(2, 2, CV_8UC3, cv::Scalar::all(0));
  texture.at<cv::Vec3b>(1, 0) = {10, 20, 30};  // lower left, BGR
  for (const Eigen::Vector2f& uv :
       {Eigen::Vector2f(0.25f, 0.25f), {1.25f, 0.25f}, {-0.75f, 3.25f}}) {
    EXPECT_TRUE(TexelAt(texture, uv).isApprox(Eigen::Vector3f(30, 20, 10), 1e-4f)) << uv;
  }
  // Halfway between two texels.
  EXPECT_NEAR(TexelAt(texture, {0.5f, 0.25f}).x(), 15, 1e-3);
}

TEST(TexturedMesh, FacesAreCutWhereTheTextureChangesAndNowhereElse) {
  TriangleMesh mesh = Square();
  const double area = SurfaceArea(mesh);
  PaintByTexture(Stripe(), 4000, mesh);
  EXPECT_NEAR(SurfaceArea(mesh), area, 1e-5);
  EXPECT_GT(mesh.triangles.size(), 500u);
  EXPECT_EQ(CountEdges(mesh).non_manifold, 0);
  const auto samples = SampleSurface(mesh, 4000, 1).value();
  int off = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const double x = samples.points[i].x();
    const double wanted = x > 0.3 && x < 0.5 ? 255 : 0;
    const auto face = static_cast<std::size_t>(samples.triangles[i]);
    off += std::abs(GreyAt(mesh, mesh.triangles[face], samples.points[i]) - wanted) > 128;
  }
  // Two lines, each blurred over less than 0.6 % of the diagonal to either side: 0.034 at most.
  EXPECT_LT(off, 0.034 * 4000);
  // Far from the stripe two triangles would do; at least the largest faces are still there.
  float largest = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto at = [&](int c) { return mesh.vertices[static_cast<std::size_t>(t[c])]; };
    largest = std::max(largest, (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2);
  }
  EXPECT_GT(largest, 0.05f);
}

TEST(TexturedMesh, CutsNeverLeaveACornerOnAnotherFacesEdge) {
  // A box is closed before and after: a corner on an edge would open it. Each side has the stripe
  // on corners of its own, so that edges are seams.
  TriangleMesh box;
  for (const auto& [corner, a, b] :
       {std::tuple(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(1, 0, 0)),
        std::tuple(Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0)),
        std::tuple(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 0, 1)),
        std::tuple(Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(1, 0, 0)),
        std::tuple(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, 1, 0)),
        std::tuple(Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0, 0, 1))}) {
    TriangleMesh side = MakeParallelogram(corner, a, b);
    side.texture_coordinates = Square().texture_coordinates;
    Append(side, box);
  }
  ASSERT_EQ(CountEdges(box).open, 0);
  PaintByTexture(Stripe(), 3000, box);
  EXPECT_GT(box.triangles.size(), 2000u);
  EXPECT_EQ(CountEdges(box).open, 0);
  EXPECT_EQ(CountEdges(box).non_manifold, 0);
}

TEST(TexturedMesh, AnEvenTextureAddsNothing) {
  TriangleMesh mesh = Square();
  PaintByTexture(cv::Mat(8, 8, CV_8UC3, cv::Scalar(30, 20, 10)), 4000, mesh);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  for (const auto& rgb : mesh.colors) EXPECT_EQ(rgb, (std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST(TexturedMesh, KeepsToTheFacesThatItMayHave) {
  cv::Mat noise(256, 256, CV_8UC3);
  cv::theRNG().state = 7;
  cv::randu(noise, 0, 255);
  TriangleMesh mesh = Square();
  PaintByTexture(noise, 300, mesh);
  EXPECT_LE(mesh.triangles.size(), 301u) << "a cut adds one face for each side of the edge";
  EXPECT_GE(mesh.triangles.size(), 299u);
}

TEST(TexturedMesh, SeveralTexturesBecomeOneThatShowsTheSame) {
  // A part that repeats a stripe twice, one in plain red, one with colours of its own.
  TexturePart striped{Square(), 0}, red{Square(), 1}, own{Square(), -1};
  for (Eigen::Vector2f& uv : striped.mesh.texture_coordinates) uv.x() *= 2;
  red.mesh = Transformed(std::move(red.mesh), Eigen::Isometry3d(Eigen::Translation3d(2, 0, 0)));
  own.mesh = Transformed(std::move(own.mesh), Eigen::Isometry3d(Eigen::Translation3d(4, 0, 0)));
  own.mesh.texture_coordinates.clear();
  own.mesh.colors.assign(4, {1, 2, 3});
  const std::vector<cv::Mat> textures = {Stripe(), cv::Mat(4, 4, CV_8UC3, cv::Scalar(0, 0, 200))};
  TexturedMesh joined = JoinParts({striped, red, own}, textures);
  ASSERT_EQ(joined.mesh.triangles.size(), 6u);
  ASSERT_FALSE(joined.texture.empty());
  for (const Eigen::Vector2f& uv : joined.mesh.texture_coordinates) {
    EXPECT_GE(uv.minCoeff(), 0);
    EXPECT_LE(uv.maxCoeff(), 1);
  }
  PaintByTexture(joined.texture, 6000, joined.mesh);
  const auto samples = SampleSurface(joined.mesh, 6000, 1).value();
  int off = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const double x = samples.points[i].x(), across = std::fmod(2 * x, 1.0);
    const double wanted = x >= 4 ? 1 : x >= 2 ? 200 : across > 0.3 && across < 0.5 ? 255 : 0;
    const auto face = static_cast<std::size_t>(samples.triangles[i]);
    off += std::abs(GreyAt(joined.mesh, joined.mesh.triangles[face], samples.points[i]) - wanted) >
           100;
  }
  // Four lines over a third of the surface, each blurred over 0.6 % of the diagonal of 5.1.
  EXPECT_LT(off, 0.08 * 6000);
}

TEST(TexturedMesh, APartWithoutTextureStaysAsItIs) {
  TexturePart part{Square(), -1};
  part.mesh.colors.assign(4, {9, 8, 7});
  const TexturedMesh joined = JoinParts({part}, {});
  EXPECT_TRUE(joined.texture.empty());
  EXPECT_EQ(joined.mesh.colors, part.mesh.colors);
  EXPECT_EQ(joined.mesh.texture_coordinates, part.mesh.texture_coordinates);
}

}  // namespace
}  // namespace plumbline
