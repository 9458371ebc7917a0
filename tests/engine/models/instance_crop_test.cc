// SPDX-License-Identifier: Apache-2.0
#include "engine/models/instance_crop.h"

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

/// Two triangles of label 7 and one that leads over to label 8.
constexpr const char* kPly = R"(ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
property int label
element face 3
property list uchar int vertex_indices
end_header
9 9 9 0 0 0 8
1 0 -2 10 20 30 7
2 0 -2 10 20 30 7
2 1 -2 10 20 30 7
1 1 -1 10 20 30 7
3 1 2 3
3 1 3 4
3 3 4 0
)";

TEST(InstanceCrop, KeepsTheTrianglesWithinTheLabel) {
  TemporaryFolder folder;
  const auto file = folder.path() / "scan.ply";
  ASSERT_TRUE(WriteFileAtomically(file, kPly).ok());
  const auto scan = ReadLabelledMesh(file);
  ASSERT_TRUE(scan.ok()) << scan.error().message;
  EXPECT_EQ(scan->labels, (std::vector<int>{8, 7, 7, 7, 7}));
  const TriangleMesh crop = CropByLabel(*scan, 7);
  ASSERT_EQ(crop.triangles.size(), 2u);
  ASSERT_EQ(crop.vertices.size(), 4u);
  EXPECT_EQ(crop.colors.size(), 4u);
  EXPECT_EQ(crop.vertices[static_cast<std::size_t>(crop.triangles[1][2])],
            Eigen::Vector3f(1, 1, -1));
  EXPECT_TRUE(CropByLabel(*scan, 5).triangles.empty());
}

TEST(InstanceCrop, StandsUprightOnTheMiddleOfItsFootprint) {
  TemporaryFolder folder;
  const auto file = folder.path() / "scan.ply";
  ASSERT_TRUE(WriteFileAtomically(file, kPly).ok());
  const TriangleMesh crop = CropByLabel(*ReadLabelledMesh(file), 7);
  // Gravity along +z of the scan: what is at z = -1 is lowest.
  const UprightCrop model = UprightModel(crop, Eigen::Vector3d(0, 0, 9.8));
  const Eigen::AlignedBox3f box = BoundingBox(model.mesh);
  EXPECT_NEAR(box.min().z(), 0, 1e-6);
  EXPECT_NEAR(box.max().z(), 1, 1e-6);
  EXPECT_NEAR(box.center().x(), 0, 1e-6);
  EXPECT_NEAR(box.center().y(), 0, 1e-6);
  EXPECT_LT((model.scan_from_object.linear().col(2) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((model.scan_from_object.translation() - Eigen::Vector3d(1.5, 0.5, -1)).norm(), 1e-6);
  for (std::size_t i = 0; i < crop.vertices.size(); ++i)
    EXPECT_LT((model.scan_from_object * model.mesh.vertices[i].cast<double>() -
               crop.vertices[i].cast<double>())
                  .norm(),
              1e-6);
}

TEST(InstanceCrop, AMeshWithoutLabelsIsRefused) {
  TemporaryFolder folder;
  const auto file = folder.path() / "scan.ply";
  std::string text = kPly;
  text.replace(text.find("label"), 5, "other");
  ASSERT_TRUE(WriteFileAtomically(file, text).ok());
  EXPECT_THAT(ReadLabelledMesh(file).error().message, testing::HasSubstr("'label'"));
}

}  // namespace
}  // namespace plumbline
