// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

constexpr char kAsciiQuad[] =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\nproperty "
    "float y\nproperty float z\n"
    "property float confidence\nproperty uchar red\nproperty uchar green\nproperty uchar "
    "blue\nelement face 1\n"
    "property uchar flags\nproperty list uchar uint vertex_index\nend_header\n"
    "0 0 0 0.5 255 0 0\n1 0 0 0.5 0 255 0\n1 1 0 0.5 0 0 255\n0 +1 1e-1 0.5 9 8 7\n3 4 0 1 2 3\n";

std::filesystem::path Write(const TemporaryFolder& folder, const std::string& name,
                            std::string_view content) {
  const std::filesystem::path file = folder.path() / name;
  EXPECT_TRUE(WriteFileAtomically(file, content).ok());
  return file;
}

template <typename T>
std::string BigEndian(T value) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  std::reverse(raw.begin(), raw.end());
  return raw;
}

Error FailureOf(const TemporaryFolder& folder, const std::string& name, std::string_view content) {
  const Result<TriangleMesh> mesh = ReadMesh(Write(folder, name, content));
  EXPECT_FALSE(mesh.ok()) << content;
  return mesh.ok() ? Error{} : mesh.error();
}

TEST(MeshFile, ReadsAsciiPlyAndCutsPolygonsIntoFans) {
  const TemporaryFolder folder;
  const Result<TriangleMesh> mesh = ReadMesh(Write(folder, "quad.ply", kAsciiQuad));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_EQ(mesh->vertices.size(), 4u);
  EXPECT_EQ(mesh->vertices[3], Eigen::Vector3f(0, 1, 0.1f));
  ASSERT_EQ(mesh->triangles.size(), 2u);
  EXPECT_EQ(mesh->triangles[1], Eigen::Vector3i(0, 2, 3));
  ASSERT_EQ(mesh->colors.size(), 4u);
  EXPECT_EQ(mesh->colors[3], (std::array<std::uint8_t, 3>{9, 8, 7}));
  EXPECT_TRUE(mesh->normals.empty());
}

TEST(MeshFile, ReadsWindowsLineEnds) {
  const TemporaryFolder folder;
  std::string text;
  for (const char c : std::string(kAsciiQuad))
    text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Result<TriangleMesh> mesh = ReadMesh(Write(folder, "quad.ply", text));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 2u);
}

TEST(MeshFile, ReadsBigEndianPlyWithShortIndices) {
  const TemporaryFolder folder;
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
      "y\nproperty float z\n"
      "element face 1\nproperty list int short vertex_indices\nend_header\n";
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.5f, 0.f})
    bytes += BigEndian(value);
  bytes += BigEndian(std::int32_t{3});
  for (const std::int16_t index : {2, 1, 0}) bytes += BigEndian(index);
  const Result<TriangleMesh> mesh = ReadMesh(Write(folder, "big.ply", bytes));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->vertices[2], Eigen::Vector3f(0, 2.5f, 0));
  EXPECT_EQ(mesh->triangles.at(0), Eigen::Vector3i(2, 1, 0));
}

TEST(MeshFile, WrittenPlyReadsBackExactly) {
  const TemporaryFolder folder;
  TriangleMesh mesh;
  for (int i = 0; i < 5; ++i) {
    mesh.vertices.emplace_back(0.1f * i, 1.0f / (i + 1), -3.0f * i);
    mesh.normals.push_back(Eigen::Vector3f(i, 1, 2).normalized());
    mesh.colors.push_back({static_cast<std::uint8_t>(i), 200, 255});
    mesh.texture_coordinates.emplace_back(0.2f * i, 0.7f);
  }
  mesh.texture_file = "wood grain.png";
  mesh.triangles = {{0, 1, 2}, {2, 3, 4}};
  const std::filesystem::path file = folder.path() / "mesh.ply";
  ASSERT_TRUE(WritePly(file, mesh).ok());
  const Result<TriangleMesh> read = ReadMesh(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->vertices, mesh.vertices);
  EXPECT_EQ(read->normals, mesh.normals);
  EXPECT_EQ(read->colors, mesh.colors);
  EXPECT_EQ(read->texture_coordinates, mesh.texture_coordinates);
  EXPECT_EQ(read->triangles, mesh.triangles);
  EXPECT_EQ(read->texture_file, mesh.texture_file);
}

