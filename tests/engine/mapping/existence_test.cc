// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/existence.h"

#include <gmock/gmock.h>

#include "engine/mapping/novelty_clock.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

const MapperOptions kOptions;
constexpr double kFrame_s = 1.0 / 30;

/// A chair in full view, a tenth of an independent look.
Sighting InFullView() {
  Sighting sighting;
  sighting.novelty = 0.1;
  sighting.visible_px = 20000;
  sighting.visible_fraction = sighting.edge_fraction = 0.9;
  sighting.telling = 1;
  return sighting;
}
Sighting Seen() {
  Sighting sighting = InFullView();
  sighting.box_score = 0.6f;
  sighting.box_iou = 0.8f;
  sighting.edge_surplus = 0.3f;
  return sighting;
}

TEST(SightingLogRatio, BoxesAndEdgesSpeakForAnObjectAndTheirAbsenceAgainst) {
  EXPECT_GT(SightingLogRatio(Seen(), kOptions), 1);
  EXPECT_LT(SightingLogRatio(InFullView(), kOptions), -1);
  Sighting box_only = Seen();
  box_only.edge_surplus = 0;
  Sighting edges_only = Seen();
  edges_only.box_score = edges_only.box_iou = 0;
  EXPECT_GT(SightingLogRatio(Seen(), kOptions), SightingLogRatio(box_only, kOptions));
  EXPECT_GT(SightingLogRatio(Seen(), kOptions), SightingLogRatio(edges_only, kOptions));
}

TEST(SightingLogRatio, AMissingBoxSaysLittleWhereTheDetectorFindsNothing) {
  const auto missing = [](auto change) {
    Sighting sighting = InFullView();
    sighting.edge_surplus = static_cast<float>(kOptions.expected_edge);  // edges say nothing
    change(sighting);
    return SightingLogRatio(sighting, kOptions);
  };
  const double full = missing([](Sighting&) {});
  EXPECT_NEAR(full, std::log(1 - kOptions.detection_rate), 1e-6);
  EXPECT_GT(missing([](Sighting& s) { s.visible_px = 200; }), 0.15 * full);
  EXPECT_GT(missing([](Sighting& s) { s.visible_fraction = 0.1; }), 0.3 * full);
  EXPECT_GT(missing([](Sighting& s) { s.inside_fraction = 0.2; }), 0.3 * full);
}

TEST(SightingLogRatio, TheBoxHasItsPart) {
  Sighting no_edges = Seen();
  no_edges.telling = 0;
  EXPECT_EQ(BoxLogRatio(Seen(), kOptions), SightingLogRatio(no_edges, kOptions));
}

TEST(TentativeLogOdds, OfWhatHasShownBoxesTellRightFromWrong) {
  // A television on a wall: edges as of a screen, in full view for long, and never a box.
  TentativeEvidence picture{2.3, 0.7, -3.6, true};
  EXPECT_LT(TentativeLogOdds(picture, kOptions), kOptions.confirm_evidence);
  // A chair behind a table that few edges speak for, with a box now and then.
  TentativeEvidence chair{0, -0.1, 0.3, true};
  EXPECT_GT(TentativeLogOdds(chair, kOptions), kOptions.confirm_evidence);
  // Before enough has shown, edges count.
  chair.shown = picture.shown = false;
  EXPECT_LT(TentativeLogOdds(chair, kOptions), kOptions.confirm_evidence);
  TentativeEvidence sharp = picture;
  sharp.remembered += 2;
  EXPECT_GT(TentativeLogOdds(sharp, kOptions), TentativeLogOdds(picture, kOptions));
}

TEST(TentativeLogOdds, ManyBoxesTellLittleMoreThanSome) {
  const auto with = [](double boxes) { return TentativeLogOdds({0, 0, boxes, true}, kOptions); };
  EXPECT_GT(with(2) - with(0), 5 * (with(20) - with(6)));
  EXPECT_EQ(with(0), kOptions.shown_odds);
}

TEST(Existence, AWallCostsLittleAndIsForgottenAtOnce) {
  Existence existence{12, 0};
  for (int frame = 0; frame < 60 * 30; ++frame) {
    existence.Update(InFullView(), kFrame_s, kOptions);
  }
  EXPECT_GT(existence.log_odds, kOptions.confirm_evidence) << "a minute behind a wall";
  EXPECT_GT(existence.hidden, 0.9);
  for (int frame = 0; frame < 3 * 30; ++frame) existence.Update(Seen(), kFrame_s, kOptions);
  EXPECT_LT(existence.hidden, 0.1);
}

