// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/missed_truths.h"

#include <memory>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/analysis/history.h"
#include "engine/analysis/planted_truth.h"
#include "engine/analysis/true_instances.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

constexpr double kConfirm = 0.8;

/// A box of 1 x 1 x 1 m about its origin.
std::shared_ptr<const TriangleMesh> Cube() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(static_cast<float>(i & 1) - 0.5f,
                               static_cast<float>((i >> 1) & 1) - 0.5f,
                               static_cast<float>((i >> 2) & 1) - 0.5f);
  }
  for (const auto& [a, b, c] : {std::tuple{0, 1, 3},
                                {0, 3, 2},
                                {4, 5, 7},
                                {4, 7, 6},
                                {0, 1, 5},
                                {0, 5, 4},
                                {2, 3, 7},
                                {2, 7, 6},
                                {0, 2, 6},
                                {0, 6, 4},
                                {1, 3, 7},
                                {1, 7, 5}})
    mesh.triangles.emplace_back(a, b, c);
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

Eigen::Isometry3d Placed(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// Two chairs before a camera at the origin that looks along +z: "near" hides part of "far".
SequenceView TwoStools() {
  SequenceView view;
  view.image_width = 640;
  view.image_height = 480;
  view.fx = view.fy = 400;
  view.cx = 319.5;
  view.cy = 239.5;
  view.models = {{"stool", "chair", Cube()}, {"mug", "cup", Cube()}};
  view.truth = {{"near", "stool", Placed(0, 0, 4)}, {"far", "stool", Placed(1.2, 0, 8.5)}};
  return view;
}

ObjectReport StoolAs(int id, ObjectState state, const Eigen::Isometry3d& pose) {
  ObjectReport object;
  object.id = {id};
  object.state = state;
  object.category = "chair";
  object.label = {0};
  object.world_from_object = pose;
  return object;
}

TEST(TruthVisibility, CountsThePixelsThatShow) {
  const TruthVisibility visibility(TwoStools());
  const auto shown = visibility.From(Eigen::Isometry3d::Identity());
  // The front of the near cube, 1 m wide at 3.5 m: 400 / 3.5 = 114.3 pixels.
  EXPECT_NEAR(shown[0].pixels, 114.3 * 114.3, 0.15 * 114.3 * 114.3) << "rays are 8 pixels apart";
  EXPECT_NEAR(shown[0].box.width(), 114.3, 8);
  EXPECT_NEAR(shown[0].box.center_x(), 319.5, 8);
  // The far one, from x = .7 m at 8 m: 35 pixels right of the middle, of which 57 are hidden.
  EXPECT_NEAR(shown[1].box.x0, 319.5 + 57, 9);
  EXPECT_LT(shown[1].pixels, 0.75 * 50 * 50);
  EXPECT_GT(shown[1].pixels, 0);
}

TEST(TruthVisibility, SeesNothingBehindTheCamera) {
  Eigen::Isometry3d away = Eigen::Isometry3d::Identity();
  away.linear() = Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const auto& shown : TruthVisibility(TwoStools()).From(away)) {
    EXPECT_EQ(shown.pixels, 0);
    EXPECT_TRUE(shown.box.empty());
  }
}

TEST(TruthsOfObjects, AreOneToOneAndConfirmedOnesChooseFirst) {
  const SequenceView view = TwoStools();
  FrameReport report;
  report.objects = {StoolAs(1, ObjectState::kTentative, Placed(0.02, 0, 4)),
                    StoolAs(2, ObjectState::kConfirmed, Placed(0.3, 0, 4)),
                    StoolAs(3, ObjectState::kRetired, Placed(1.2, 0, 8.5))};
  const auto pairs = TruthsOfObjects(report, view);
  EXPECT_FALSE(pairs[0]) << "the instance is explained by a confirmed one";
  EXPECT_EQ(pairs[1], 0);
  EXPECT_FALSE(pairs[2]) << "what is retired explains nothing";
  const auto compared = TruthToCompare(report, view, ObjectId{1}, 1.5);
  ASSERT_TRUE(compared);
  EXPECT_EQ(compared->truth, 0);
  EXPECT_EQ(compared->explained_by, ObjectId{2});
  EXPECT_EQ(CandidateFor(report, view, 0), &report.objects[1]);
  EXPECT_EQ(CandidateFor(report, view, 1), nullptr);
}

