// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/furniture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "engine/models/model_database.h"
#include "engine/synthetic/room_files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// Every model once.
std::vector<FurnitureModel> AllFurniture() {
  std::vector<FurnitureModel> all = TwinCatalogue(PaletteOfSeed(3));
  for (FurnitureModel& model : OfficeCatalogue(PaletteOfSeed(3))) {
    if (std::none_of(all.begin(), all.end(),
                     [&](const FurnitureModel& other) { return other.name == model.name; }))
      all.push_back(std::move(model));
  }
  return all;
}

class Furniture : public testing::Test {
 protected:
  std::vector<FurnitureModel> catalogue_ = AllFurniture();
};

Eigen::AlignedBox3f Bounds(const PaintedMesh& mesh) {
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : mesh.vertices) bounds.extend(vertex);
  return bounds;
}

/// Largest distance from a turned vertex to the nearest vertex of the mesh.
float TurnedDistance(const PaintedMesh& mesh, double angle) {
  const Eigen::AngleAxisf turn(static_cast<float>(angle), Vector3f::UnitZ());
  float worst = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 7) {
    const Vector3f turned = turn * mesh.vertices[i];
    float nearest = 1;
    for (const Vector3f& other : mesh.vertices)
      nearest = std::min(nearest, (turned - other).squaredNorm());
    worst = std::max(worst, nearest);
  }
  return std::sqrt(worst);
}

TEST_F(Furniture, StandsOnTheFloorWithItsFootprintAroundTheOrigin) {
  for (const FurnitureModel& model : catalogue_) {
    const Eigen::AlignedBox3f bounds = Bounds(model.body.mesh);
    EXPECT_NEAR(bounds.min().z(), 0, 1e-6) << model.name;
    EXPECT_NEAR(bounds.center().head<2>().norm(), 0, 1e-5) << model.name;
    EXPECT_LT(bounds.sizes().maxCoeff(), 2.2) << model.name;
  }
}

TEST_F(Furniture, HasAThousandToFiveThousandFacesAndMatchingAttributes) {
  for (const FurnitureModel& model : catalogue_) {
    const PaintedMesh& mesh = model.body.mesh;
    EXPECT_GE(mesh.triangles.size(), 1000u) << model.name;
    EXPECT_LE(mesh.triangles.size(), 5000u) << model.name;
    EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());
    EXPECT_EQ(mesh.texture.size(), mesh.vertices.size());
    EXPECT_EQ(mesh.paints.size(), mesh.triangles.size());
    for (const int paint : mesh.paints)
      EXPECT_LT(paint, static_cast<int>(model.body.materials.size()));
    for (const Vector3f& normal : mesh.normals) ASSERT_NEAR(normal.norm(), 1, 1e-3) << model.name;
  }
}

TEST_F(Furniture, FacesTurnOutwards) {
  for (const FurnitureModel& model : catalogue_) {
    const PaintedMesh& mesh = model.body.mesh;
    double agree = 0, area = 0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Vector3f face = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
      const Vector3f normal = mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]];
      area += face.norm();
      if (face.dot(normal) > 0) agree += face.norm();
    }
    EXPECT_GT(agree / area, 0.999) << model.name;
  }
}

TEST_F(Furniture, HasTheSymmetryThatItsModelClaims) {
  const double turn = 2 * std::numbers::pi;
  for (const FurnitureModel& model : catalogue_) {
    SCOPED_TRACE(model.name);
    if (model.symmetry_order == 0) {
      // The numbers of segments of the lathes are multiples of 8.
      EXPECT_LT(TurnedDistance(model.body.mesh, turn / 8), 1e-4f);
    } else {
      // Vertices around a bar may lie a fraction of a segment further on.
      EXPECT_LT(TurnedDistance(model.body.mesh, turn / model.symmetry_order), 0.006f);
      EXPECT_GT(TurnedDistance(model.body.mesh, turn / (2 * model.symmetry_order)), 0.02f);
    }
  }
}

TEST_F(Furniture, OffersSimilarShapesOfOneCategory) {
  std::map<std::string, int> counts;
  std::set<std::string> names;
  for (const FurnitureModel& model : catalogue_) {
    ++counts[model.category];
    EXPECT_TRUE(names.insert(model.name).second);
  }
  EXPECT_GE(counts["chair"], 3);
  EXPECT_GE(counts["dining table"], 2);
  EXPECT_GE(counts["couch"], 1);
  EXPECT_GE(counts["tv"], 1);
  EXPECT_GE(counts["cabinet"], 1);
  EXPECT_GE(counts["lamp"], 1);
}

TEST_F(Furniture, OfAnOfficeComesInOtherCategoriesAndScales) {
  std::set<std::string> categories;
  float lowest = 10, highest = 0;
  for (const FurnitureModel& model : OfficeCatalogue(PaletteOfSeed(3))) {
    categories.insert(model.category);
    const float height = Bounds(model.body.mesh).max().z();
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  EXPECT_TRUE(categories.contains("desk") && categories.contains("shelf") &&
              categories.contains("potted plant"));
  EXPECT_LT(lowest, 0.4f);
  EXPECT_GT(highest, 1.9f);
}

TEST_F(Furniture, TwinsDifferInTheirArmRestsOnly) {
  const auto find = [&](const std::string& name) -> const PaintedMesh& {
    return std::find_if(catalogue_.begin(), catalogue_.end(),
                        [&](const FurnitureModel& model) { return model.name == name; })
        ->body.mesh;
  };
  for (const auto& [plain_name, armed_name] : {std::pair("chair_slat", "chair_slat_arms"),
                                               std::pair("chair_office_plain", "chair_office")}) {
    const PaintedMesh &plain = find(plain_name), &armed = find(armed_name);
    ASSERT_LT(plain.vertices.size(), armed.vertices.size());
    // What they share comes first; the centre of the footprint may differ.
    const Vector3f shift = armed.vertices.front() - plain.vertices.front();
    EXPECT_LT(shift.norm(), 0.03f);
    for (std::size_t i = 0; i < plain.vertices.size(); ++i)
      ASSERT_LT((armed.vertices[i] - plain.vertices[i] - shift).norm(), 1e-5f) << armed_name;
    const float seat = 0.42f;
    for (std::size_t i = plain.vertices.size(); i < armed.vertices.size(); ++i)
      ASSERT_GT(armed.vertices[i].z(), seat - 0.04f) << armed_name;
  }
}

TEST_F(Furniture, BecomesAModelDatabase) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteModels(folder.path(), catalogue_).ok());
  const auto database = ModelDatabase::Load(folder.path());
  ASSERT_TRUE(database.ok()) << database.error().message;
  ASSERT_EQ((*database)->models().size(), catalogue_.size());
  for (std::size_t i = 0; i < catalogue_.size(); ++i) {
    const CadModel& model = (*database)->models()[i];
    EXPECT_EQ(model.name, catalogue_[i].name);
    EXPECT_EQ(model.category, catalogue_[i].category);
    EXPECT_EQ(model.symmetry.order, catalogue_[i].symmetry_order);
    EXPECT_EQ(model.support, catalogue_[i].support);
    EXPECT_EQ(model.back, catalogue_[i].back);
    EXPECT_EQ(model.mesh.triangles.size(), catalogue_[i].body.mesh.triangles.size());
    EXPECT_EQ(model.mesh.colors.size(), model.mesh.vertices.size());
  }
}

}  // namespace
}  // namespace plumbline
