// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_database.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TriangleMesh Triangle(float size) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {size, 0, 0}, {0, 0, 2 * size}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// A folder with one mesh `a.ply` and the given models.json.
struct Folder {
  explicit Folder(const std::string& json) {
    EXPECT_TRUE(WritePly(folder.path() / "a.ply", Triangle(1)).ok());
    EXPECT_TRUE(WriteFileAtomically(folder.path() / "models.json", json).ok());
  }
  Error Failure() const {
    const auto database = ModelDatabase::Load(folder.path());
    EXPECT_FALSE(database.ok());
    return database.ok() ? Error{} : database.error();
  }
  TemporaryFolder folder;
};

TEST(ModelDatabase, ReadsModelsAndKeepsDefaults) {
  const Folder folder(R"({"units": "m", "extra": 1, "models": [
    {"name": "a", "file": "a.ply", "category": "chair", "front": "+x"},
    {"name": "b", "file": "a.ply", "category": "cup", "support": "floor", "symmetry": {"axis": [0,0,2], "order": 0}}]})");
  const auto database = ModelDatabase::Load(folder.folder.path());
  ASSERT_TRUE(database.ok()) << database.error().message;
  const ModelDatabase& models = **database;
  ASSERT_EQ(models.models().size(), 2u);
  EXPECT_EQ(models.models()[0].symmetry.order, 1);
  EXPECT_EQ(models.models()[0].support, Support::kAny);
  EXPECT_EQ(models.models()[1].symmetry.order, 0);
  EXPECT_DOUBLE_EQ(models.models()[1].symmetry.axis.z(), 1.0);
  EXPECT_EQ(models.models()[1].support, Support::kFloor);
  EXPECT_EQ(models.Find("b"), ModelId{1});
  EXPECT_EQ(models.Find("c"), std::nullopt);
  EXPECT_THAT(models.OfCategory("chair"), ElementsAre(ModelId{0}));
  EXPECT_TRUE(models.model(ModelId{0}).center().isApprox(Eigen::Vector3d(0.5, 0, 1)));
  EXPECT_EQ(models.models()[0].content_hash, models.models()[1].content_hash);
}

TEST(ModelDatabase, HashTellsMeshesColoursOrderAndSymmetryApart) {
  CadModel a, b;
  a.name = "a";
  a.category = b.category = "chair";
  b.name = "b";
  a.mesh = Triangle(1);
  b.mesh = Triangle(2);
  const auto hash = [](const std::vector<CadModel>& models) {
    return ModelDatabase::FromModels(models)->content_hash();
  };
  EXPECT_EQ(hash({a, b}), hash({a, b}));
  EXPECT_NE(hash({a, b}), hash({b, a}));
  CadModel turned = a;
  turned.symmetry.order = 2;
  EXPECT_NE(hash({a}), hash({turned}));
  // What is precomputed of a model keeps its marks: another colour is another model.
  CadModel red = a, blue = a;
  red.mesh.colors.assign(a.mesh.vertices.size(), {200, 0, 0});
  blue.mesh.colors.assign(a.mesh.vertices.size(), {0, 0, 200});
  EXPECT_NE(hash({red}), hash({blue}));
}

TEST(ModelDatabase, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(Folder(R"({"models": [{"name": "a", "file": "a.ply"}]})").Failure().message,
              HasSubstr("category"));
  EXPECT_THAT(Folder(R"({"models": [{"name": "a", "file": "gone.ply", "category": "c"}]})")
                  .Failure()
                  .message,
              HasSubstr("gone.ply"));
  EXPECT_THAT(
      Folder(R"({"models": [{"name": "a", "file": "a.ply", "category": "c", "support": "wall"}]})")
          .Failure()
          .message,
      HasSubstr("wall"));
  EXPECT_THAT(Folder(R"({"units": "cm", "models": []})").Failure().message, HasSubstr("--unit cm"));
  EXPECT_EQ(Folder(R"({"models": [{"name": 3, "file": "a.ply", "category": "c"}]})").Failure().code,
            ErrorCode::kCorrupt);
  EXPECT_THAT(
      Folder(
          R"({"models": [{"name": "a", "file": "a.ply", "category": "c"},{"name": "a", "file": "a.ply", "category": "c"}]})")
          .Failure()
          .message,
      HasSubstr("taken"));
  const TemporaryFolder empty;
  EXPECT_EQ(ModelDatabase::Load(empty.path()).error().code, ErrorCode::kNotFound);
}

TEST(ModelDatabase, ReadsNoFileOutsideOfItsFolder) {
  const TemporaryFolder other;
  ASSERT_TRUE(WritePly(other.path() / "b.ply", Triangle(1)).ok());
  const std::string sibling = "../" + other.path().filename().string() + "/b.ply";
  for (const std::string& file : {(other.path() / "b.ply").string(), sibling}) {
    const Error failure =
        Folder(
            nlohmann::json{{"models", {{{"name", "b"}, {"file", file}, {"category", "c"}}}}}.dump())
            .Failure();
    EXPECT_EQ(failure.code, ErrorCode::kInvalidInput);
    EXPECT_THAT(failure.message, HasSubstr("'" + file + "' leads out of the folder"));
    EXPECT_THAT(failure.message, HasSubstr("--allow-outside"));
  }
}

TEST(ModelDatabase, LoadsTheKitchenModels) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto database = ModelDatabase::Load(*shared / "data/kitchen/models");
  ASSERT_TRUE(database.ok()) << database.error().message;
  ASSERT_EQ((*database)->models().size(), 6u);
  const CadModel& chair = (*database)->model(*(*database)->Find("chair"));
  EXPECT_EQ(chair.mesh.triangles.size(), 5000u);
  EXPECT_EQ(chair.support, Support::kFloor);
  EXPECT_NEAR(chair.bounds.min().z(), 0.0, 0.02);
  EXPECT_EQ((*database)->OfCategory("cup").size(), 2u);
}

}  // namespace
}  // namespace plumbline
