// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <stop_token>
#include <thread>

#include "engine/analysis/sequence_view.h"
#include "engine/mapping/option_changes.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/report_bytes.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

/// The sequence is written once for all tests; those that damage it make a copy.
class PipelineTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    WriteDrawnSequence(Original(), {.frames = 70, .boxes_until = 100});
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::filesystem::path Original() { return folder_->path() / "sequence"; }
  static std::filesystem::path Copy(const std::string& name) {
    std::filesystem::copy(Original(), folder_->path() / name,
                          std::filesystem::copy_options::recursive);
    return folder_->path() / name;
  }

  static std::unique_ptr<MappingPipeline> Open(const std::filesystem::path& sequence,
                                               const FrameRange& frames, std::uint64_t seed = 1,
                                               const MapperOptions& options = {}) {
    RunRecipe recipe;
    recipe.options = options;
    recipe.sequence = sequence;
    recipe.frames = frames;
    recipe.seed = seed;
    Result<std::unique_ptr<MappingPipeline>> opened = MappingPipeline::Open(recipe, {});
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(opened).value();
  }
  static std::vector<FrameReport> Rest(MappingPipeline& pipeline) {
    std::vector<FrameReport> reports;
    while (const auto snapshot = pipeline.Next()) reports.push_back((*snapshot)->report);
    return reports;
  }
  static std::vector<FrameReport> Run(const std::filesystem::path& sequence,
                                      const FrameRange& frames, std::uint64_t seed = 1) {
    return Rest(*Open(sequence, frames, seed));
  }
  static void ExpectSame(const FrameReport& a, const FrameReport& b) {
    EXPECT_TRUE(BytesOf(a) == BytesOf(b)) << "frame " << a.frame << " differs";
  }
  static const std::vector<FrameReport>& WholeRun() {
    static const std::vector<FrameReport> run = Run(Original(), {});
    return run;
  }

  static TemporaryFolder* folder_;
};
TemporaryFolder* PipelineTest::folder_ = nullptr;

TEST_F(PipelineTest, FindsTheTableAndTheChairs) {
  const std::vector<FrameReport>& run = WholeRun();
  ASSERT_EQ(run.size(), 70u);
  std::vector<bool> found(DrawnObjects().size(), false);
  int confirmed = 0;
  for (const ObjectReport& object : run.back().objects) {
    if (object.state != ObjectState::kConfirmed) continue;
    ++confirmed;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const PlacedModel truth = DrawnObjects()[i];
      const Eigen::Isometry3d error = truth.world_from_object.inverse() * object.world_from_object;
      double turn = Eigen::AngleAxisd(error.linear()).angle();
      if (object.category == "dining table") turn = std::min(turn, std::numbers::pi - turn);
      const bool table = i == 0;
      found[i] = found[i] || (table == (object.category == "dining table") &&
                              error.translation().norm() < 0.05 && turn < 0.09);
    }
  }
  EXPECT_EQ(confirmed, 3);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_TRUE(found[i]) << "object " << i;
}

TEST_F(PipelineTest, RatesTheParticlesOfEveryObjectThatIsWeighedAlsoAfterAMove) {
  int rated = 0;
  for (const FrameReport& report : WholeRun()) {
    for (const ObjectReport& object : report.objects) {
      if (!object.updated || object.first_frame == report.frame) continue;
      EXPECT_TRUE(std::any_of(object.particles->begin(), object.particles->end(),
                              [](const Particle& p) { return p.phi_edge != 0; }))
          << "frame " << report.frame << " object " << object.id.value;
      ++rated;
    }
  }
  EXPECT_GT(rated, 60);
}

TEST_F(PipelineTest, RepeatsBitForBit) {
  const std::vector<FrameReport> again = Run(Original(), {});
  ASSERT_EQ(again.size(), WholeRun().size());
  for (std::size_t i = 0; i < again.size(); ++i) ExpectSame(again[i], WholeRun()[i]);
  const std::vector<FrameReport> other = Run(Original(), {.end = 12}, 2);
  EXPECT_FALSE(BytesOf(other.back()) == BytesOf(WholeRun()[11])) << "another seed";
}