TEST(MeshFile, EveryTruncationOfAPlyIsAnError) {
  const TemporaryFolder folder;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  ASSERT_TRUE(WritePly(folder.path() / "whole.ply", mesh).ok());
  const std::string whole = *ReadFile(folder.path() / "whole.ply");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Error error = FailureOf(folder, "part.ply", std::string_view(whole).substr(0, size));
    EXPECT_EQ(error.code, ErrorCode::kCorrupt) << size;
    EXPECT_THAT(error.message, HasSubstr("part.ply"));
  }
}

TEST(MeshFile, RefusesBadIndicesAndNonFiniteVertices) {
  const TemporaryFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_THAT(FailureOf(folder, "a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n").message,
              HasSubstr("vertex 3 of 3"));
  EXPECT_THAT(FailureOf(folder, "b.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n").message,
              HasSubstr("face 0"));
  EXPECT_THAT(FailureOf(folder, "c.ply", head + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n").message,
              HasSubstr("not finite"));
  EXPECT_THAT(FailureOf(folder, "d.ply", head + "0 0 0\n1 oops 0\n0 1 0\n3 0 1 2\n").message,
              HasSubstr("vertex 1"));
  EXPECT_THAT(FailureOf(folder, "e.ply",
                        "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\n"
                        "property float y\nproperty float z\nend_header\n0 0 0\n")
                  .message,
              HasSubstr("ends within vertex 1"));
}

TEST(MeshFile, ReadsAPointCloudOf343000PointsFast) {
  const TemporaryFolder folder;
  TriangleMesh cloud;
  for (int i = 0; i < 343000; ++i) {
    cloud.vertices.emplace_back(0.001f * i, 1, 2);
    cloud.normals.emplace_back(0, 0, 1);
    cloud.colors.push_back({1, 2, 3});
  }
  ASSERT_TRUE(WritePly(folder.path() / "cloud.ply", cloud).ok());
  const auto start = std::chrono::steady_clock::now();
  const Result<TriangleMesh> read = ReadMesh(folder.path() / "cloud.ply");
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->vertices.size(), cloud.vertices.size());
  EXPECT_TRUE(read->triangles.empty());
  RecordProperty("seconds", std::to_string(seconds));
  EXPECT_LT(seconds, 2.0);  // about 0.04 s alone; generous for loaded machines and sanitizers
}

TEST(MeshFile, ReadsObjAndStl) {
  const TemporaryFolder folder;
  const Result<TriangleMesh> obj = ReadMesh(Write(
      folder, "a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nf 1 2 3 4\n"));
  ASSERT_TRUE(obj.ok()) << obj.error().message;
  EXPECT_EQ(obj->vertices.size(), 4u);
  EXPECT_EQ(obj->triangles.size(), 2u);
  EXPECT_EQ(obj->colors.size(), 4u);
  const Result<TriangleMesh> stl =
      ReadMesh(Write(folder, "a.stl",
                     "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex "
                     "0 1 0\nendloop\nendfacet\nendsolid a\n"));
  ASSERT_TRUE(stl.ok()) << stl.error().message;
  EXPECT_EQ(stl->triangles.size(), 1u);
}

TEST(MeshFile, SaysWhichFileIsMissingOrOfAnUnknownKind) {
  EXPECT_EQ(ReadMesh("nowhere/a.ply").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(ReadMesh("nowhere/a.obj").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(ReadMesh("nowhere/a.docx").error().code, ErrorCode::kUnsupported);
  const TemporaryFolder folder;
  EXPECT_THAT(FailureOf(folder, "a.glb", "glTF but not really").message, HasSubstr("a.glb"));
  EXPECT_THAT(FailureOf(folder, "bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n").message,
              HasSubstr("bad.obj"));
}

TEST(MeshFile, ReadsTheKitchenScan) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const Result<TriangleMesh> scan = ReadMesh(*shared / "data/kitchen/scene.ply");
  ASSERT_TRUE(scan.ok()) << scan.error().message;
  EXPECT_EQ(scan->vertices.size(), 343452u);
  EXPECT_EQ(scan->triangles.size(), 640000u);
  EXPECT_EQ(scan->colors.size(), 343452u);
}

TEST(MeshFile, ReadsTheAeronChairWithItsColours) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const Result<TriangleMesh> chair = ReadMesh(*shared / "data/aeron/hermanmiller_aeron.obj");
  ASSERT_TRUE(chair.ok()) << chair.error().message;
  EXPECT_EQ(chair->triangles.size(), 4999u);
  EXPECT_EQ(chair->colors.size(), chair->vertices.size());
}

}  // namespace
}  // namespace plumbline
