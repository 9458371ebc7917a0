// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "engine/geometry/angles.h"
#include "engine/synthetic/sequence_writer.h"
#include "engine/synthetic/traced_scene.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// A furnished room and what of an instance can be seen from where.
class SeenRoom {
 public:
  explicit SeenRoom(const SyntheticOptions& options)
      : options_(options),
        camera_(SyntheticCamera(options).pinhole),
        room_(FurnishRoom(options).value()),
        walk_(Walk::Plan(room_, options.seed, options.rate_hz).value()),
        scene_(room_.parts) {}

  const Room& room() const { return room_; }
  const Walk& walk() const { return walk_; }
  double TimeOf(int frame) const { return frame / options_.rate_hz; }

  /// Vertices of an instance within the image: of all, and of those that nothing hides.
  struct Count {
    int in_view = 0, visible = 0;
    bool hidden_by_a_model = false;
  };
  Count Look(int frame, int instance) const {
    const Eigen::Isometry3d room_from_cam = walk_.RoomFromCam(TimeOf(frame));
    const Eigen::Isometry3f cam_from_room = room_from_cam.inverse().cast<float>();
    const Vector3f eye = room_from_cam.translation().cast<float>();
    Count count;
    for (const RoomPart& part : room_.parts) {
      if (part.instance != instance) continue;
      for (std::size_t i = 0; i < part.body.mesh.vertices.size(); i += 11) {
        const Vector3f& vertex = part.body.mesh.vertices[i];
        const Eigen::Vector3d in_cam = (cam_from_room * vertex).cast<double>();
        if (in_cam.z() < 0.1) continue;
        const Eigen::Vector2d pixel = camera_.Project(in_cam);
        if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera_.width - 1 ||
            pixel.y() > camera_.height - 1)
          continue;
        ++count.in_view;
        const Vector3f ray = vertex - eye;
        const TracedScene::Hit hit = scene_.Trace(eye, ray.normalized());
        if (!hit.valid()) continue;
        const int first = scene_.triangles()[hit.triangle].instance;
        count.visible += first == instance;
        count.hidden_by_a_model = count.hidden_by_a_model || (first > 0 && first != instance);
      }
    }
    return count;
  }

 private:
  SyntheticOptions options_;
  PinholeCamera camera_;
  Room room_;
  Walk walk_;
  TracedScene scene_;
};

SyntheticOptions SeededOptions(SyntheticScene scene, std::uint64_t seed) {
  SyntheticOptions options = OptionsFor(scene);
  options.seed = seed;
  return options;
}

TEST(Places, WallHidesTheChairForAMinuteWhileTheCameraPointsAtIt) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SyntheticOptions options = SeededOptions(SyntheticScene::kWall, seed);
    const SeenRoom seen(options);
    const int chair = seen.room().main_instance;
    ASSERT_EQ(seen.room().instances[static_cast<std::size_t>(chair - 1)].category, "chair");
    int shown_before = 0, longest = 0, hidden = 0, shown_after = 0;
    for (int frame = 0; frame < options.frames; ++frame) {
      const SeenRoom::Count count = seen.Look(frame, chair);
      EXPECT_GT(count.in_view, 0) << "frame " << frame;
      hidden = count.visible == 0 ? hidden + 1 : 0;
      // Nothing that the mapper could know stands in the way.
      EXPECT_FALSE(hidden > 0 && count.hidden_by_a_model) << "frame " << frame;
      longest = std::max(longest, hidden);
      if (count.visible > 0) ++(longest < 50 * options.rate_hz ? shown_before : shown_after);
    }
    EXPECT_GE(longest, 60 * options.rate_hz) << "seed " << seed;
    EXPECT_GE(shown_before, 15 * options.rate_hz) << "seed " << seed;
    EXPECT_GE(shown_after, 5 * options.rate_hz) << "seed " << seed;
  }
}

TEST(Places, RowsHoldTwelveEqualChairs55CentimetresApart) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Result<Room> room = FurnishRoom(SeededOptions(SyntheticScene::kRows, seed));
    ASSERT_TRUE(room.ok()) << room.error().message;
    std::vector<RoomInstance> chairs;
    for (const RoomInstance& instance : room->instances) {
      if (instance.category == "chair") chairs.push_back(instance);
    }
    ASSERT_EQ(chairs.size(), 12u);
    for (const RoomInstance& chair : chairs) {
      EXPECT_EQ(chair.model, chairs.front().model);
      double nearest = 100;
      for (const RoomInstance& other : chairs) {
        if (other.id != chair.id)
          nearest = std::min(
              nearest,
              (chair.room_from_object.translation() - other.room_from_object.translation()).norm());
      }
      EXPECT_NEAR(nearest, 0.55, 0.005) << chair.id;
    }
  }
}