TEST_F(PipelineTest, RepeatsBitForBitOnOneThread) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<FrameReport> again = Run(Original(), {.end = 40});
  ASSERT_EQ(again.size(), 40u);
  for (std::size_t i = 0; i < again.size(); ++i) ExpectSame(again[i], WholeRun()[i]);
}

TEST_F(PipelineTest, LiveItMapsTheFramesThatItTakesAsAnyRunDoes) {
  RunRecipe recipe;
  recipe.sequence = Original();
  recipe.seed = 1;
  recipe.frames = {.end = 12, .step = 6};  // the first and the last of two are always taken
  recipe.live_speed = 2;
  const auto pipeline = MappingPipeline::Open(recipe, {}).value();
  const std::vector<FrameReport> run = Rest(*pipeline);
  const std::vector<FrameReport> offline = Run(Original(), recipe.frames);
  ASSERT_EQ(run.size(), 2u);
  for (std::size_t i = 0; i < run.size(); ++i) ExpectSame(run[i], offline[i]);
  EXPECT_EQ(pipeline->live()->passed_over, 0);
}

TEST_F(PipelineTest, LiveItPassesOverWhatItHasNoTimeForAndEndsWithTheLastFrame) {
  RunRecipe recipe;
  recipe.sequence = Original();
  recipe.frames = {.begin = 3, .end = 60, .step = 2};
  recipe.live_speed = 100;
  const auto pipeline = MappingPipeline::Open(recipe, {}).value();
  EXPECT_EQ(pipeline->num_selected(), 29);
  const std::vector<FrameReport> run = Rest(*pipeline);
  const LiveReport live = *pipeline->live();
  EXPECT_GE(run.front().frame, 3) << "the newest at the time of the first question";
  EXPECT_EQ(run.back().frame, 59);
  EXPECT_LT(run.size(), 29u) << "29 frames in 56 ms";
  EXPECT_EQ(live.done, static_cast<int>(run.size()));
  EXPECT_EQ(live.came(), 29);
  EXPECT_EQ(pipeline->num_done(), 29);
  for (std::size_t i = 1; i < run.size(); ++i) {
    EXPECT_GT(run[i].frame, run[i - 1].frame);
    EXPECT_EQ(run[i].frame % 2, 1) << "of those that are selected";
  }
}

TEST_F(PipelineTest, LiveItTurnsAwayWhatItCannotPlay) {
  RunRecipe recipe;
  recipe.sequence = Original();
  for (const double speed : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    recipe.live_speed = speed;
    const auto opened = MappingPipeline::Open(recipe, {});
    ASSERT_FALSE(opened.ok()) << speed;
    EXPECT_THAT(opened.error().message, HasSubstr("0.01 to 100 times"));
  }
  recipe.live_speed = 1;
  recipe.poses.source = PoseSource::kVio;
  EXPECT_THAT(MappingPipeline::Open(recipe, {}).error().message, HasSubstr("loops=causal"));
}

