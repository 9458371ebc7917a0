// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/support_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/mapping/birth.h"
#include "engine/mapping/cross_sections.h"
#include "engine/mapping/judging.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

class SupportSurfaceTest : public testing::Test {
 protected:
  const CadModel& Named(const char* name) const {
    return database_->model(database_->Find(name).value());
  }
  Eigen::Isometry3d TableTurned() const {
    Eigen::Isometry3d world_from_table = Eigen::Isometry3d::Identity();
    world_from_table.linear() = upright_.WorldFromObjectRotation(std::numbers::pi / 6);
    world_from_table.translation() = Eigen::Vector3d(2, -1, 0);
    return world_from_table;
  }
  SupportSurface TableTop() const {
    return MakeSupportSurface(Named("table"), *SupportHeight(Named("table")), TableTurned(), 1,
                              upright_, 0.02);
  }
  /// All of whose foot is in one place.
  static StandingThing Thing(const Eigen::Vector3d& base, double height_m) {
    StandingThing thing{base, height_m};
    thing.foot.fill(base.head<2>());
    return thing;
  }
  MapFrame MapWithTable() const {
    return {upright_, Eigen::Vector4d(0, 0, 1, 0), database_, {TableTop()}};
  }

  const std::shared_ptr<const ModelDatabase> database_ = MakeFurnitureDatabase();
  const UprightFrame upright_{{0, 0, -1}};
};

TEST_F(SupportSurfaceTest, IsTheHighestLevelThatCoversHalfTheFootprint) {
  EXPECT_NEAR(*SupportHeight(Named("table")), 0.74, 1e-3);
  EXPECT_NEAR(*SupportHeight(Named("crate")), 0.3, 1e-3);
  const std::optional<double> seat = SupportHeight(Named("chair"));
  ASSERT_TRUE(seat);
  EXPECT_LT(*seat, 0.6) << "the seat, not the back rest";
  EXPECT_GT(*seat, 0.3);
}

TEST_F(SupportSurfaceTest, HasNoneWhereOnlySlopesLookUp) {
  CadModel roof = Named("crate");
  roof.mesh.triangles.clear();
  roof.mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 1}};
  roof.mesh.triangles = {{0, 1, 2}};
  roof.bounds = BoundingBox(roof.mesh);
  EXPECT_FALSE(SupportHeight(roof));
}

TEST_F(SupportSurfaceTest, LiesWhereTheObjectStands) {
  const SupportSurface top = TableTop();
  EXPECT_NEAR(top.height_m, 0.74, 1e-3);
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return (TableTurned() * Eigen::Vector3d(x, y, 0)).head<2>();
  };
  EXPECT_TRUE(top.Holds(at(0, 0)));
  EXPECT_TRUE(top.Holds(at(0.6, -0.3)));
  EXPECT_FALSE(top.Holds(at(0.7, 0)));
  EXPECT_FALSE(top.Holds(at(0, 0.4)));
  Random random({.seed = 1});
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(top.Holds(top.Draw(random).head<2>()));
}

TEST_F(SupportSurfaceTest, PriorPrefersStandingOnIt) {
  const std::vector<SupportSurface> tops = {TableTop()};
  EXPECT_EQ(LogSupportPrior({}, Thing({2, -1, 0.74}, 0.3)), 0);
  EXPECT_EQ(LogSupportPrior(tops, Thing({4, -1, 0.74}, 0.3)), 0) << "beside it";
  EXPECT_NEAR(LogSupportPrior(tops, Thing({2, -1, 1.2}, 0.3)), 0, 1e-6) << "above it, on nothing";
  EXPECT_NEAR(LogSupportPrior(tops, Thing({2, -1, 0.1}, 0.3)), 0, 1e-6) << "on the floor under it";
  // Against heights that are equally likely over two metres: the Gaussian at its mean, and beside
  // it that the surface is not there.
  EXPECT_NEAR(LogSupportPrior(tops, Thing({2, -1, 0.74}, 0.3)),
              std::log(1e-4 + 2 / (std::sqrt(2 * std::numbers::pi) * tops[0].height_std_m)), 1e-2);
}