TEST(Places, RevisitComesBackAfterThreeMinutesAndSixtyMetres) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SyntheticOptions options = SeededOptions(SyntheticScene::kRevisit, seed);
    const SeenRoom seen(options);
    const int table = 1;
    ASSERT_EQ(seen.room().instances.front().category, "dining table");
    std::vector<bool> shown;
    for (int frame = 0; frame < options.frames; ++frame)
      shown.push_back(seen.Look(frame, table).visible > 0);
    const auto left = std::find(shown.begin(), shown.end(), false);
    const auto back = std::find(left, shown.end(), true);
    ASSERT_NE(back, shown.end());
    const int first = static_cast<int>(left - shown.begin()),
              last = static_cast<int>(back - shown.begin());
    EXPECT_GE(seen.TimeOf(first), 20) << "seen before, seed " << seed;
    EXPECT_GE(seen.TimeOf(last - first), 180) << "away, seed " << seed;
    EXPECT_GE(std::count(back, shown.end(), true) / options.rate_hz, 15) << "seen again";
    double way = 0;
    for (int frame = first; frame < last; ++frame)
      way +=
          (seen.walk().Position(seen.TimeOf(frame + 1)) - seen.walk().Position(seen.TimeOf(frame)))
              .norm();
    EXPECT_GE(way, 60) << "seed " << seed;
  }
}

TEST(Places, TwinsStandSideBySideWithAndWithoutArmRests) {
  const Result<Room> room = FurnishRoom(SeededOptions(SyntheticScene::kTwins, 2));
  ASSERT_TRUE(room.ok()) << room.error().message;
  const auto count = [&](const std::string& model) {
    return std::count_if(room->instances.begin(), room->instances.end(),
                         [&](const RoomInstance& instance) { return instance.model == model; });
  };
  EXPECT_EQ(count("chair_slat"), 2);
  EXPECT_EQ(count("chair_slat_arms"), 2);
  EXPECT_EQ(count("chair_office"), 1);
  EXPECT_EQ(count("chair_office_plain"), 1);
}

TEST(Places, OfficeIsFurnishedFromItsOwnModels) {
  const Result<Room> room = FurnishRoom(SeededOptions(SyntheticScene::kOffice, 2));
  ASSERT_TRUE(room.ok()) << room.error().message;
  std::vector<std::string> categories;
  for (const RoomInstance& instance : room->instances) {
    categories.push_back(instance.category);
    EXPECT_TRUE(
        std::any_of(room->catalogue.begin(), room->catalogue.end(),
                    [&](const FurnitureModel& model) { return model.name == instance.model; }));
  }
  for (const char* wanted : {"desk", "chair", "shelf", "potted plant", "tv", "cabinet"})
    EXPECT_GE(std::count(categories.begin(), categories.end(), wanted), 1) << wanted;
}

TEST(Places, PlatformCarriesHalfOfTheFurnitureInView) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SyntheticOptions options = SeededOptions(SyntheticScene::kPlatform, seed);
    const SeenRoom seen(options);
    ASSERT_EQ(seen.room().levels.size(), 1u);
    const FloorLevel& level = seen.room().levels.front();
    EXPECT_NEAR(level.height_m, 0.3, 1e-12);
    const UprightFrame upright({0, 0, -1});
    int raised = 0, below = 0;
    for (std::size_t i = 0; i < seen.room().instances.size(); ++i) {
      const Eigen::Vector3d at = seen.room().instances[i].room_from_object.translation();
      const bool held = Holds(level, at, upright);
      EXPECT_NEAR(at.z(), held ? 0.3 : 0, 1e-9) << seen.room().instances[i].id;
      ++(held ? raised : below);
      int shown = 0;
      for (int frame = 0; frame < options.frames; frame += 10)
        shown += seen.Look(frame, static_cast<int>(i) + 1).visible > 20;
      EXPECT_GE(shown, 15) << seen.room().instances[i].id << " of " << options.frames / 10;
    }
    EXPECT_GE(raised, 4);
    EXPECT_GE(below, 3);
    for (int frame = 0; frame < options.frames; ++frame) {
      const Eigen::Vector2d stand = seen.walk().Position(seen.TimeOf(frame));
      EXPECT_FALSE(Holds(level, {stand.x(), stand.y(), 0}, upright)) << "it walks below";
    }
  }
}

TEST(Places, RatesAreOneWalkThroughOneRoom) {
  SyntheticOptions fast = SeededOptions(SyntheticScene::kRates, 3);
  fast.rate_hz = 60;
  fast.frames = 900;
  const SeenRoom reference(fast);
  for (const int rate_hz : {5, 10, 30}) {
    SyntheticOptions options = fast;
    options.rate_hz = rate_hz;
    options.frames = 15 * rate_hz;
    const SeenRoom room(options);
    ASSERT_EQ(room.room().instances.size(), reference.room().instances.size());
    for (std::size_t i = 0; i < room.room().instances.size(); ++i) {
      EXPECT_EQ(room.room().instances[i].room_from_object.matrix(),
                reference.room().instances[i].room_from_object.matrix());
    }
    for (int frame = 0; frame < options.frames; ++frame) {
      const double t_s = room.TimeOf(frame);
      ASSERT_EQ(t_s, reference.TimeOf(frame * (60 / rate_hz)));
      ASSERT_EQ(room.walk().RoomFromCam(t_s).matrix(), reference.walk().RoomFromCam(t_s).matrix());
    }
  }
}

}  // namespace
}  // namespace plumbline