/// Poses of a filter that is right until `from` and then off by `drift`, in three frames, and says
/// that it may be.
std::shared_ptr<const OwnPoses> PosesThatDrift(const Sequence& truth, int from,
                                               const Eigen::Isometry3d& drift) {
  auto poses = std::make_shared<OwnPoses>();
  poses->frames.resize(static_cast<std::size_t>(truth.num_frames()));
  for (int i = 0; i < truth.num_frames(); ++i) {
    OwnPoseReport& frame = poses->frames[static_cast<std::size_t>(i)];
    const double share = std::clamp((i - from) / 3.0, 0.0, 1.0);
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    moved.linear() = Eigen::Quaterniond::Identity()
                         .slerp(share, Eigen::Quaterniond(drift.linear()))
                         .toRotationMatrix();
    moved.translation() = share * drift.translation();
    frame.ready = true;
    frame.vio.phase = VioPhase::kTracking;
    frame.vio.stamp_ns = truth.stamp_ns(i);
    frame.world_from_cam = moved * *truth.world_from_cam(i);
    const double spread = 1e-4 + 0.09 * share;  // as it is told, inflated
    // Of a turn about the origin and a move, as the drift is; and as it shows in each camera.
    PoseCovariance of_world = PoseCovariance::Zero();
    of_world.diagonal() << spread * spread, spread * spread, spread * spread, 1e-8, 1e-8,
        0.1 * spread * spread;
    frame.cam_covariance = MovedBy(frame.world_from_cam->translation(), of_world);
    frame.floor = FloorReport{0, 0.01, 100};
  }
  return poses;
}

/// Frames 0 to 54 show the room from side to side, so the objects are known before poses drift.
class LandmarkPipelineTest : public PipelineTest {
 protected:
  static constexpr int kDriftsFrom = 40;
  LandmarkPipelineTest() {
    drift_.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    drift_.translation() << -0.05, 0.04, 0.0;
    truth_ = OpenSequence(Original()).value();
    poses_ = PosesThatDrift(*truth_, kDriftsFrom, drift_);
  }
  std::unique_ptr<MappingPipeline> OpenDrifting(double landmark_drift_m) {
    RunRecipe recipe;
    recipe.sequence = Original();
    recipe.seed = 1;
    recipe.poses.source = PoseSource::kVio;
    recipe.options.landmark_drift_m = landmark_drift_m;
    auto opened = MappingPipeline::Open(recipe, {}, poses_);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(opened).value();
  }
  double ErrorOf(const FrameReport& report) const {
    return (report.world_from_cam->translation() -
            truth_->world_from_cam(report.frame)->translation())
        .norm();
  }
  static LandmarkHistory LandmarksOf(const std::vector<FrameReport>& run, int last_frame) {
    LandmarkHistory history;
    for (const FrameReport& report : run) {
      for (const LifeEvent& event : report.events) {
        if (event.kind == EventKind::kPosesCorrected && report.frame <= last_frame)
          history[report.frame] = LandmarkEdgesFromText(event.landmarks).value();
      }
    }
    return history;
  }

  Eigen::Isometry3d drift_ = Eigen::Isometry3d::Identity();
  std::shared_ptr<const Sequence> truth_;
  std::shared_ptr<const OwnPoses> poses_;
};

TEST_F(LandmarkPipelineTest, ObjectsSeenAgainCorrectPosesAndNoneStandsTwice) {
  const auto drifting = OpenDrifting(0);
  const std::vector<FrameReport> without = Rest(*drifting);
  ASSERT_GT(ErrorOf(without.back()), 0.07);
  EXPECT_TRUE(LandmarksOf(without, 1000).empty());

  const auto pipeline = OpenDrifting(0.02);
  const std::vector<FrameReport> run = Rest(*pipeline);
  const LandmarkHistory landmarks = LandmarksOf(run, 1000);
  ASSERT_FALSE(landmarks.empty());
  EXPECT_GT(landmarks.begin()->first, kDriftsFrom);
  EXPECT_LT(ErrorOf(run.back()), 0.02);
  int confirmed = 0;
  for (const ObjectReport& object : run.back().objects)
    confirmed += object.state == ObjectState::kConfirmed;
  EXPECT_EQ(confirmed, 3);
  // In the end it is known where the frames were that were mapped while nobody knew of the drift.
  const int late = landmarks.begin()->first;
  EXPECT_GT(ErrorOf(run[static_cast<std::size_t>(late)]), 0.04);
  pipeline->LookBack(landmarks);
  EXPECT_LT(
      (pipeline->PoseInTheEnd(late)->translation() - truth_->world_from_cam(late)->translation())
          .norm(),
      0.025);
  EXPECT_LT((pipeline->InputAgain(late)->world_from_cam.translation() -
             truth_->world_from_cam(late)->translation())
                .norm(),
            0.025);

  // A resumed run is the same, whenever it was left.
  for (const int after : {kDriftsFrom, late - 1, late, late + 2}) {
    const auto resumed = OpenDrifting(0.02);
    ASSERT_TRUE(
        resumed->Resume(run[static_cast<std::size_t>(after)], {}, LandmarksOf(run, after)).ok());
    const std::vector<FrameReport> rest = Rest(*resumed);
    ASSERT_EQ(rest.size(), run.size() - static_cast<std::size_t>(after) - 1);
    for (std::size_t i = 0; i < rest.size(); ++i)
      ExpectSame(rest[i], run[static_cast<std::size_t>(after) + 1 + i]);
  }
}

