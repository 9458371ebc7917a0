// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/relations.h"
#include "engine/mapping/map_report.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace plumbline {
namespace {

/// A box from the floor up.
ModelView BoxModel(const char* name, float x, float y, float z) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (const float dx : {-0.5f, 0.5f}) {
    for (const float dy : {-0.5f, 0.5f}) {
      for (const float dz : {0.0f, 1.0f}) mesh->vertices.emplace_back(dx * x, dy * y, dz * z);
    }
  }
  // Vertex 4 i + 2 j + k lies at (x i, y j, z k).
  for (const auto& [a, b, c, d] : {std::array{0, 1, 3, 2},
                                   {4, 6, 7, 5},
                                   {0, 4, 5, 1},
                                   {2, 3, 7, 6},
                                   {0, 2, 6, 4},
                                   {1, 5, 7, 3}}) {
    mesh->triangles.emplace_back(a, b, c);
    mesh->triangles.emplace_back(a, c, d);
  }
  ModelView model;
  model.name = name;
  model.mesh = mesh;
  model.center = Eigen::Vector3d(0, 0, 0.5 * z);
  return model;
}

ObjectReport At(int id, int label, double x, double y, double z) {
  ObjectReport object;
  object.id = {id};
  object.label = {label};
  object.state = ObjectState::kConfirmed;
  object.world_from_object.translation() = Eigen::Vector3d(x, y, z);
  return object;
}

class Relations : public testing::Test {
 protected:
  Relations() {
    view_.models = {BoxModel("sideboard", 1, 0.4f, 0.7f), BoxModel("tv", 0.8f, 0.1f, 0.5f),
                    BoxModel("chair", 0.5f, 0.5f, 1)};
    view_.image_width = 100;
    view_.image_height = 80;
    view_.fx = view_.fy = 80;
    view_.cx = 50;
    view_.cy = 40;
    report_.objects = {At(1, 0, 0, 0, 0), At(2, 1, 0, 0, 0.7), At(3, 2, 1.5, 0, 0)};
  }
  const ObjectRelation* Find(const std::vector<ObjectRelation>& all, RelationKind kind, int a) {
    for (const ObjectRelation& relation : all) {
      if (relation.kind == kind && relation.a.value == a) return &relation;
    }
    return nullptr;
  }
  SequenceView view_;
  FrameReport report_;
};

TEST_F(Relations, TellWhatStandsOnWhatAndWhatIsNear) {
  const auto all = RelationFinder().Find(report_, view_, {}, {});
  ASSERT_NE(Find(all, RelationKind::kStandsOn, 2), nullptr);
  EXPECT_EQ(Find(all, RelationKind::kStandsOn, 2)->b, ObjectId{1});
  EXPECT_EQ(Find(all, RelationKind::kStandsOn, 1), nullptr);
  EXPECT_EQ(Find(all, RelationKind::kStandsOn, 3), nullptr);
  const ObjectRelation* chair = Find(all, RelationKind::kNear, 3);
  ASSERT_NE(chair, nullptr);
  EXPECT_EQ(chair->b, ObjectId{1});
  EXPECT_NEAR(chair->value, 0.75, 1e-5) << "1.5 m less half of both";
  EXPECT_EQ(Find(all, RelationKind::kHides, 1), nullptr) << "without a Z-buffer";
}

TEST_F(Relations, MeasureObjectsAtTheirOwnSizes) {
  report_.objects[0].scale = 1.1;
  report_.objects[1].world_from_object.translation().z() = 0.77;
  report_.objects[2].scale = 0.9;
  const auto all = RelationFinder().Find(report_, view_, {}, {});
  const ObjectRelation* stands = Find(all, RelationKind::kStandsOn, 2);
  ASSERT_NE(stands, nullptr);
  EXPECT_NEAR(stands->value, 0, 1e-5) << "the sideboard is 7 cm higher than its model";
  EXPECT_NEAR(Find(all, RelationKind::kNear, 3)->value, 1.5 - 0.55 - 0.225, 1e-5);
}

TEST_F(Relations, MeasureAChairUnderATableBetweenTheirSurfaces) {
  // A table of a top and four legs; a block of 0.5 x 0.5 x 0.4 m stands half under its top.
  auto table = std::make_shared<TriangleMesh>();
  const auto add = [&](float x, float y, float z, float size_x, float size_y, float size_z) {
    const auto box = BoxModel("", size_x, size_y, size_z).mesh;
    const int base = static_cast<int>(table->vertices.size());
    for (const Eigen::Vector3f& v : box->vertices)
      table->vertices.push_back(v + Eigen::Vector3f(x, y, z));
    for (const auto& t : box->triangles) table->triangles.emplace_back(t.array() + base);
  };
  add(0, 0, 0.7f, 1.6f, 1, 0.04f);
  for (const float x : {-0.75f, 0.75f}) {
    for (const float y : {-0.45f, 0.45f}) add(x, y, 0, 0.06f, 0.06f, 0.7f);
  }
  ModelView model;
  model.mesh = table;
  view_.models = {model, BoxModel("block", 0.5f, 0.5f, 0.4f)};
  report_.objects = {At(1, 0, 0, 0, 0), At(2, 1, 0, 0.5, 0)};
  RelationFinder finder;
  const auto gap = [&] {
    const auto all = finder.Find(report_, view_, {}, {});
    return Find(all, RelationKind::kNear, 1)->value;
  };
  EXPECT_NEAR(gap(), 0.3, 1e-5) << "from the block's top up to the table's";
  report_.objects[1] = At(2, 1, 0.4, 0.5, 0);
  EXPECT_NEAR(gap(), 0.72 - 0.65, 1e-5) << "to the leg beside it";
  report_.objects[1] = At(2, 1, 0, 1, 0);
  EXPECT_NEAR(gap(), std::hypot(0.25, 0.3), 1e-5) << "from edge to edge";
  report_.objects[1] = At(2, 1, 0.75, 0.45, 0);
  EXPECT_NEAR(gap(), 0, 1e-4) << "into a leg";
  // The same turned and moved as a whole.
  const Eigen::Isometry3d moved =
      Eigen::Translation3d(3, -2, 0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  report_.objects = {At(1, 0, 0, 0, 0), At(2, 1, 0.4, 0.5, 0)};
  for (ObjectReport& object : report_.objects)
    object.world_from_object = moved * object.world_from_object;
  EXPECT_NEAR(gap(), 0.72 - 0.65, 1e-5);
}

TEST_F(Relations, TellWhatHidesWhatInTheCamera) {
  // Looking along +y from before the chair; object 3 covers the right half of the picture at 2 m.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  pose.translation() = Eigen::Vector3d(0, -3, 0.5);
  report_.world_from_cam = pose;
  cv::Mat depth = cv::Mat::zeros(40, 50, CV_32F), id = cv::Mat::zeros(40, 50, CV_16U);
  depth(cv::Rect(25, 0, 25, 40)) = 2.0f;
  id(cv::Rect(25, 0, 25, 40)) = 3;
  const auto all = RelationFinder().Find(report_, view_, depth, id);
  const ObjectRelation* hides = Find(all, RelationKind::kHides, 3);
  ASSERT_NE(hides, nullptr);
  EXPECT_NEAR(hides->value, 0.5, 0.26) << "about half of the sideboard or the screen";
}

TEST_F(Relations, LeaveOutWhatIsNotConfirmed) {
  report_.objects[2].state = ObjectState::kTentative;
  report_.objects[1].label = {9};
  EXPECT_TRUE(RelationFinder().Find(report_, view_, {}, {}).empty());
}

}  // namespace
}  // namespace plumbline
