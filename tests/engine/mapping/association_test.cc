// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/association.h"

#include <gmock/gmock.h>

#include <numbers>

#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

/// Image 200x160; maps at half size. Object 1, a chair, fills columns 40..79 and rows 20..99 of the
/// image; object 2, a table, rows 100..139.
class AssociationTest : public testing::Test {
 protected:
  AssociationTest() {
    maps_.id = cv::Mat::zeros(80, 100, CV_16U);
    maps_.id(cv::Rect(20, 10, 20, 40)).setTo(1);
    maps_.id(cv::Rect(10, 50, 80, 20)).setTo(2);
    objects_.push_back(Object(1, "chair", 0, 0, 0));
    objects_.push_back(Object(2, "table", 2, 0, 0));
  }
  MapObject Object(int id, const char* model, double x, double y, double azimuth_rad) const {
    MapObject object;
    object.id = ObjectId{id};
    object.state = ObjectState::kConfirmed;
    PoseMode mode;
    mode.label = map_.database->Find(model).value();
    object.category = map_.database->model(mode.label).category;
    mode.world_from_object.linear() = map_.upright.WorldFromObjectRotation(azimuth_rad);
    mode.world_from_object.translation() = Eigen::Vector3d(x, y, 0);
    object.modes = {mode};
    object.updated = true;
    return object;
  }
  ProposalReport Explain(const Box2& box, const char* category, float score = 0.9f) const {
    return Explain({{box, category, score}}).front();
  }
  std::vector<ProposalReport> Explain(const std::vector<Detection>& proposals) const {
    return ExplainProposals(proposals, objects_, MatchProposals(proposals, objects_, maps_), maps_,
                            *map_.database, options_);
  }
  /// For each object the number of its proposal, -1 for none.
  std::vector<int> Matched(const std::vector<Detection>& proposals) const {
    std::vector<int> numbers;
    for (const auto& match : MatchProposals(proposals, objects_, maps_))
      numbers.push_back(match ? static_cast<int>(*match) : -1);
    return numbers;
  }

  MapFrame map_{UprightFrame({0, 0, -1}), Eigen::Vector4d(0, 0, 1, 0), MakeFurnitureDatabase()};
  RenderedMaps maps_;
  std::vector<MapObject> objects_;
  MapperOptions options_;
};

TEST_F(AssociationTest, AnObjectExplainsItsBox) {
  const ProposalReport report = Explain({40, 20, 79, 99}, "chair");
  EXPECT_EQ(report.fate, ProposalFate::kExplained);
  EXPECT_EQ(report.object, ObjectId{1});
  EXPECT_EQ(report.category, "chair");
  EXPECT_EQ(report.box, (Box2{40, 20, 79, 99}));
}

TEST_F(AssociationTest, AnObjectExplainsPartsOfItsBox) {
  EXPECT_EQ(Explain({40, 20, 79, 55}, "chair").object, ObjectId{1});
  EXPECT_EQ(Explain({40, 60, 79, 99}, "chair").object, ObjectId{1});
}

TEST_F(AssociationTest, AnObjectExplainsABoxThatIsTooLarge) {
  EXPECT_EQ(Explain({20, 5, 110, 120}, "chair").object, ObjectId{1})
      << "most of its mask is inside";
}

TEST_F(AssociationTest, ABoxElsewhereIsNotExplained) {
  EXPECT_EQ(Explain({120, 20, 159, 90}, "chair").fate, ProposalFate::kSpawned);
  EXPECT_EQ(Explain({72, 20, 140, 99}, "chair").fate, ProposalFate::kSpawned) << "touches only";
}

TEST_F(AssociationTest, AnotherCategoryExplainsOnlyTheSameBox) {
  EXPECT_EQ(Explain({40, 20, 79, 55}, "suitcase").fate, ProposalFate::kSpawned);
  EXPECT_EQ(Explain({41, 21, 78, 98}, "suitcase").fate, ProposalFate::kExplained)
      << "one thing, two names";
  EXPECT_EQ(Explain({20, 100, 179, 139}, "chair").fate, ProposalFate::kExplained);
}

TEST_F(AssociationTest, PrefersTheObjectOfTheProposalsCategory) {
  maps_.id(cv::Rect(42, 10, 20, 40)).setTo(3);
  objects_.push_back(Object(3, "crate", 1, 1, 0));
  // Both masks lie in the box; the chair is a chair.
  EXPECT_EQ(Explain({40, 20, 123, 99}, "chair").object, ObjectId{1});
  EXPECT_EQ(Explain({40, 20, 123, 99}, "suitcase").object, ObjectId{3});
}