TEST_F(LandmarkPipelineTest, WhatCameWithTheSequenceIsShownWhereCorrectedPosesHaveIt) {
  const auto pipeline = OpenDrifting(0.02);
  SequenceView view = MakeViewWithoutScan(pipeline->sequence(), *pipeline->database());
  const SequenceView given = MakeViewWithoutScan(*truth_, *pipeline->database());
  // Own and given world are one, but for the drift.
  const auto off = [&] {
    const Eigen::Vector3d camera = given.world_from_cam.back().translation();
    return (view.world_from_given * camera - camera).norm();
  };
  const double before = off();  // the poses as they are told lie between two worlds
  MoveWithCorrections(pipeline->sequence(), *pipeline->landmarks(), view);
  EXPECT_EQ(off(), before);  // nothing is corrected yet
  Rest(*pipeline);
  MoveWithCorrections(pipeline->sequence(), *pipeline->landmarks(), view);
  EXPECT_GT(before, 0.02);
  EXPECT_LT(off(), 0.012);
  EXPECT_LT(
      (view.world_from_cam.back().translation() - given.world_from_cam.back().translation()).norm(),
      0.02);
}

TEST_F(PipelineTest, LiveItStopsWaitingWhenAskedTo) {
  RunRecipe recipe;
  recipe.sequence = Original();
  recipe.live_speed = 0.01;  // 10 s for each frame
  const auto pipeline = MappingPipeline::Open(recipe, {}).value();
  ASSERT_TRUE(pipeline->Next());
  std::stop_source stop;
  std::jthread later([&] { stop.request_stop(); });
  EXPECT_FALSE(pipeline->Next(stop.get_token()));
}

TEST_F(PipelineTest, IsCausal) {
  for (const int end : {1, 7, 33}) {
    const std::vector<FrameReport> part = Run(Original(), {.end = end});
    ASSERT_EQ(part.size(), static_cast<std::size_t>(end));
    for (std::size_t i = 0; i < part.size(); ++i) ExpectSame(part[i], WholeRun()[i]);
  }
}

TEST_F(PipelineTest, ResumesBitForBit) {
  for (const std::size_t after : {0u, 1u, 9u, 30u, 55u, 68u, 69u}) {
    const auto pipeline = Open(Original(), {});
    ASSERT_TRUE(pipeline->Resume(WholeRun()[after]).ok());
    EXPECT_EQ(pipeline->num_done(), static_cast<int>(after) + 1);
    const std::vector<FrameReport> rest = Rest(*pipeline);
    ASSERT_EQ(rest.size(), 69 - after);
    for (std::size_t i = 0; i < rest.size(); ++i) ExpectSame(rest[i], WholeRun()[after + 1 + i]);
  }
}

