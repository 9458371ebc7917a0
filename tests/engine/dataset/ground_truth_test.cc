// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/ground_truth.h"

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/geometry/angles.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

constexpr const char* kPose = "[[0,-1,0,1],[1,0,0,2],[0,0,1,3],[0,0,0,1]]";

class GroundTruthFile : public testing::Test {
 protected:
  std::string Refusal(const std::string& text) {
    WriteText(file_, text);
    const Result<GroundTruth> truth = ReadGroundTruth(file_);
    return truth.ok() ? "accepted" : truth.error().message;
  }
  std::string Instance(const std::string& id, const std::string& pose,
                       const std::string& quality = "fine") {
    return R"({"id": ")" + id + R"(", "model": "m", "category": "chair", "quality": ")" + quality +
           R"(", "world_from_object": )" + pose + "}";
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "ground_truth.json";
};

TEST_F(GroundTruthFile, SurvivesARoundTrip) {
  GroundTruth truth;
  truth.gravity_in_world = Eigen::Vector3d(0.1, 0.2, -1).normalized();
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()));
  pose.translation() << 1.25, -2, 1e-7;
  truth.instances = {{"a", "chair", "chair", pose, true},
                     {"b", "table", "dining table", pose.inverse(), false}};
  ASSERT_TRUE(WriteGroundTruth(file_, truth).ok());
  const Result<GroundTruth> read = ReadGroundTruth(file_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->instances.size(), 2u);
  EXPECT_TRUE(read->gravity_in_world.isApprox(truth.gravity_in_world, 1e-15));
  EXPECT_THAT(read->instances[1].world_from_object, IsometryNear(pose.inverse(), 1e-9, 1e-12));
  EXPECT_EQ(read->instances[1].category, "dining table");
  EXPECT_FALSE(read->instances[1].fine);
}

TEST_F(GroundTruthFile, SaysHowWellAPoseIsKnown) {
  GroundTruth truth;
  GroundTruthInstance fine{"a", "chair", "chair"}, coarse{"b", "chair", "chair"}, exact = fine;
  coarse.fine = false;
  exact.id = "c";
  exact.position_std_m = exact.azimuth_std_rad = 0;
  truth.instances = {fine, coarse, exact};
  ASSERT_TRUE(WriteGroundTruth(file_, truth).ok());
  const GroundTruth read = ReadGroundTruth(file_).value();
  EXPECT_NEAR(DeviationOf(read.instances[0]).position_m, 0.015, 1e-12);
  EXPECT_NEAR(DeviationOf(read.instances[1]).azimuth_rad, 3 * kRadPerDeg, 1e-12);
  EXPECT_EQ(DeviationOf(read.instances[2]).position_m, 0);
  EXPECT_EQ(DeviationOf(read.instances[2]).azimuth_rad, 0);
  EXPECT_THAT(
      Refusal(R"({"gravity": [0,0,-1], "instances": [{"id": "a", "model": "m", "category": "c",
      "position_std_m": -1, "world_from_object": )" +
              std::string(kPose) + "}]}"),
      HasSubstr("'position_std_m'"));
}

TEST_F(GroundTruthFile, KeepsWhatMovesApart) {
  GroundTruth truth;
  truth.instances = {{"a", "car_sedan", "car"}};
  MovingThing van;
  van.id = "van";
  van.category = "car";
  van.size_m = {5, 2, 2.1};
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  pose.translation() << 10, -1.5, 0;
  van.places = {{3, pose}, {4, pose * Eigen::Translation3d(1, 0, 0)}};
  truth.moving = {van};
  ASSERT_TRUE(WriteGroundTruth(file_, truth).ok());
  const Result<GroundTruth> read = ReadGroundTruth(file_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->instances.size(), 1u);
  ASSERT_EQ(read->moving.size(), 1u);
  EXPECT_EQ(read->moving[0].id, "van");
  EXPECT_LT((read->moving[0].size_m - van.size_m).norm(), 1e-12);
  ASSERT_EQ(read->moving[0].places.size(), 2u);
  EXPECT_EQ(read->moving[0].places[1].frame, 4);
  EXPECT_THAT(read->moving[0].places[0].world_from_object, IsometryNear(pose, 1e-9, 1e-9));
  const std::string before = R"({"gravity": [0,0,-1], "instances": [], "moving": )";
  EXPECT_THAT(Refusal(before + "3}"), HasSubstr("'moving'"));
  EXPECT_THAT(Refusal(before + R"([{"id": "v"}]})"), HasSubstr("'category'"));
  EXPECT_THAT(Refusal(before + R"([{"id": "v", "category": "car", "poses": []}]})"),
              HasSubstr("'size_m'"));
  EXPECT_THAT(Refusal(before + R"([{"id": "v", "category": "car", "size_m": [1,1,1]}]})"),
              HasSubstr("'poses'"));
  EXPECT_THAT(Refusal(before + R"([{"id": "v", "category": "car", "size_m": [1,1,1],
                                   "poses": [{"frame": 0.5, "world_from_object": )" +
                      std::string(kPose) + "}]}]}"),
              HasSubstr("frame"));
}

TEST_F(GroundTruthFile, SaysHowMuchLargerThanItsModelAnInstanceIs) {
  GroundTruth truth;
  truth.instances = {{"a", "chair", "chair"}, {"b", "chair", "chair"}};
  truth.instances[1].scale = 1.04;
  ASSERT_TRUE(WriteGroundTruth(file_, truth).ok());
  const GroundTruth read = ReadGroundTruth(file_).value();
  EXPECT_EQ(read.instances[0].scale, 1);
  EXPECT_EQ(read.instances[1].scale, 1.04);
  for (const char* wrong : {"0", "-1", "\"large\"", "20"}) {
    EXPECT_THAT(
        Refusal(R"({"gravity": [0,0,-1], "instances": [{"id": "a", "model": "m", "category": "c",
        "scale": )" +
                std::string(wrong) + R"(, "world_from_object": )" + kPose + "}]}"),
        HasSubstr("'scale'"))
        << wrong;
  }
}

