// SPDX-License-Identifier: Apache-2.0
// What a reader of its own, assimp's, makes of the room that was written.

#include "engine/models/gltf_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/models/mesh_file.h"
#include "engine/models/model_texture.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

CadModel Box(const std::string& name, const Eigen::Vector3f& size) {
  CadModel model;
  model.name = name;
  model.file = name + ".ply";
  model.category = "chair";
  model.mesh = MakeBox({-size.x() / 2, -size.y() / 2, 0}, {size.x() / 2, size.y() / 2, size.z()});
  return model;
}

Eigen::Isometry3d At(double x, double y, double z, double azimuth_rad) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitZ());
}

/// The box around everything that a node draws, in the file's coordinates.
Eigen::AlignedBox3d Around(const aiScene& scene, const std::string& name) {
  const aiNode* node = scene.mRootNode->FindNode(name.c_str());
  Eigen::AlignedBox3d box;
  if (node == nullptr) return box;
  aiMatrix4x4 all;
  for (const aiNode* up = node; up != nullptr; up = up->mParent) all = up->mTransformation * all;
  for (unsigned m = 0; m < node->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node->mMeshes[m]];
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D v = all * mesh.mVertices[i];
      box.extend(Eigen::Vector3d(v.x, v.y, v.z));
    }
  }
  return box;
}

class GltfFile : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<CadModel> models = {Box("chair", {0.5f, 0.4f, 0.9f}), Box("desk", {2, 1, 0.7f}),
                                    Box("shelf", {1, 0.3f, 2})};
    models[1].mesh.colors.assign(8, {3, 2, 1});  // as painted by the texture
    models[2].mesh.colors.assign(8, {255, 128, 0});
    models[1].mesh.texture_coordinates.assign(8, {0.25f, 0.75f});
    models[1].mesh.texture_file = "wood.png";
    EXPECT_TRUE(cv::imwrite((folder_.path() / "wood.png").string(),
                            cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3))));
    models[1].mesh.texture_file = (folder_.path() / "wood.png").string();
    models_ = ModelDatabase::FromModels(models);
    const CadModel &chair = models_->models()[0], &desk = models_->models()[1],
                   &shelf = models_->models()[2];
    objects_ = {{"chair_0", &chair, At(1, 2, 0, 0), 1, {}, {{"quality", "fine"}}},
                {"chair_1", &chair, At(-1, 0, 0.5, M_PI / 2), 2, {}, {}},
                {"desk_0", &desk, At(0, 0, 0, 0), 1, TextureOf(*models_, desk), {}},
                {"shelf_0", &shelf, At(3, 3, 0, 0), 1, {}, {}}};
  }
  const aiScene* Read(GltfUp up) {
    const Status written = WriteGltf(folder_.path() / "room.glb", objects_, up);
    EXPECT_TRUE(written.ok()) << written.error().message;
    const aiScene* scene =
        importer_.ReadFile((folder_.path() / "room.glb").string(), aiProcess_ValidateDataStructure);
    EXPECT_NE(scene, nullptr) << importer_.GetErrorString();
    return scene;
  }

  TemporaryFolder folder_;
  std::shared_ptr<const ModelDatabase> models_;
  std::vector<GltfObject> objects_;
  Assimp::Importer importer_;
};

TEST_F(GltfFile, NodesAreNamedAndStandWhereTheObjectsDo) {
  const aiScene* scene = Read(GltfUp::kZ);
  ASSERT_NE(scene, nullptr);
  // Numbers of the file are single precision.
  const Eigen::AlignedBox3d chair = Around(*scene, "chair_0");
  EXPECT_LT((chair.min() - Eigen::Vector3d(0.75, 1.8, 0)).norm(), 1e-6);
  EXPECT_LT((chair.max() - Eigen::Vector3d(1.25, 2.2, 0.9)).norm(), 1e-6);
  const Eigen::AlignedBox3d turned = Around(*scene, "chair_1");  // twice as large
  EXPECT_LT((turned.min() - Eigen::Vector3d(-1.4, -0.5, 0.5)).norm(), 1e-6);
  EXPECT_LT((turned.max() - Eigen::Vector3d(-0.6, 0.5, 2.3)).norm(), 1e-6);
}