TEST_F(SupportSurfaceTest, NothingReachesThroughIt) {
  const std::vector<SupportSurface> tops = {TableTop()};
  EXPECT_LT(LogSupportPrior(tops, Thing({2, -1, 0.6}, 0.3)), -9) << "14 cm into the top";
  EXPECT_LT(LogSupportPrior(tops, Thing({2, -1, 0.3}, 0.5)), -9) << "through it from below";
  EXPECT_NEAR(LogSupportPrior(tops, Thing({2, -1, 0.3}, 0.4)), 0, 1e-6) << "below it";
  EXPECT_GT(LogSupportPrior(tops, Thing({2, -1, 0.73}, 0.3)), 3) << "as near as the top is known";
  EXPECT_NEAR(LogSupportPrior(tops, Thing({4, -1, 0.6}, 0.3)), 0, 1e-6) << "beside it";
}

TEST_F(SupportSurfaceTest, NothingHoversRightAboveIt) {
  const std::vector<SupportSurface> tops = {TableTop()};
  EXPECT_LT(LogSupportPrior(tops, Thing({2, -1, 0.82}, 0.3)), -4)
      << "8 cm above it: 4 deviations of the top";
  EXPECT_NEAR(LogSupportPrior(tops, Thing({2, -1, 0.86}, 0.3)), 0, 1e-6) << "on the wall over it";
}

TEST_F(SupportSurfaceTest, AllOfAFootStandsOnIt) {
  const SupportSurface top = TableTop();
  const Eigen::Vector2d middle = top.corner + 0.5 * (top.side_a + top.side_b);
  const Eigen::Vector2d across = top.side_b.normalized();
  const double half_m = 0.5 * top.side_b.norm();
  EXPECT_EQ(top.Overhang(middle), 0);
  EXPECT_NEAR(top.Overhang(middle + (half_m + 0.05) * across), 0.05, 1e-9);
  EXPECT_NEAR(top.Overhang(middle - (half_m + 0.07) * across), 0.07, 1e-9);
  // A foot that reaches 10 cm to both sides, moved towards the edge.
  const auto prior = [&](double moved_m) {
    const Eigen::Vector2d at = middle + moved_m * across;
    StandingThing thing = Thing({at.x(), at.y(), top.height_m}, 0.3);
    thing.foot[0] -= 0.1 * across;
    thing.foot[1] += 0.1 * across;
    return LogSupportPrior({top}, thing);
  };
  EXPECT_NEAR(prior(half_m - 0.11), prior(0), 1e-9) << "all of it stands";
  EXPECT_NEAR(prior(half_m - 0.08), prior(0) - 0.5, 0.01) << "one deviation";
  EXPECT_LT(prior(half_m - 0.01), prior(0) - 6) << "nearly half of it does not";
  EXPECT_LT(prior(half_m + 0.05), -3) << "no way out behind it: a quarter of it is over it still";
  EXPECT_EQ(prior(half_m + 0.11), 0) << "beside it";
}

TEST_F(SupportSurfaceTest, OnlyWhatNeedNotStandOnTheFloorKnowsOfIt) {
  const MapFrame map = MapWithTable();
  const MapperOptions options;
  const auto on_top = [&](const char* name) {
    const ModelId label = database_->Find(name).value();
    return PoseHypothesis{label, 0, {2, -1, 0.74 + Named(name).center().z()}};
  };
  EXPECT_GT(LogHeightPrior(map, on_top("crate"), options), 2);
  EXPECT_LT(LogHeightPrior(map, on_top("chair"), options), -100) << "it stands on the floor";
  MapperOptions off;
  off.floor_prior = false;
  EXPECT_EQ(LogHeightPrior(map, on_top("crate"), off), 0);
  MapFrame bare = map;
  bare.supports.clear();
  EXPECT_EQ(LogHeightPrior(bare, on_top("crate"), options), 0);
}

