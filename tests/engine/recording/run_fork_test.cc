// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_fork.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "engine/analysis/run_difference.h"
#include "engine/mapping/option_changes.h"
#include "engine/recording/option_history.h"
#include "engine/recording/smoothed_record.h"
#include "engine/runtime/mapping_source.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/report_bytes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class RunForkTest : public testing::Test {
 protected:
  RunForkTest() {
    WriteDrawnSequence(folder_.path() / "sequence", {.frames = 30});
    mapping_.recipe.sequence = folder_.path() / "sequence";
    mapping_.recipe.seed = 3;
    after_.alpha = 1;
    after_.search_radius_px = 9;
  }
  std::unique_ptr<SnapshotSource> Live() const {
    auto source = OpenMappingSource(mapping_, WorkContext());
    EXPECT_TRUE(source.ok()) << source.error().message;
    return std::move(source).value();
  }
  static void MapTo(SnapshotSource& source, int frames) {
    while (source.mapped() < frames) ASSERT_TRUE(source.Next({}).ok());
  }
  ForkChoice Fork(const SnapshotSource& source, int at, const MapperOptions& options,
                  const std::string& name) const {
    return {{source.recording(), {}, {}}, at, options, 3, folder_.path() / name, "test"};
  }
  std::unique_ptr<RunReader> Open(const std::filesystem::path& file) const {
    auto reader = RunReader::Open(file);
    EXPECT_TRUE(reader.ok()) << reader.error().message;
    return std::move(reader).value();
  }

  TemporaryFolder folder_;
  MappingChoice mapping_;
  MapperOptions after_;
};

TEST_F(RunForkTest, ALiveRunIsForkedAtAnyFrameThatItHasMapped) {
  const auto source = Live();
  MapTo(*source, 10);
  ASSERT_TRUE(source->SetOptions(after_).ok());
  MapTo(*source, 20);
  // The fork of frame 9 with the options that the run then got is the run itself; from frame 14 on
  // with its first options it is another one.
  ASSERT_TRUE(ForkRun(Fork(*source, 9, after_, "same.plb"), WorkContext()).ok());
  ASSERT_TRUE(ForkRun(Fork(*source, 14, {}, "back.plb"), WorkContext()).ok());
  MapTo(*source, 30);
  const auto same = Open(folder_.path() / "same.plb"), back = Open(folder_.path() / "back.plb");
  ASSERT_EQ(same->NumFrames().value(), 30);
  ASSERT_EQ(back->NumFrames().value(), 30);
  for (const int frame : {0, 9, 10, 14, 15, 29}) {
    const auto live = BytesOf((*source->Past(frame, {}))->report);
    EXPECT_EQ(BytesOf(same->ReadFrame(frame).value()) == live, true) << frame;
    EXPECT_EQ(BytesOf(back->ReadFrame(frame).value()) == live, frame <= 14) << frame;
  }
  const auto events = Open(source->recording())->Events().value();
  EXPECT_EQ(std::count_if(events.begin(), events.end(),
                          [&](const RunEvent& event) {
                            return event.event.kind == EventKind::kOptionsChanged &&
                                   event.frame == 10 &&
                                   event.event.option_changes == OptionChanges({}, after_);
                          }),
            1);
}

TEST_F(RunForkTest, TheOptionsOfEveryFrameAreKnownAfterwards) {
  const auto source = Live();
  MapTo(*source, 10);
  ASSERT_TRUE(source->SetOptions(after_).ok());
  MapTo(*source, 20);
  ASSERT_TRUE(ForkRun(Fork(*source, 14, {}, "back.plb"), WorkContext()).ok());
  const auto run = Open(source->recording());
  const auto options = OptionHistory::Read(*run);
  ASSERT_TRUE(options.ok());
  EXPECT_EQ(OptionChanges(options->At(9), {}), "");
  EXPECT_EQ(OptionChanges(options->At(10), after_), "");
  EXPECT_EQ(OptionChanges(options->newest(), after_), "");
  // What the fork took over changed options, but not those that the fork goes on with.
  const auto fork = Open(folder_.path() / "back.plb");
  EXPECT_EQ(fork->header().forked_after, 14);
  EXPECT_EQ(OptionChanges(OptionHistory::Read(*fork)->newest(), {}), "");
  EXPECT_THAT(ChangesOnTheWay("first", run->header(), run->Events().value()),
              testing::ElementsAre("first run, from frame 10: " +
                                   DescribeOptionChanges(OptionChanges({}, after_))));
  EXPECT_THAT(ChangesOnTheWay("other", fork->header(), fork->Events().value()), testing::IsEmpty());
}