TEST_F(PipelineTest, ChangesOfOptionsTakeEffectWithTheNextFrame) {
  const auto pipeline = Open(Original(), {.end = 6});
  std::vector<FrameReport> reports;
  for (int i = 0; i < 3; ++i) reports.push_back((*pipeline->Next())->report);
  MapperOptions options;
  options.tentative_particles = 300;
  pipeline->SetOptions(options);
  for (const FrameReport& report : Rest(*pipeline)) reports.push_back(report);
  ASSERT_EQ(reports.size(), 6u);
  ExpectSame(reports[2], WholeRun()[2]);
  ASSERT_FALSE(reports[3].objects.empty());
  EXPECT_EQ(reports[3].objects.front().particles->size(), 300u);
}

TEST_F(PipelineTest, ARunWhoseOptionsChangedTellsOfItAndResumesBitForBit) {
  const auto pipeline = Open(Original(), {.end = 40});
  std::vector<FrameReport> run;
  for (int i = 0; i < 12; ++i) run.push_back((*pipeline->Next())->report);
  MapperOptions options;
  options.search_radius_px = 9;  // frames that are made ready ahead are searched anew
  options.tentative_particles = 400;
  pipeline->SetOptions(options);
  for (const FrameReport& report : Rest(*pipeline)) run.push_back(report);
  ASSERT_EQ(run.size(), 40u);
  ASSERT_FALSE(run[12].events.empty());
  EXPECT_EQ(run[12].events[0].kind, EventKind::kOptionsChanged);
  EXPECT_EQ(run[12].events[0].option_changes, OptionChanges({}, options));
  EXPECT_FALSE(BytesOf(run[39]) == BytesOf(WholeRun()[39]));

  for (const std::size_t after : {11u, 12u, 26u}) {
    const auto resumed = Open(Original(), {.end = 40});
    ASSERT_TRUE(resumed->Resume(run[after], after < 12 ? MapperOptions() : options).ok());
    if (after < 12) resumed->SetOptions(options);
    const std::vector<FrameReport> rest = Rest(*resumed);
    ASSERT_EQ(rest.size(), 39 - after);
    for (std::size_t i = 0; i < rest.size(); ++i) ExpectSame(rest[i], run[after + 1 + i]);
  }
}

TEST_F(PipelineTest, TheAuthorsFilterRepeatsAndResumesBitForBit) {
  MapperOptions options;
  options.filter = FilterKind::kPaper;
  options.paper.particles_per_shape = 200;  // fewer, for time
  const FrameRange frames{.end = 40};
  const std::vector<FrameReport> run = Rest(*Open(Original(), frames, 1, options));
  ASSERT_EQ(run.size(), 40u);
  EXPECT_FALSE(run.back().objects.empty());
  for (const std::size_t after : {0u, 3u, 24u, 38u}) {
    const auto resumed = Open(Original(), frames, 1, options);
    ASSERT_TRUE(resumed->Resume(run[after]).ok());
    const std::vector<FrameReport> rest = Rest(*resumed);
    ASSERT_EQ(rest.size(), 39 - after);
    for (std::size_t i = 0; i < rest.size(); ++i) ExpectSame(rest[i], run[after + 1 + i]);
  }
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  ExpectSame(Rest(*Open(Original(), {.end = 12}, 1, options)).back(), run[11]);
}

TEST_F(PipelineTest, ARunGoesOnFromOneFilterToTheOther) {
  const auto pipeline = Open(Original(), {.end = 60});
  MapperOptions options;
  for (const FilterKind filter : {FilterKind::kPaper, FilterKind::kPosterior}) {
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(pipeline->Next().has_value());
    options.filter = filter;
    pipeline->SetOptions(options);
  }
  const std::vector<FrameReport> rest = Rest(*pipeline);
  ASSERT_EQ(rest.size(), 20u);
  EXPECT_FALSE(rest.back().objects.empty());
}

TEST_F(PipelineTest, TakesEveryNthFrame) {
  const std::vector<FrameReport> run = Run(Original(), {.begin = 5, .end = 30, .step = 6});
  std::vector<int> frames;
  for (const FrameReport& report : run) frames.push_back(report.frame);
  EXPECT_THAT(frames, testing::ElementsAre(5, 11, 17, 23, 29));
}