TEST_F(SupportSurfaceTest, NothingIsBelowTheFloor) {
  MapFrame map = MapWithTable();
  map.supports.clear();
  const MapperOptions options;
  const double std_m = map.BaseStd(options);
  const auto prior = [&](double base_m) {
    const ModelId label = database_->Find("crate").value();
    return LogHeightPrior(
        map, PoseHypothesis{label, 0, {2, -1, base_m + Named("crate").center().z()}}, options);
  };
  EXPECT_EQ(prior(1.5), 0);
  EXPECT_EQ(prior(0), 0);
  EXPECT_EQ(prior(-1.9 * std_m), 0) << "the floor is not known better";
  EXPECT_NEAR(prior(-5 * std_m), -4.5, 1e-6);
  EXPECT_LT(prior(-1), -100);
}

TEST_F(SupportSurfaceTest, SomeAreSpawnedOnIt) {
  const MapFrame map = MapWithTable();
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along +x
  world_from_cam.translation() = Eigen::Vector3d(0, -1, 0.9);
  const ModelId crate = database_->Find("crate").value();
  const PoseHypothesis truth{crate, 0.3, {2, -1, 0.74 + 0.15}};
  const std::optional<Box2> box =
      ProjectedBounds(database_->model(crate), truth, map, camera, world_from_cam.inverse());
  ASSERT_TRUE(box);
  const auto standing = [&](const MapFrame& known) {
    int count = 0;
    for (const PoseHypothesis& drawn : SampleBirth({*box, "suitcase", 0.9f}, camera, world_from_cam,
                                                   known, MapperOptions{}, 1000, {.seed = 3})) {
      const Eigen::Vector3d base = known.BaseInUpright(drawn);
      count += TableTop().Holds(base.head<2>()) && std::abs(base.z() - 0.74) < 0.04 ? 1 : 0;
    }
    return count;
  };
  MapFrame bare = map;
  bare.supports.clear();
  EXPECT_GT(standing(map), 1.4 * standing(bare)) << "the box alone says much";
}

TEST_F(SupportSurfaceTest, TakenPlacesAreLeftOut) {
  const Target flat = [](std::span<const PoseHypothesis> hypotheses) {
    return std::vector<Judgement>(hypotheses.size());
  };
  // A screen at (1, 2, 0.5) that faces 30 degrees from +x, 10 cm deep and 1 m wide.
  TakenPlace screen;
  Eigen::Isometry3d world_from_center = Eigen::Isometry3d::Identity();
  world_from_center.linear() = upright_.WorldFromObjectRotation(std::numbers::pi / 6);
  world_from_center.translation() = Eigen::Vector3d(1, 2, 0.5);
  screen.center_from_world = world_from_center.inverse();
  screen.half_sizes_m = {0.05, 0.5, 0.3};
  const Target outside = Outside({screen}, flat);
  std::vector<PoseHypothesis> hypotheses;
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0.02, 0.4, -0.2), Eigen::Vector3d(0.1, 0, 0),
                                    Eigen::Vector3d(0, 0.55, 0), Eigen::Vector3d(0, 0, 0.4)}) {
    hypotheses.push_back({ModelId{0}, 0, world_from_center * at});
  }
  const std::vector<Judgement> judged = outside(hypotheses);
  EXPECT_LT(judged[0].log_target, -10);
  EXPECT_EQ(judged[1].log_target, 0) << "before it";
  EXPECT_EQ(judged[2].log_target, 0) << "beside it";
  EXPECT_EQ(judged[3].log_target, 0) << "above it";
}

TEST_F(SupportSurfaceTest, CutsOfAModelLieOnItsSurface) {
  const CrossSections crate(Named("crate"));  // .4 x .24 x .3 m
  ASSERT_EQ(crate.At(0.15).size(), 16);
  for (const Eigen::Vector2f& point : crate.At(0.15))
    EXPECT_NEAR(std::max(std::abs(point.x()) / 0.2F, std::abs(point.y()) / 0.12F), 1, 1e-5);
  EXPECT_TRUE(crate.At(-0.01).empty());
  EXPECT_TRUE(crate.At(0.31).empty());
  const CrossSections vase(Named("vase"));  // a radius of .12 m
  for (const Eigen::Vector2f& point : vase.At(0.39)) EXPECT_NEAR(point.norm(), 0.12F, 1e-3);
}

