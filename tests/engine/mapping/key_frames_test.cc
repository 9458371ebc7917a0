// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/key_frames.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <opencv2/core.hpp>
#include <set>

#include "tests/support/mapping_scene.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Not;

MapperInput At(int frame, double x, double turn_deg = 0) {
  MapperInput input;
  input.frame = frame;
  input.world_from_cam = LookAt({x, -3, 1.4}, {x, 0, 0.4});
  input.world_from_cam.rotate(
      Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitY()));
  return input;
}

std::vector<int> Frames(const KeyFrameMemory& memory) {
  std::vector<int> frames;
  for (const KeyFrame& key : memory.frames()) frames.push_back(key.input.frame);
  return frames;
}

class KeyFramesTest : public testing::Test {
 protected:
  KeyFrameMemory Memory(int size) {
    options_.key_frames = size;
    options_.key_frame_distance_m = 0.2;
    options_.key_frame_angle_deg = 12;
    return {scene_.camera(), options_};
  }
  MappingScene& scene_ = MappingScene::Get();
  MapperOptions options_;
};

TEST_F(KeyFramesTest, KeepsFramesThatShowSomethingNew) {
  KeyFrameMemory memory = Memory(10);
  memory.Offer(At(0, 0));
  memory.Offer(At(1, 0.1));
  memory.Offer(At(2, 0.19, 5));
  memory.Offer(At(3, 0.21));
  memory.Offer(At(4, 0.21, 11));
  memory.Offer(At(5, 0.21, 13));
  memory.Offer(At(6, 0.02));
  EXPECT_THAT(Frames(memory), ElementsAre(0, 3, 5));
}

TEST_F(KeyFramesTest, AMemoryOfOneKeepsTheNewest) {
  KeyFrameMemory memory = Memory(1);
  for (int i = 0; i < 10; ++i) memory.Offer(At(i, 0.15 * i));
  EXPECT_THAT(Frames(memory), ElementsAre(8));
}

TEST_F(KeyFramesTest, KeepsWhatIsNeededAsLongAsThereIsRoomForMore) {
  const auto walk = [&](const std::set<int>& needed) {
    KeyFrameMemory memory = Memory(8);
    for (int i = 0; i < 3; ++i) memory.Offer(At(i, 0.25 * i), needed);  // nearest to each other
    for (int i = 3; i < 30; ++i) memory.Offer(At(i, 0.5 * i), needed);
    EXPECT_EQ(memory.frames().size(), 8u);
    return Frames(memory);
  };
  EXPECT_THAT(walk({}), Not(AllOf(Contains(0), Contains(1), Contains(2))));
  EXPECT_THAT(walk({0, 1, 2}), AllOf(Contains(0), Contains(1), Contains(2)));
  // All that came first would leave no room for what is new.
  EXPECT_THAT(walk({0, 1, 2, 3, 4, 5, 6, 7}), Contains(testing::Ge(20)));
}

TEST_F(KeyFramesTest, ShrinksWhenTheOptionsSaySo) {
  KeyFrameMemory memory = Memory(8);
  for (int i = 0; i < 8; ++i) memory.Offer(At(i, i));
  options_.key_frames = 4;
  memory.SetOptions(options_);
  memory.Offer(At(9, 9));
  EXPECT_EQ(memory.frames().size(), 4u);
}

TEST_F(KeyFramesTest, DrawsObjectsThatMovedAgain) {
  KeyFrameMemory memory = Memory(4);
  memory.Offer(At(0, 0));
  memory.Offer(At(1, 0.5));
  std::vector<PlacedModel> objects = {scene_.Place("chair", 0.2, 0, 30, 4)};
  memory.UpdateOcclusion(scene_.renderer(), objects);
  const cv::Mat before = memory.frames()[0].maps.rendered().id.clone();
  EXPECT_GT(cv::countNonZero(before == 4), 100);
  objects[0].world_from_object.translation().x() += 0.01;
  memory.UpdateOcclusion(scene_.renderer(), objects);
  EXPECT_EQ(cv::countNonZero(memory.frames()[0].maps.rendered().id != before), 0) << "hardly moved";
  objects[0].world_from_object.translation().x() += 0.3;
  memory.UpdateOcclusion(scene_.renderer(), objects);
  EXPECT_GT(cv::countNonZero(memory.frames()[0].maps.rendered().id != before), 100);
  memory.UpdateOcclusion(scene_.renderer(), {});
  EXPECT_TRUE(memory.frames()[1].maps.rendered().id.empty());
}

TEST_F(KeyFramesTest, DrawsWhatMovedOnlyWhereItMayShow) {
  KeyFrameMemory memory = Memory(4);
  memory.Offer(At(0, 0));
  memory.Offer(At(1, 9.0));
  std::vector<PlacedModel> objects = {scene_.Place("chair", 0.2, 0, 30, 4),
                                      scene_.Place("table", 9.0, 0, 80, 9)};
  memory.UpdateOcclusion(scene_.renderer(), objects);
  const auto drawn = [&](std::size_t i) { return memory.frames()[i].maps.rendered().id; };
  const cv::Mat chair = drawn(0), table = drawn(1);
  EXPECT_GT(cv::countNonZero(chair == 4), 100);
  EXPECT_GT(cv::countNonZero(table == 9), 100);
  objects[1].world_from_object.translation().x() += 0.3;
  memory.UpdateOcclusion(scene_.renderer(), objects);
  EXPECT_EQ(drawn(0).data, chair.data) << "the same picture";
  EXPECT_GT(cv::countNonZero(drawn(1) != table), 100);
  // What comes into view is drawn, and so is what leaves it.
  objects[1].world_from_object.translation().x() = -0.4;
  memory.UpdateOcclusion(scene_.renderer(), objects);
  EXPECT_GT(cv::countNonZero(drawn(0) == 9), 100);
  EXPECT_EQ(cv::countNonZero(drawn(1)), 0);
  // A corrected pose shows something else.
  memory.Correct({PoseId{}, 0, At(0, 0.3).world_from_cam, {}, 1});
  const cv::Mat before = drawn(0);
  memory.UpdateOcclusion(scene_.renderer(), objects);
  EXPECT_GT(cv::countNonZero(drawn(0) != before), 100);
}