TEST_F(PipelineTest, SkipsWhatItCannotUseAndSaysSoOnce) {
  const std::filesystem::path sequence = Copy("damaged");
  std::filesystem::resize_file(sequence / "color" / "000011.jpg", 300);
  WriteText(sequence / "edges" / "000020.png", "no image");
  WriteText(sequence / "proposals" / "000025.json", "[{");
  const std::vector<FrameReport> run = Run(sequence, {.end = 40});
  ASSERT_EQ(run.size(), 40u);
  for (const FrameReport& report : run) {
    const bool bad = report.frame == 11 || report.frame == 20 || report.frame == 25;
    EXPECT_EQ(report.skipped.empty(), !bad) << report.skipped;
    int told = 0;
    for (const LifeEvent& event : report.events) told += event.kind == EventKind::kFrameSkipped;
    EXPECT_EQ(told, bad ? 1 : 0);
  }
  EXPECT_THAT(run[11].skipped, HasSubstr("000011.jpg"));
  EXPECT_THAT(run[20].skipped, HasSubstr("000020.png"));
  EXPECT_THAT(run[25].skipped, HasSubstr("000025.json"));
  // The map stays while a frame is skipped, and what comes after counts as usual.
  ASSERT_EQ(run[20].objects.size(), run[19].objects.size());
  for (std::size_t i = 0; i < run[20].objects.size(); ++i) {
    EXPECT_FALSE(run[20].objects[i].updated);
    EXPECT_EQ(run[20].objects[i].particles, run[19].objects[i].particles);
  }
  int confirmed = 0;
  for (const ObjectReport& object : run.back().objects)
    confirmed += object.state == ObjectState::kConfirmed ? 1 : 0;
  EXPECT_GE(confirmed, 2);

  for (const std::size_t after : {11u, 20u, 24u}) {
    const auto pipeline = Open(sequence, {.end = 40});
    ASSERT_TRUE(pipeline->Resume(run[after]).ok());
    const std::vector<FrameReport> rest = Rest(*pipeline);
    ASSERT_EQ(rest.size(), 39 - after);
    for (std::size_t i = 0; i < rest.size(); ++i) ExpectSame(rest[i], run[after + 1 + i]);
  }
}

TEST_F(PipelineTest, SkipsAndResumesBeforeTheFirstUsableFrame) {
  const std::filesystem::path sequence = Copy("late");
  for (const char* file : {"000000.jpg", "000001.jpg"})
    std::filesystem::resize_file(sequence / "color" / file, 100);
  const std::vector<FrameReport> run = Run(sequence, {.end = 10});
  ASSERT_EQ(run.size(), 10u);
  EXPECT_FALSE(run[1].skipped.empty());
  EXPECT_TRUE(run[2].skipped.empty());
  const auto pipeline = Open(sequence, {.end = 10});
  const Status resumed = pipeline->Resume(run[1]);
  ASSERT_TRUE(resumed.ok()) << resumed.error().message;
  const std::vector<FrameReport> rest = Rest(*pipeline);
  ASSERT_EQ(rest.size(), 8u);
  for (std::size_t i = 0; i < rest.size(); ++i) ExpectSame(rest[i], run[2 + i]);
}

TEST_F(PipelineTest, AnObjectThatIsNoLongerDetectedStaysConfirmed) {
  const std::filesystem::path sequence = folder_->path() / "undetected";
  WriteDrawnSequence(sequence, {.frames = 110, .boxes_until = 45});
  const std::vector<FrameReport> run = Run(sequence, {});
  ASSERT_EQ(run.size(), 110u);
  std::vector<ObjectId> confirmed;
  for (const ObjectReport& object : run[44].objects) {
    if (object.state == ObjectState::kConfirmed) confirmed.push_back(object.id);
  }
  EXPECT_GE(confirmed.size(), 2u);
  for (const ObjectId id : confirmed) {
    const auto& last = run.back().objects;
    const auto found = std::find_if(last.begin(), last.end(),
                                    [&](const ObjectReport& object) { return object.id == id; });
    ASSERT_NE(found, last.end()) << "object " << id.value << " went";
    EXPECT_EQ(found->state, ObjectState::kConfirmed);
    EXPECT_GT(found->phi_edge, 0.3f);
  }
}

