// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scan_file.h"

#include <fstream>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/models/mesh_file.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(ScanFile, LeavesOutPointsThatAreNotFiniteAndCountsThem) {
  const TemporaryFolder folder;
  TriangleMesh cloud;
  cloud.vertices = {{0, 0, 0}, {kNan, kNan, kNan}, {1, 2, 3}, {0, kNan, 0}};
  cloud.colors = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}};
  ASSERT_TRUE(WritePly(folder.path() / "binary.ply", cloud).ok());
  std::ofstream(folder.path() / "text.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
         "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
         "0 0 0 1 1 1\nnan nan nan 2 2 2\n1 2 3 3 3 3\n0 inf 0 4 4 4\n";
  std::ofstream(folder.path() / "cloud.pcd")
      << "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
         "POINTS 4\nDATA ascii\n0 0 0\nnan nan nan\n1 2 3\nnan nan nan\n";
  for (const char* name : {"binary.ply", "text.ply", "cloud.pcd"}) {
    const auto scan = ReadScan(folder.path() / name);
    ASSERT_TRUE(scan.ok()) << scan.error().message;
    EXPECT_EQ(scan->num_left_out, 2u) << name;
    ASSERT_EQ(scan->mesh.vertices.size(), 2u) << name;
    EXPECT_EQ(scan->mesh.vertices[1], Eigen::Vector3f(1, 2, 3)) << name;
    if (name != std::string("cloud.pcd")) {
      EXPECT_EQ(scan->mesh.colors.at(1)[0], 3) << "its own colour";
    }
    EXPECT_TRUE(ReadMesh(folder.path() / name).ok()) << name;
  }
  TriangleMesh nothing;
  nothing.vertices = {{kNan, 0, 0}};
  ASSERT_TRUE(WritePly(folder.path() / "nothing.ply", nothing).ok());
  EXPECT_EQ(ReadScan(folder.path() / "nothing.ply").error().code, ErrorCode::kCorrupt);
}

TEST(ScanFile, ARoomInMillimetresIsTooLargeForMetresAndAStrayPointIsNot) {
  TriangleMesh room;
  for (int i = 0; i < 1000; ++i)
    room.vertices.emplace_back(0.006f * static_cast<float>(i), 0.003f * static_cast<float>(i), 1);
  EXPECT_EQ(TooLargeForMetres(room), std::nullopt);
  room.vertices.emplace_back(90000.f, 0, 0);
  EXPECT_EQ(TooLargeForMetres(room), std::nullopt);
  room.vertices.pop_back();
  const auto size = TooLargeForMetres(Scaled(room, 1000));
  ASSERT_TRUE(size.has_value());
  EXPECT_NEAR(*size, 0.9 * 6000, 30);
  EXPECT_EQ(TooLargeForMetres({}), std::nullopt);
}

}  // namespace
}  // namespace plumbline