TEST(Existence, AnEmptyPlaceInViewSpeaksAgainstWhatWasNeverSettled) {
  Existence existence{1, 0};
  int frame = 0;
  while (existence.log_odds > -3 && frame < 1000) {
    existence.UpdateInView(InFullView(), kOptions);
    ++frame;
  }
  EXPECT_LT(frame, 60) << "six independent looks";
}

TEST(Existence, ARestingCameraAddsNothing) {
  Sighting sighting = Seen();
  sighting.novelty = 0;
  Existence existence{1, 0.2};
  existence.UpdateInView(sighting, kOptions);
  EXPECT_EQ(existence.log_odds, 1);
}

/// Sum of looks along a walk of that speed.
double Looks(double rate_hz, double seconds, double metres_per_s) {
  NoveltyClock clock;
  double sum = 0;
  for (int i = 0; i < seconds * rate_hz; ++i) {
    Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
    world_from_cam.translation().x() = metres_per_s * i / rate_hz;
    sum += clock.Advance(static_cast<std::int64_t>(1e9 * i / rate_hz), world_from_cam, kOptions);
  }
  return sum;
}

TEST(NoveltyClock, DoesNotDependOnTheFrameRate) {
  const double expected = Looks(60, 20, 0.2);
  EXPECT_GT(expected, 15);
  for (const double rate_hz : {10.0, 15.0, 30.0, 120.0})
    EXPECT_NEAR(Looks(rate_hz, 20, 0.2), expected, 0.12 * expected) << rate_hz;
}

TEST(NoveltyClock, ARestingCameraIsWorthTwoLooksAtMost) {
  EXPECT_LE(Looks(30, 600, 0), 2);
  EXPECT_GT(Looks(30, 600, 0), 0.9);
}

TEST(NoveltyClock, ComesBackFromBytes) {
  NoveltyClock clock;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  clock.Advance(0, world_from_cam, kOptions);
  world_from_cam.translation().x() = 0.05;
  clock.Advance(33'000'000, world_from_cam, kOptions);
  ByteWriter out;
  clock.Save(out);
  const std::string bytes = out.Take();
  NoveltyClock restored;
  ByteReader in(bytes);
  restored.Restore(in);
  ASSERT_TRUE(in.ok());
  world_from_cam.translation().x() = 0.09;
  EXPECT_EQ(clock.Advance(66'000'000, world_from_cam, kOptions),
            restored.Advance(66'000'000, world_from_cam, kOptions));
}

TEST(BeliefToConfirm, IsLessWhereABeliefHasHeldWithoutARival) {
  const double sure = kOptions.confirm_mode_weight, held = kOptions.confirm_held_weight;
  ASSERT_LT(held, sure);
  EXPECT_EQ(BeliefToConfirm(1.4, 1, false, kOptions), std::nullopt) << "a single image may mislead";
  EXPECT_EQ(BeliefToConfirm(1.6, 1, false, kOptions), sure) << "has not held yet";
  EXPECT_EQ(BeliefToConfirm(2, 1, false, kOptions), held);
  EXPECT_EQ(BeliefToConfirm(2, 1, true, kOptions), sure) << "of two modes neither";
  EXPECT_EQ(BeliefToConfirm(9, 0.25, false, kOptions), sure) << "front or back";
  EXPECT_EQ(BeliefToConfirm(9, 0.3, false, kOptions), held);
}

TEST(EdgeSurplus, IsLargeWhereTheObjectStandsAndSmallElsewhere) {
  MappingScene& scene = MappingScene::Get();
  const PlacedModel chair = scene.Place("chair", 0, 0, 30),
                    table = scene.Place("table", 1.2, 0.3, 70);
  const std::vector<PlacedModel> both = {chair, table};
  const MapperInput input = scene.Input(0, LookAt({2.4, -1.0, 1.4}, {0.4, 0, 0.4}), both);
  ScoringView view;
  view.camera = scene.camera();
  view.cam_from_world = input.world_from_cam.inverse();
  view.table = input.table.get();
  const auto surplus = [&](const PlacedModel& placed) {
    return EdgeSurplus(*scene.scorer(), view, scene.map(), scene.Hypothesis(placed));
  };
  EXPECT_GT(surplus(chair), 0.3);
  EXPECT_LT(surplus(scene.Place("chair", 1.2, 0.3, 30)), 0.5 * surplus(chair)) << "a table's edges";
  EXPECT_LT(surplus(scene.Place("chair", 0.4, -0.6, 30)), 0.15) << "the floor";
}

}  // namespace
}  // namespace plumbline