/// Frames of a run, and what it says of "near".
class ToldRun {
 public:
  ToldRun() : view_(TwoStools()), visibility_(view_) {}

  void Frames(int count, std::vector<ObjectReport> objects,
              std::vector<ProposalReport> proposals = {}, bool away = false) {
    for (int i = 0; i < count; ++i) {
      FrameReport report;
      report.frame = frame_++;
      report.world_from_cam = Eigen::Isometry3d::Identity();
      if (away) report.world_from_cam->translation().z() = 100;
      report.objects = objects;
      report.proposals = proposals;
      history_.frames.push_back(
          std::make_shared<const FrameSample>(SampleOf(report, view_, &visibility_)));
    }
  }
  void Event(EventKind kind, int object, const char* text) {
    events_.push_back({frame_ - 1, {kind, {object}, {}, text, {}}});
  }
  TruthView Near() const { return All().truths[0]; }
  const RunHistory& history() const { return history_; }
  TruthsView All() const { return TruthsOf(history_, events_, view_, kConfirm); }

 private:
  SequenceView view_;
  TruthVisibility visibility_;
  RunHistory history_;
  std::vector<FrameEvent> events_;
  int frame_ = 0;
};

ProposalReport BoxOver(ProposalFate fate, int object) {
  return {{260, 180, 378, 298}, "chair", 0.9f, fate, {object}};
}

TEST(WhyMissed, SaysThatNothingIsMissed) {
  ToldRun run;
  run.Frames(20, {StoolAs(4, ObjectState::kConfirmed, Placed(0, 0.1, 4))});
  const TruthView truth = run.Near();
  EXPECT_TRUE(truth.found);
  EXPECT_EQ(truth.object, ObjectId{4});
  EXPECT_EQ(truth.cause, MissedCause::kNone);
  EXPECT_EQ(run.All().found, 1);
  EXPECT_EQ(run.All().missed, 1);
}

TEST(WhyMissed, TellsWhatIsNotSeenFromWhatIsNeverBoxed) {
  ToldRun unseen;
  unseen.Frames(kFewestFramesSeen - 1, {});
  unseen.Frames(40, {}, {}, true);
  EXPECT_EQ(unseen.Near().cause, MissedCause::kNotSeen);
  EXPECT_EQ(unseen.Near().frames_seen, kFewestFramesSeen - 1);
  ToldRun seen;
  seen.Frames(30, {}, {{{10, 10, 60, 60}, "chair", 0.9f, ProposalFate::kExplained, {1}}});
  EXPECT_EQ(seen.Near().cause, MissedCause::kNeverBoxed) << "that box lies elsewhere";
  EXPECT_EQ(seen.Near().last_seen, 29);
}

TEST(WhyMissed, TellsWhoTookTheBoxes) {
  ToldRun run;
  run.Frames(30, {StoolAs(7, ObjectState::kConfirmed, Placed(1.2, 0, 8.5))},
             {BoxOver(ProposalFate::kExplained, 7)});
  const TruthView truth = run.Near();
  EXPECT_EQ(truth.cause, MissedCause::kBoxTaken);
  EXPECT_EQ(truth.frames_boxed, 30);
  EXPECT_NE(truth.text.find("object 7 took it, which is far"), std::string::npos) << truth.text;
}

TEST(WhyMissed, TellsWhyNothingWasBorn) {
  ToldRun run;
  run.Frames(12, {}, {BoxOver(ProposalFate::kLowScore, 0)});
  run.Frames(20, {}, {BoxOver(ProposalFate::kImplausible, 0)});
  const TruthView truth = run.Near();
  EXPECT_EQ(truth.cause, MissedCause::kBirthRefused);
  EXPECT_NE(truth.text.find("20 implausible, 12 low score"), std::string::npos) << truth.text;
}