TEST_F(AssociationTest, ATentativeObjectExplainsABoxThatItMeetsInPart) {
  const Box2 box{50, 66, 100, 114};
  objects_[0].state = ObjectState::kConfirmed;
  EXPECT_EQ(Explain(box, "chair").fate, ProposalFate::kSpawned);
  objects_[0].state = ObjectState::kTentative;
  EXPECT_EQ(Explain(box, "chair").object, ObjectId{1});
}

TEST_F(AssociationTest, EachObjectHasOneProposalAtMost) {
  const Box2 whole{40, 20, 79, 99}, upper{40, 20, 79, 60};
  EXPECT_THAT(Matched({{upper, "chair", 0.9f}, {whole, "chair", 0.8f}}),
              testing::ElementsAre(1, -1));
  // The other one is a part of it.
  EXPECT_EQ(Explain({{upper, "chair", 0.9f}, {whole, "chair", 0.8f}})[0].object, ObjectId{1});
  EXPECT_THAT(Matched({{whole, "table", 0.9f}}), testing::ElementsAre(-1, -1))
      << "not its category";
  EXPECT_THAT(Matched({}), testing::ElementsAre(-1, -1));
}

TEST_F(AssociationTest, ObjectsInARowDoNotShareAProposal) {
  // Three chairs that overlap in the image; the middle one has two boxes within reach.
  maps_.id.setTo(0);
  for (int i = 0; i < 3; ++i) maps_.id(cv::Rect(10 + 20 * i, 10, 22, 40)).setTo(11 + i);
  objects_ = {Object(11, "chair", 0, 0, 0), Object(12, "chair", 0.55, 0, 0),
              Object(13, "chair", 1.1, 0, 0)};
  const std::vector<Detection> boxes = {{{22, 20, 64, 99}, "chair", 0.5f},
                                        {{58, 20, 100, 99}, "chair", 0.5f},
                                        {{100, 20, 142, 99}, "chair", 0.9f}};
  EXPECT_THAT(Matched(boxes), testing::ElementsAre(0, 1, 2));
  // Without a box of its own the middle one takes none of its neighbours'.
  EXPECT_THAT(Matched({boxes[0], boxes[2]}), testing::ElementsAre(0, -1, 1));
}

TEST_F(AssociationTest, AnObjectInFrontIsNotExplainedByTheOneThatItHides) {
  // Half of the mapped chair shows in the box of a large chair in front of it.
  maps_.id.setTo(0);
  maps_.id(cv::Rect(20, 10, 10, 20)).setTo(1);
  const std::vector<Detection> boxes = {{{40, 20, 59, 59}, "chair", 0.6f},
                                        {{44, 22, 150, 140}, "chair", 0.8f}};
  const std::vector<ProposalReport> reports = Explain(boxes);
  EXPECT_EQ(reports[0].object, ObjectId{1});
  EXPECT_EQ(reports[1].fate, ProposalFate::kSpawned);
}

TEST_F(AssociationTest, WhatIsSettledComesFirst) {
  // A tentative double explains the box a little better.
  maps_.id(cv::Rect(20, 10, 20, 38)).setTo(1);
  maps_.id(cv::Rect(20, 48, 20, 2)).setTo(0);
  maps_.id(cv::Rect(19, 9, 22, 1)).setTo(5);
  maps_.id(cv::Rect(19, 49, 22, 1)).setTo(5);
  objects_.push_back(Object(5, "chair", 0.02, 0, 0));
  objects_.back().state = ObjectState::kTentative;
  const auto matched = Matched({{{38, 18, 81, 99}, "chair", 0.8f}});
  EXPECT_EQ(matched[0], 0);
  EXPECT_EQ(matched[2], -1);
}

TEST_F(AssociationTest, AHiddenObjectExplainsNothing) {
  maps_.id.setTo(0, maps_.id == 1);
  EXPECT_EQ(Explain({40, 20, 79, 99}, "chair").fate, ProposalFate::kSpawned);
  maps_ = {};
  EXPECT_EQ(Explain({40, 20, 79, 99}, "chair").fate, ProposalFate::kSpawned);
}