TEST_F(PipelineTest, SaysWhatItLacks) {
  const std::filesystem::path sequence = Copy("incomplete");
  RunRecipe recipe;
  recipe.sequence = sequence;
  recipe.frames = {.begin = 500};
  auto opened = MappingPipeline::Open(recipe, {});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("none of the 70 frames"));
  recipe.frames = {};
  std::filesystem::remove_all(sequence / "models");
  opened = MappingPipeline::Open(recipe, {});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("--models"));
  std::filesystem::remove(sequence / "gravity.json");
  opened = MappingPipeline::Open(recipe, {});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("gravity.json"));
}

TEST(FrameRange, ParsesItsParts) {
  const auto range = ParseFrameRange("5:30:2");
  ASSERT_TRUE(range.ok());
  EXPECT_EQ(range->begin, 5);
  EXPECT_EQ(range->end, 30);
  EXPECT_EQ(range->step, 2);
  EXPECT_EQ(ParseFrameRange(":")->end, std::nullopt);
  EXPECT_EQ(ParseFrameRange(":7")->end, 7);
  EXPECT_EQ(ParseFrameRange("3:")->begin, 3);
  for (const char* bad : {"", "5", "5:5", "9:3", "a:b", "1:9:0", "1:2:3:4", "-1:5", "1:9:x"})
    EXPECT_FALSE(ParseFrameRange(bad).ok()) << bad;
}

TEST_F(PipelineTest, WithoutPosesOrImagesItSaysWhatToDo) {
  const auto refusal = [](const std::filesystem::path& sequence, const std::string& poses) {
    RunRecipe recipe;
    recipe.sequence = sequence;
    recipe.poses = ParsePoses(poses);
    const auto opened = MappingPipeline::Open(recipe, {});
    return opened.ok() ? std::string("opened") : opened.error().message;
  };
  const std::filesystem::path bare = Copy("bare");
  std::filesystem::remove(bare / "trajectory.txt");
  EXPECT_THAT(
      refusal(bare, "dataset"),
      HasSubstr("has no camera poses; find them from images and IMU with --poses vio, or give a "));
  EXPECT_THAT(refusal(bare, "nowhere.txt"), HasSubstr("nowhere.txt"));
  const std::filesystem::path other = folder_->path() / "other_clock.txt";
  WriteText(other, "5000 0 0 0 0 0 0 1\n");
  EXPECT_THAT(refusal(bare, other.string()), HasSubstr("the same clock"));
  std::filesystem::remove_all(bare / "color");
  WriteText(bare / "tracks.csv", "0,1,5,5\n0.1,1,5,5\n");
  EXPECT_THAT(refusal(bare, "dataset"), HasSubstr("has no images"));
}

TEST_F(PipelineTest, TheSamePosesFromAFileMakeTheSameRun) {
  const std::filesystem::path bare = Copy("posed_by_file");
  const std::filesystem::path poses = folder_->path() / "poses.txt";
  std::filesystem::rename(bare / "trajectory.txt", poses);
  RunRecipe recipe;
  recipe.sequence = bare;
  recipe.poses = ParsePoses(poses.string());
  recipe.frames = {0, 12, 1};
  recipe.seed = 1;
  auto opened = MappingPipeline::Open(recipe, {});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  EXPECT_FALSE((*opened)->recipe().poses.hash.empty());
  const std::vector<FrameReport> run = Rest(**opened);
  ASSERT_EQ(run.size(), 12u);
  for (std::size_t i = 0; i < run.size(); ++i) ExpectSame(run[i], WholeRun()[i]);
}

}  // namespace
}  // namespace plumbline