TEST(WhyMissed, TellsACandidateThatWasThereAndIsGone) {
  ToldRun run;
  ObjectReport object = StoolAs(5, ObjectState::kTentative, Placed(0.05, 0, 4));
  object.log_evidence = 0.3;
  run.Frames(15, {object}, {BoxOver(ProposalFate::kSpawned, 5)});
  run.Event(EventKind::kRetired, 5, "tentative for too long");
  run.Frames(15, {});
  const TruthView truth = run.Near();
  EXPECT_EQ(truth.cause, MissedCause::kWithdrawn);
  ASSERT_EQ(truth.candidates.size(), 1u);
  EXPECT_EQ(truth.candidates[0].ended, 14);
  EXPECT_NEAR(truth.candidates[0].nearest_m, 0.05, 1e-6);
  EXPECT_NE(truth.text.find("tentative for too long"), std::string::npos) << truth.text;
}

TEST(WhyMissed, TellsACandidateThatWaitsFromOneThatIsElsewhere) {
  ToldRun waits;
  ObjectReport there = StoolAs(5, ObjectState::kTentative, Placed(0.05, 0, 4));
  there.log_evidence = 0.3;
  for (int axis = 0; axis < 2; ++axis) there.covariance(axis, axis) = 0.09 * 0.09;
  waits.Frames(30, {there}, {BoxOver(ProposalFate::kExplained, 5)});
  EXPECT_EQ(waits.Near().cause, MissedCause::kNotConfirmed);
  EXPECT_NE(waits.Near().text.find("believed to \u00b1 "), std::string::npos) << waits.Near().text;
  EXPECT_NE(waits.Near().text.find("evidence of 0.3 (confirmed above 0.8)"), std::string::npos)
      << waits.Near().text;
  ToldRun elsewhere;
  elsewhere.Frames(30, {StoolAs(6, ObjectState::kTentative, Placed(0.3, 0, 4.2))},
                   {BoxOver(ProposalFate::kExplained, 6)});
  EXPECT_EQ(elsewhere.Near().cause, MissedCause::kNeverNear);
  EXPECT_NE(elsewhere.Near().text.find("never nearer than 36 cm"), std::string::npos)
      << elsewhere.Near().text;
}

TEST(WhyMissed, TellsACandidateThatWasThereAndStrayed) {
  ToldRun run;
  run.Frames(10, {StoolAs(5, ObjectState::kTentative, Placed(0.02, 0, 4))},
             {BoxOver(ProposalFate::kSpawned, 5)});
  run.Frames(20, {StoolAs(5, ObjectState::kTentative, Placed(0.18, 0, 4))},
             {BoxOver(ProposalFate::kExplained, 5)});
  const TruthView truth = run.Near();
  EXPECT_EQ(truth.cause, MissedCause::kNotConfirmed);
  EXPECT_NE(truth.text.find("came within 2 cm"), std::string::npos) << truth.text;
  EXPECT_NE(truth.text.find("ends 18 cm"), std::string::npos) << truth.text;
}

TEST(WhyMissed, CountsAsFoundWhatEvaluateMatches) {
  ToldRun run;
  run.Frames(30, {StoolAs(6, ObjectState::kConfirmed, Placed(0.6, 0, 4))});
  EXPECT_FALSE(run.Near().found) << "further than half a metre";
}

TEST(WhyMissed, LeavesOutCandidatesThatBecameAnotherInstance) {
  ToldRun run;
  run.Frames(10, {StoolAs(5, ObjectState::kTentative, Placed(0.4, 0, 4))});
  run.Frames(20, {StoolAs(5, ObjectState::kConfirmed, Placed(1.2, 0, 8.5))});
  EXPECT_TRUE(run.Near().candidates.empty());
  EXPECT_EQ(run.Near().cause, MissedCause::kNeverBoxed);
}