TEST_F(GltfFile, YPointsUpAsTheFormatSays) {
  const aiScene* scene = Read(GltfUp::kY);
  ASSERT_NE(scene, nullptr);
  const Eigen::AlignedBox3d chair = Around(*scene, "chair_0");  // (x, y, z) -> (x, z, -y)
  EXPECT_LT((chair.min() - Eigen::Vector3d(0.75, 0, -2.2)).norm(), 1e-6);
  EXPECT_LT((chair.max() - Eigen::Vector3d(1.25, 0.9, -1.8)).norm(), 1e-6);
}

TEST_F(GltfFile, ColoursAndTexturesAreInIt) {
  const aiScene* scene = Read(GltfUp::kY);
  ASSERT_NE(scene, nullptr);
  ASSERT_EQ(scene->mNumTextures, 1u) << "embedded";
  EXPECT_STREQ(scene->mTextures[0]->achFormatHint, "png");
  const auto mesh = [&](const char* name) -> const aiMesh& {
    return *scene->mMeshes[scene->mRootNode->FindNode(name)->mMeshes[0]];
  };
  EXPECT_FALSE(mesh("desk_0").HasVertexColors(0)) << "they would tint the texture";
  ASSERT_TRUE(mesh("desk_0").HasTextureCoords(0));
  EXPECT_NEAR(mesh("desk_0").mTextureCoords[0][0].y, 0.75, 1e-6)
      << "assimp counts from below, as we do";
  ASSERT_TRUE(mesh("shelf_0").HasVertexColors(0));
  EXPECT_NEAR(mesh("shelf_0").mColors[0][0].r, 1, 1e-4);
  // 128 of sRGB is 0.2158605 of the light (IEC 61966-2-1).
  EXPECT_NEAR(mesh("shelf_0").mColors[0][0].g, 0.2158605, 1e-4);
  const aiNode *first = scene->mRootNode->FindNode("chair_0"),
               *second = scene->mRootNode->FindNode("chair_1");
  const auto color = [&](const aiNode* of) {
    aiColor4D base;
    scene->mMaterials[scene->mMeshes[of->mMeshes[0]]->mMaterialIndex]->Get(AI_MATKEY_BASE_COLOR,
                                                                           base);
    return base;
  };
  EXPECT_FALSE(color(first) == color(second)) << "objects without colours are told apart";
}

TEST_F(GltfFile, OurOwnReaderHasTheColoursBack) {
  objects_ = {objects_.back()};
  (void)Read(GltfUp::kZ);
  const auto read = ReadMesh(folder_.path() / "room.glb");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_FALSE(read->colors.empty());
  EXPECT_EQ(read->colors[0], (std::array<std::uint8_t, 3>{255, 128, 0}));
}

TEST_F(GltfFile, OneModelIsStoredOnce) {
  objects_.resize(1);
  (void)Read(GltfUp::kY);
  const auto one = std::filesystem::file_size(folder_.path() / "room.glb");
  for (int i = 0; i < 9; ++i) objects_.push_back(objects_[0]);
  (void)Read(GltfUp::kY);
  EXPECT_LT(std::filesystem::file_size(folder_.path() / "room.glb"), one + 9 * 1000);
}

TEST_F(GltfFile, WhatCannotBeWrittenIsSaid) {
  EXPECT_THAT(WriteGltf(folder_.path() / "room.gltf", objects_, GltfUp::kY).error().message,
              testing::HasSubstr("must end in .glb"));
  EXPECT_EQ(WriteGltf(folder_.path() / "room.glb", {}, GltfUp::kY).error().code,
            ErrorCode::kInvalidInput);
  EXPECT_FALSE(WriteGltf(folder_.path() / "missing" / "room.glb", objects_, GltfUp::kY).ok());
}

}  // namespace
}  // namespace plumbline