TEST_F(AssociationTest, NamesWhyAProposalGivesNoBirth) {
  EXPECT_EQ(Explain({120, 20, 159, 90}, "elephant").fate, ProposalFate::kUnknownCategory);
  EXPECT_EQ(Explain({120, 20, 159, 90}, "chair", 0.1f).fate, ProposalFate::kLowScore);
}

TEST_F(AssociationTest, BoxesBeyondTheImageDoNoHarm) {
  EXPECT_EQ(Explain({-50, -50, -10, -10}, "chair").fate, ProposalFate::kSpawned);
  EXPECT_EQ(Explain({-500, -500, 90, 130}, "chair").object, ObjectId{1});
}

TEST_F(AssociationTest, ObjectsOfOneCategoryWithSharedFootprintsCompete) {
  EXPECT_TRUE(Compete(Object(1, "chair", 0, 0, 0), Object(2, "armchair", 0.1, 0.1, 1), map_));
  EXPECT_FALSE(Compete(Object(1, "chair", 0, 0, 0), Object(2, "chair", 0.48, 0, 0), map_));
  EXPECT_FALSE(Compete(Object(1, "chair", 0, 0, 0), Object(2, "table", 0.1, 0.1, 0), map_))
      << "a chair may stand under a table";
}

TEST_F(AssociationTest, ConfirmedObjectsThatReachIntoEachOtherCompete) {
  MapObject a = Object(1, "chair", 0, 0, 0), b = Object(2, "chair", 0.38, 0, 0);
  a.updated = false;  // boxes do not speak
  EXPECT_TRUE(Compete(a, b, map_));
  b.state = ObjectState::kTentative;  // it may still be a hand's breadth off
  EXPECT_FALSE(Compete(a, b, map_));
}

TEST_F(AssociationTest, ObjectsOnTopOfEachOtherDoNotCompete) {
  MapObject upper = Object(2, "crate", 0, 0, 0);
  upper.modes[0].world_from_object.translation().z() = 0.35;
  EXPECT_FALSE(Compete(Object(1, "crate", 0, 0, 0), upper, map_));
  upper.modes[0].world_from_object.translation().z() = 0.2;
  EXPECT_TRUE(Compete(Object(1, "crate", 0, 0, 0), upper, map_));
}

TEST_F(AssociationTest, TwinsThatExplainTheSamePartOfTheImageCompete) {
  // A chair whose back rest alone shows, and the one turned by 180 degrees about the back rest.
  MapObject a = Object(1, "chair", 0, 0, 0), b = Object(2, "chair", -0.41, 0, std::numbers::pi);
  a.visible_box = {100, 50, 150, 90};
  b.visible_box = {103, 52, 152, 91};
  EXPECT_TRUE(Compete(a, b, map_));
  b.visible_box = {140, 52, 190, 91};
  EXPECT_FALSE(Compete(a, b, map_));
  b.visible_box = a.visible_box;
  b.updated = false;
  EXPECT_FALSE(Compete(a, b, map_)) << "its box is of another frame";
}

TEST_F(AssociationTest, ConfirmedNeighboursOfARowDoNotCompeteWhereItIsSeenAlong) {
  MapObject a = Object(1, "chair", 0, 0, 0), b = Object(2, "chair", 0, 0.44, 0);
  a.visible_box = {100, 50, 150, 90};
  b.visible_box = {103, 52, 152, 91};
  EXPECT_FALSE(Compete(a, b, map_));
  b.state = ObjectState::kTentative;  // it may be the same chair, a little further
  EXPECT_TRUE(Compete(a, b, map_));
}

TEST_F(AssociationTest, CompetingDoesNotDependOnTheDirectionOfGravity) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, -1).normalized()));
  MapFrame turned = map_;
  turned.upright = UprightFrame(turn * Eigen::Vector3d(0, 0, -1));
  MapObject a = Object(1, "chair", 0, 0, 0), b = Object(2, "chair", 0.2, 0, 0.5),
            c = Object(3, "chair", 0.6, 0.1, 0.5);
  for (MapObject* object : {&a, &b, &c})
    object->modes[0].world_from_object =
        Eigen::Isometry3d(turn) * object->modes[0].world_from_object;
  EXPECT_TRUE(Compete(a, b, turned));
  EXPECT_FALSE(Compete(a, c, turned));
}

}  // namespace
}  // namespace plumbline