TEST(WhyMissed, IsWrittenAsJson) {
  ToldRun run;
  run.Frames(30, {StoolAs(7, ObjectState::kConfirmed, Placed(1.2, 0, 8.5))},
             {BoxOver(ProposalFate::kExplained, 7)});
  const nlohmann::json why = WhyMissedToJson(run.Near());
  EXPECT_EQ(why["cause"], "box_taken");
  EXPECT_EQ(why["boxes"][0]["object"], 7);
  EXPECT_EQ(why["frames_boxed"], 30);
  EXPECT_EQ(FindTruth(run.All(), "nobody"), nullptr);
}

TEST(Planted, IsGivenBeforeTheInstanceShowsWell) {
  ToldRun run;
  run.Frames(5, {}, {}, true);
  run.Frames(5, {});
  EXPECT_EQ(FrameToPlantAfter(run.history(), 0), 4);
  ToldRun at_once;
  at_once.Frames(5, {});
  EXPECT_EQ(FrameToPlantAfter(at_once.history(), 0), 0);
  EXPECT_FALSE(FrameToPlantAfter(RunHistory(), 0));
}

TEST(Planted, TellsSearchLikelihoodAndBeingThereApart) {
  constexpr int kAfter = 9;
  const auto planted = [&](const std::vector<std::pair<double, ObjectState>>& way,
                           const char* end) {
    ToldRun run;
    run.Frames(kAfter + 1, {});
    for (const auto& [x, state] : way) run.Frames(10, {StoolAs(5, state, Placed(x, 0, 4))});
    if (end != nullptr) run.Event(EventKind::kRetired, 5, end);
    run.Frames(1, end == nullptr
                      ? std::vector{StoolAs(5, way.back().second, Placed(way.back().first, 0, 4))}
                      : std::vector<ObjectReport>());
    return JudgePlanted(run.Near(), ObjectId{5}, kAfter, kConfirm);
  };
  const PlantedTruth found =
      planted({{0, ObjectState::kTentative}, {0.02, ObjectState::kConfirmed}}, nullptr);
  EXPECT_EQ(found.fate, PlantedFate::kConfirmed);
  EXPECT_STREQ(BlameOf(found.fate), "search");
  EXPECT_NE(found.text.find("after frame 9, object 5 is confirmed and stands 2 cm"),
            std::string::npos)
      << found.text;
  const PlantedTruth waits = planted({{0.02, ObjectState::kTentative}}, nullptr);
  EXPECT_EQ(waits.fate, PlantedFate::kNotConfirmed);
  const PlantedTruth gone = planted({{0.02, ObjectState::kTentative}}, "without support");
  EXPECT_EQ(gone.fate, PlantedFate::kWithdrawn);
  EXPECT_STREQ(BlameOf(gone.fate), "being there");
  EXPECT_NE(gone.text.find("until frame 19: without support"), std::string::npos) << gone.text;
  const PlantedTruth moved =
      planted({{0, ObjectState::kTentative}, {0.3, ObjectState::kTentative}}, "without support");
  EXPECT_EQ(moved.fate, PlantedFate::kMoved);
  EXPECT_STREQ(BlameOf(moved.fate), "likelihood");
  EXPECT_NE(moved.text.find("30 cm"), std::string::npos) << moved.text;
  EXPECT_EQ(JudgePlanted(TruthView(), ObjectId{5}, kAfter, kConfirm).fate, PlantedFate::kMoved)
      << "what became another instance is no candidate of this one";
  EXPECT_EQ(PlantedToJson(moved)["blame"], "likelihood");
}

TEST(Planted, IsKnownByItsReason) {
  const std::vector<RunEvent> events = {{0, 3, {EventKind::kSpawned, {7}, {}, "a box", {}}},
                                        {1, 4, {EventKind::kSpawned, {8}, {}, "planted here", {}}}};
  EXPECT_EQ(ObjectPlanted(events, "planted here"), ObjectId{8});
  EXPECT_EQ(ObjectPlanted(events, "planted there"), ObjectId());
}

}  // namespace
}  // namespace plumbline