TEST_F(RunForkTest, AStoppedForkKeepsWhatIsDone) {
  const auto source = Live();
  MapTo(*source, 10);
  std::stop_source stop;
  const WorkContext work{[&](const Progress& progress) {
                           if (progress.done == 20) stop.request_stop();
                         },
                         stop.get_token()};
  const Status status = ForkRun(Fork(*source, 5, after_, "part.plb"), work);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kCancelled);
  const auto part = Open(folder_.path() / "part.plb");
  EXPECT_EQ(part->NumFrames().value(), 20);
  EXPECT_TRUE(part->Finished().value());
}

TEST_F(RunForkTest, AForkCanBeGivenACandidate) {
  const auto source = Live();
  MapTo(*source, 4);
  ForkChoice choice = Fork(*source, 2, {}, "planted.plb");
  choice.plant = PlantedObject{"chair", Eigen::Isometry3d::Identity(), 1, "planted by a test"};
  ASSERT_TRUE(ForkRun(choice, WorkContext()).ok());
  const auto fork = Open(folder_.path() / "planted.plb");
  const auto events = fork->Events().value();
  const auto planted = std::find_if(events.begin(), events.end(), [](const RunEvent& event) {
    return event.event.text == "planted by a test";
  });
  ASSERT_NE(planted, events.end());
  EXPECT_EQ(planted->frame, 3) << "after what was taken over";
  EXPECT_EQ(planted->event.kind, EventKind::kSpawned);
  choice.plant->model = "throne";
  choice.out = folder_.path() / "none.plb";
  const Status status = ForkRun(choice, WorkContext());
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, testing::HasSubstr("no 'throne'"));
}

TEST_F(RunForkTest, ARecordedRunKeepsItsOptions) {
  {
    mapping_.out = folder_.path() / "run.plb";
    const auto source = Live();
    MapTo(*source, 3);
  }
  auto run = OpenRunSource({mapping_.out, {}, {}}, WorkContext());
  ASSERT_TRUE(run.ok());
  EXPECT_EQ((*run)->SetOptions(after_).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ((*run)->recording(), mapping_.out);
  EXPECT_EQ((*run)->view().smoothed, nullptr);
}

TEST_F(RunForkTest, ARecordedRunShowsItsSecondPass) {
  mapping_.out = folder_.path() / "run.plb";
  {
    const auto source = Live();
    MapTo(*source, 3);
  }
  const FrameReport last = Open(mapping_.out)->LastFrame().value();
  ASSERT_FALSE(last.objects.empty());
  SmoothedMap map;
  map.last_frame = last.frame;
  map.objects.push_back({last.objects.front()});
  map.objects.front().looks = 7;
  ASSERT_TRUE(WriteSmoothed(mapping_.out, map).ok());
  auto run = OpenRunSource({mapping_.out, {}, {}}, WorkContext());
  ASSERT_TRUE(run.ok()) << run.error().message;
  ASSERT_NE((*run)->view().smoothed, nullptr);
  EXPECT_EQ((*run)->view().smoothed->objects.at(0).looks, 7);

  map.objects.emplace_back();  // no object of a run: it has no place
  ASSERT_TRUE(WriteSmoothed(mapping_.out, map).ok());
  ASSERT_FALSE(ReadSmoothed(mapping_.out).ok());
  run = OpenRunSource({mapping_.out, {}, {}}, WorkContext());
  ASSERT_TRUE(run.ok()) << "what is broken beside the run does not hide the run";
  EXPECT_EQ((*run)->view().smoothed, nullptr);
}

}  // namespace
}  // namespace plumbline
