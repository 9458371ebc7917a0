// SPDX-License-Identifier: Apache-2.0
#include "engine/models/pcd_file.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline {
namespace {

using testing::HasSubstr;

std::string HeaderOf(const std::string& data, int points, const std::string& more = "") {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb" +
         std::string(more.empty() ? "" : " label") + "\nSIZE 4 4 4 4" +
         std::string(more.empty() ? "" : " 2") + "\nTYPE F F F F" +
         std::string(more.empty() ? "" : " U") + "\nCOUNT 1 1 1 1" +
         std::string(more.empty() ? "" : " 3") + "\nWIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}

template <typename T>
void PutBytes(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

constexpr std::uint32_t kColor = 0x00FF8010;  // red 255, green 128, blue 16

/// Two points in rows, with three labels each that nobody wants.
std::string Rows() {
  std::string rows;
  for (int i = 0; i < 2; ++i) {
    for (const float value : {1.0f + i, 2.0f + i, 3.0f + i}) PutBytes(rows, value);
    PutBytes(rows, kColor);
    for (int k = 0; k < 3; ++k) PutBytes(rows, static_cast<std::uint16_t>(7));
  }
  return rows;
}

void ExpectTwoPoints(const Result<TriangleMesh>& cloud) {
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  ASSERT_EQ(cloud->vertices.size(), 2u);
  EXPECT_EQ(cloud->vertices[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud->vertices[1], Eigen::Vector3f(2, 3, 4));
  EXPECT_TRUE(cloud->triangles.empty());
  ASSERT_EQ(cloud->colors.size(), 2u);
  EXPECT_EQ(cloud->colors[1], (std::array<std::uint8_t, 3>{255, 128, 16}));
}

TEST(PcdFile, ReadsText) {
  // A colour is a float whose bits are 0x00FF8010.
  ExpectTwoPoints(
      ParsePcd(HeaderOf("ascii", 2) + "1 2 3 2.3463992e-38\r\n2 3 4 2.3463992e-38\n", "a.pcd"));
}

TEST(PcdFile, ReadsBinaryRowsAndSkipsOtherFields) {
  ExpectTwoPoints(ParsePcd(HeaderOf("binary", 2, "label") + Rows(), "a.pcd"));
}

TEST(PcdFile, ReadsNormalsAndDoubles) {
  std::string bytes =
      "VERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 8 8 8 4 4 4\nTYPE F F F F F F\n"
      "WIDTH 1\nHEIGHT 1\nDATA binary\n";
  for (const double value : {0.1, 0.2, 0.3}) PutBytes(bytes, value);
  for (const float value : {0.0f, 0.6f, 0.8f}) PutBytes(bytes, value);
  const auto cloud = ParsePcd(bytes, "a.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->vertices[0], Eigen::Vector3f(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(cloud->normals[0], Eigen::Vector3f(0, 0.6f, 0.8f));
  EXPECT_TRUE(cloud->colors.empty());
}

TEST(PcdFile, LeavesOutHolesOfOrganisedClouds) {
  const auto cloud =
      ParsePcd(HeaderOf("ascii", 3) + "nan nan nan 0\n1 2 3 0\nnan nan nan 0\n", "a.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->vertices.size(), 1u);
}

/// Fields of four equal values in LZF: four literals, then a copy that overlaps itself.
std::string Compressed() {
  std::string packed;
  for (const std::uint32_t bits : {0x3F800000u, 0x40000000u, 0x40400000u, kColor}) {
    packed.push_back(3);  // 4 literals
    PutBytes(packed, bits);
    packed.push_back(static_cast<char>(7 << 5));  // A long copy: 7 + 3 + 2 = 12 bytes ...
    packed.push_back(3);
    packed.push_back(3);  // ... from 4 back.
  }
  std::string body;
  PutBytes(body, static_cast<std::uint32_t>(packed.size()));
  PutBytes(body, std::uint32_t{64});
  return body + packed;
}

TEST(PcdFile, ReadsCompressedColumns) {
  const auto cloud = ParsePcd(HeaderOf("binary_compressed", 4) + Compressed(), "a.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  ASSERT_EQ(cloud->vertices.size(), 4u);
  for (const Eigen::Vector3f& vertex : cloud->vertices) {
    EXPECT_EQ(vertex, Eigen::Vector3f(1, 2, 3));
  }
  EXPECT_EQ(cloud->colors[3], (std::array<std::uint8_t, 3>{255, 128, 16}));
}

TEST(PcdFile, ATornFileIsAnError) {
  for (const std::string& whole :
       {HeaderOf("binary", 2, "label") + Rows(), HeaderOf("binary_compressed", 4) + Compressed(),
        HeaderOf("ascii", 1) + "1 2 3 4"}) {
    for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
      const auto cloud = ParsePcd(whole.substr(0, size), "torn.pcd");
      ASSERT_FALSE(cloud.ok()) << size;
      EXPECT_THAT(cloud.error().message, HasSubstr("torn.pcd"));
    }
  }
}

TEST(PcdFile, SaysWhatItCannotRead) {
  EXPECT_EQ(ParsePcd(HeaderOf("base64", 1) + "1", "a.pcd").error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(
      ParsePcd("FIELDS u v\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA ascii\n1 2", "a.pcd").error().message,
      HasSubstr("no fields x, y and z"));
  EXPECT_FALSE(
      ParsePcd("FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n1 2 3", "a.pcd").ok());
  EXPECT_FALSE(
      ParsePcd("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 1\nDATA ascii\n1 2 3", "a.pcd").ok());
  EXPECT_FALSE(ParsePcd(HeaderOf("ascii", 1) + "1 two 3 4", "a.pcd").ok());
  EXPECT_FALSE(ParsePcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 99999999999999\nDATA "
                        "binary\n1234",
                        "a.pcd")
                   .ok());
}

}  // namespace
}  // namespace plumbline