TEST_F(KeyFramesTest, ComesBackFromBytes) {
  KeyFrameMemory memory = Memory(4);
  for (int i = 0; i < 6; ++i) memory.Offer(At(i, 0.5 * i));
  memory.UpdateOcclusion(scene_.renderer(), {scene_.Place("chair", 0.7, 0, 30, 4),
                                             scene_.Place("table", 1.5, 0.4, 80, 9)});
  memory.Offer(At(7, 9.0));  // not drawn into yet
  const std::string bytes = memory.Save();
  const auto load = [](int frame) -> Result<MapperInput> {
    return At(frame, frame == 7 ? 9.0 : 0.5 * frame);
  };
  KeyFrameMemory restored = Memory(4);
  ASSERT_TRUE(restored.Restore(bytes, load, scene_.renderer()).ok());
  EXPECT_EQ(restored.Save(), bytes);
  ASSERT_EQ(Frames(restored), Frames(memory));
  for (std::size_t i = 0; i < memory.frames().size(); ++i) {
    const KeyFrame &a = memory.frames()[i], &b = restored.frames()[i];
    EXPECT_EQ(a.maps.rendered().id.empty(), b.maps.rendered().id.empty());
    if (a.maps.rendered().id.empty()) continue;
    EXPECT_EQ(cv::countNonZero(a.maps.rendered().id != b.maps.rendered().id), 0);
    EXPECT_EQ(cv::countNonZero(a.maps.rendered().depth != b.maps.rendered().depth), 0);
    EXPECT_EQ(cv::countNonZero(a.maps.rendered().second_depth != b.maps.rendered().second_depth),
              0);
  }
}

TEST_F(KeyFramesTest, TheNarrowTableIsThatOfANarrowerSearch) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  MapperInput input = scene_.Input(0, LookAt({2.2, 0.6, 1.4}, {0, 0, 0.4}), {&chair, 1});
  options_.search_sigma_px = 2.5;
  options_.far_search_sigma_px = 1;
  MakeTables(options_, scene_.camera().fx, input);
  OrientedTableOptions narrow = SearchOptions(options_, scene_.camera().fx);
  narrow.sigma_px *= 1 / 2.5;
  const OrientedTable wanted(input.edges, narrow);
  const OrientedTable& table = input.narrow_table->Get();
  EXPECT_EQ(&table, &input.narrow_table->Get()) << "made once";
  const std::size_t cells = static_cast<std::size_t>(table.width()) * table.height() * 16;
  EXPECT_TRUE(std::equal(table.cells(), table.cells() + cells, wanted.cells()));
  int narrower = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    EXPECT_LE(table.cells()[i], input.table->cells()[i]);
    narrower += table.cells()[i] < input.table->cells()[i] ? 1 : 0;
  }
  EXPECT_GT(narrower, 10000);
}

TEST_F(KeyFramesTest, WhatIsAfarDependsOnDepthAndOnHowLargeThingsAre) {
  MapFrame map = scene_.map();
  options_.far_m = 2.5;
  const PoseHypothesis chair = scene_.Hypothesis(scene_.Place("chair", 0, 0, 30));
  const auto afar = [&](double distance_m) {
    const Eigen::Vector3d from = chair.center_in_world + Eigen::Vector3d(0.6, 0.8, 0) * distance_m;
    return IsAfar(map, chair, LookAt(from, chair.center_in_world).inverse(), options_);
  };
  EXPECT_FALSE(afar(2.49));
  EXPECT_TRUE(afar(2.51));
  CadModel car;
  car.name = car.category = "car";
  car.mesh = MakeBox({-2.2f, -0.9f, 0}, {2.2f, 0.9f, 1.5f});
  car.bounds = BoundingBox(car.mesh);
  map.database = ModelDatabase::FromModels({car});
  const PoseHypothesis there{ModelId{0}, 0, {0, 0, 0.75}};
  EXPECT_FALSE(IsAfar(map, there, LookAt({12, 0, 1.5}, {0, 0, 0.75}).inverse(), options_))
      << "models of cars err by more";
}

TEST_F(KeyFramesTest, DamagedBytesAndMissingFramesAreErrors) {
  KeyFrameMemory memory = Memory(4);
  memory.Offer(At(0, 0));
  memory.UpdateOcclusion(scene_.renderer(), {scene_.Place("chair", 0, 0, 30, 4)});
  const std::string bytes = memory.Save();
  const auto load = [](int frame) -> Result<MapperInput> { return At(frame, 0); };
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    KeyFrameMemory restored = Memory(4);
    const Status status = restored.Restore(bytes.substr(0, size), load, scene_.renderer());
    ASSERT_FALSE(status.ok()) << size;
    EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
  }
  KeyFrameMemory restored = Memory(4);
  const Status status = restored.Restore(
      bytes,
      [](int) -> Result<MapperInput> {
        return Error{ErrorCode::kNotFound, "frame 0 is gone"};
      },
      scene_.renderer());
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "frame 0 is gone");
}

}  // namespace
}  // namespace plumbline