TEST_F(GroundTruthFile, KeepsTheSizeOfABox) {
  GroundTruth truth;
  GroundTruthInstance car{"a", "car", "car"}, chair{"b", "chair", "chair"};
  car.size_m = Eigen::Vector3d(4.2, 1.8, 1.5);
  truth.instances = {car, chair};
  ASSERT_TRUE(WriteGroundTruth(file_, truth).ok());
  const GroundTruth read = ReadGroundTruth(file_).value();
  EXPECT_EQ(read.instances[0].size_m, car.size_m);
  EXPECT_FALSE(read.instances[1].size_m.has_value());
  std::string text = ReadFile(file_).value();
  text.replace(text.find("1.8"), 3, "-18");
  EXPECT_THAT(Refusal(text), HasSubstr("(a) has a 'size_m'"));
}

TEST_F(GroundTruthFile, RefusesWhatIsWrongAndNamesTheInstance) {
  const std::string head = R"({"gravity": [0,0,-1], "instances": [)";
  EXPECT_EQ(Refusal(head + Instance("a", kPose) + "]}"), "accepted");
  EXPECT_THAT(Refusal(head + Instance("a", kPose) + "," + Instance("a", kPose) + "]}"),
              HasSubstr("two instances"));
  EXPECT_THAT(Refusal(head + Instance("bad", "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]") + "]}"),
              HasSubstr("(bad)"));
  EXPECT_THAT(Refusal(head + Instance("bad", "[[1,0,0],[0,1,0],[0,0,1]]") + "]}"),
              HasSubstr("(bad)"));
  EXPECT_THAT(Refusal(head + Instance("bad", "null") + "]}"), HasSubstr("(bad)"));
  EXPECT_THAT(
      Refusal(head + Instance("bad", "[[1,0,0,1e300],[0,1,0,0],[0,0,1,0],[0,0,0,1]]") + "]}"),
      HasSubstr("within 1000 km"));
  EXPECT_THAT(Refusal(head + Instance("bad", kPose, "super") + "]}"), HasSubstr("quality"));
  EXPECT_THAT(Refusal(head + R"({"id": 3}]})"), HasSubstr("instance 0"));
  EXPECT_THAT(Refusal(head + "7]}"), HasSubstr("instance 0"));
  EXPECT_THAT(Refusal(R"({"gravity": [0,0,0], "instances": []})"), HasSubstr("gravity"));
  EXPECT_THAT(Refusal(R"({"instances": []})"), HasSubstr("gravity"));
  EXPECT_THAT(Refusal("[]"), HasSubstr(file_.string()));
  EXPECT_THAT(Refusal(head), HasSubstr("not valid JSON"));
}

TEST(GroundTruth, ReadsTheKitchen) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const Result<GroundTruth> truth = ReadGroundTruth(*shared / "data/kitchen/ground_truth.json");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_EQ(truth->instances.size(), 11u);
  EXPECT_EQ(truth->instances[0].id, "chair_A");
  EXPECT_TRUE(truth->instances[0].fine);
  EXPECT_FALSE(truth->instances[1].fine);
}

}  // namespace
}  // namespace plumbline