class ChairAtTableTest : public SupportSurfaceTest {
 protected:
  /// The chair's middle, in the axes of the table; it looks along the table's y, turned by that.
  PoseHypothesis ChairAt(double x, double y, double turned_rad = 0) const {
    Eigen::Vector3d center = TableTurned() * Eigen::Vector3d(x, y, 0);
    center.z() = Named("chair").center().z();
    const double along_y = std::numbers::pi / 6 + std::numbers::pi / 2;
    return {database_->Find("chair").value(), along_y + turned_rad, center};
  }
  double Depth(const PoseHypothesis& chair) const {
    return DepthInTop(TableTop(), sections_, MapWithTable(), chair);
  }

  const std::vector<CrossSections> sections_ = [&] {
    std::vector<CrossSections> sections;
    for (const CadModel& model : database_->models()) sections.emplace_back(model);
    return sections;
  }();
};

TEST_F(ChairAtTableTest, ItsSeatMayBeUnderTheTopItsBackMayNotBeInIt) {
  // The top is 1.3 x .7 m; the chair's back rest is .2 m behind its middle.
  EXPECT_EQ(Depth(ChairAt(0, -0.8)), 0) << "before the table";
  EXPECT_EQ(Depth(ChairAt(0, -0.3)), 0) << "its seat is under the top";
  EXPECT_GT(Depth(ChairAt(0, -0.3, std::numbers::pi)), 0.15) << "turned round, its back is in it";
  EXPECT_GT(Depth(ChairAt(0, 0.2)), 0.2) << "in the middle of the table";
  EXPECT_EQ(Depth(ChairAt(3, 0)), 0);
}

TEST_F(ChairAtTableTest, WhatEndsBelowTheTopIsUnderIt) {
  PoseHypothesis low = ChairAt(0, 0.2);
  low.log_scale = std::log(0.8);
  low.center_in_world.z() *= 0.8;
  EXPECT_EQ(Depth(low), 0);
}

TEST_F(ChairAtTableTest, TheSmallerOfTwoGivesWay) {
  const CadModel& chair = Named("chair");  // its seat is .46 m high, its footprint .45 m wide
  const SupportSurface seat =
      MakeSupportSurface(chair, *SupportHeight(chair), TableTurned(), 1, upright_, 0.02);
  const auto depth_of_vase = [&](double scale) {  // .24 m wide and .4 m high at a scale of 1
    const Eigen::Vector3d center(2, -1, 0.2 * scale);
    return DepthInTop(seat, sections_, MapWithTable(),
                      {database_->Find("vase").value(), 0, center, std::log(scale)});
  };
  EXPECT_GT(depth_of_vase(1.5), 0.02);
  EXPECT_EQ(depth_of_vase(2.2), 0) << "it is larger than the seat";
}

TEST_F(ChairAtTableTest, ATargetIsWhatItWasBesideTheTop) {
  const MapFrame map = MapWithTable();
  const Target flat = [](std::span<const PoseHypothesis> hypotheses) {
    return std::vector<Judgement>(hypotheses.size());
  };
  const std::vector<PoseHypothesis> chairs = {ChairAt(0, -0.3), ChairAt(0, 0.2)};
  const std::vector<Judgement> judged = ClearOf({TableTop()}, sections_, map, flat)(chairs);
  EXPECT_EQ(judged[0].log_target, 0);
  EXPECT_NEAR(judged[1].log_target, std::log(1e-4), 1e-6);
  EXPECT_EQ(ClearOf({}, sections_, map, flat)(chairs)[1].log_target, 0);
}

}  // namespace
}  // namespace plumbline
