// SPDX-License-Identifier: Apache-2.0
// The command `run` as a script meets it: killed at any time it goes on as if it had never stopped.

#include <signal.h>

#include <chrono>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/dataset/json_fields.h"
#include "engine/recording/run_file.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/program_process.h"
#include "tests/support/report_bytes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr int kFrames = 50;

class RunVerb : public testing::Test {
 protected:
  RunVerb() { WriteDrawnSequence(folder_.path() / "sequence", {.frames = kFrames}); }

  std::string Path(const char* name) const { return (folder_.path() / name).string(); }

  pid_t Start(std::vector<std::string> arguments) const {
    return StartProgram(std::move(arguments), Path("output.txt"));
  }
  pid_t StartRun(const char* file, bool resume) const {
    std::vector<std::string> arguments = {"run",      Path("sequence"), "--out",
                                          Path(file), "--seed",         "3"};
    if (resume) arguments.push_back("--resume");
    return Start(arguments);
  }
  int FramesIn(const char* file) const {
    const auto reader = RunReader::Open(Path(file));
    if (!reader.ok()) return 0;
    const Result<int> frames = (*reader)->NumFrames();
    return frames.ok() ? *frames : 0;
  }

  TemporaryFolder folder_;
};

TEST_F(RunVerb, KilledAgainAndAgainItEndsWithTheSameRun) {
  ASSERT_EQ(WaitFor(StartRun("whole.plb", false)), 0) << *ReadFile(Path("output.txt"));
  ASSERT_EQ(FramesIn("whole.plb"), kFrames);

  Random random({.seed = static_cast<std::uint64_t>(
                     std::chrono::steady_clock::now().time_since_epoch().count())});
  int kills = 0;
  while (FramesIn("killed.plb") < kFrames) {
    const int before = FramesIn("killed.plb");
    const pid_t process = StartRun("killed.plb", true);
    // Sometimes before it has done anything, sometimes in the middle of a frame.
    const int more = static_cast<int>(random.Index(18));
    while (IsRunning(process) && FramesIn("killed.plb") < before + more)
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    std::this_thread::sleep_for(std::chrono::microseconds(random.Index(60000)));
    if (IsRunning(process)) kills += kill(process, SIGKILL) == 0 ? 1 : 0;
    const int code = WaitFor(process);
    ASSERT_TRUE(code == 0 || code == -SIGKILL) << code << ": " << *ReadFile(Path("output.txt"));
  }
  // The last frame may have been written before the end of the run was.
  ASSERT_EQ(WaitFor(StartRun("killed.plb", true)), 0) << *ReadFile(Path("output.txt"));
  EXPECT_GE(kills, 2);
  RecordProperty("kills", kills);

  const auto whole = RunReader::Open(Path("whole.plb")).value();
  const auto killed = RunReader::Open(Path("killed.plb")).value();
  ASSERT_EQ(killed->NumFrames().value(), kFrames);
  EXPECT_TRUE(killed->Finished().value());
  for (int position = 0; position < kFrames; ++position) {
    EXPECT_TRUE(BytesOf(whole->ReadFrame(position).value()) ==
                BytesOf(killed->ReadFrame(position).value()))
        << "frame " << position << " differs after " << kills << " kills";
  }
}

TEST_F(RunVerb, InterruptedItKeepsWhatIsDone) {
  const pid_t process = StartRun("stopped.plb", false);
  while (IsRunning(process) && FramesIn("stopped.plb") < 5)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  kill(process, SIGINT);
  EXPECT_EQ(WaitFor(process), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("--resume"));
  EXPECT_GE(FramesIn("stopped.plb"), 5);
  ASSERT_EQ(WaitFor(StartRun("stopped.plb", true)), 0) << *ReadFile(Path("output.txt"));
  EXPECT_EQ(FramesIn("stopped.plb"), kFrames);
}

TEST_F(RunVerb, SmoothsBesideItsResultNowOrLater) {
  ASSERT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("a.plb"), "--seed", "3", "--json",
                           Path("now.json"), "--smooth"})),
            0)
      << *ReadFile(Path("output.txt"));
  ASSERT_EQ(WaitFor(StartRun("b.plb", false)), 0);
  const auto causal = RunReader::Open(Path("b.plb")).value();
  EXPECT_EQ(BytesOf(RunReader::Open(Path("a.plb")).value()->LastFrame().value()),
            BytesOf(causal->LastFrame().value()))
      << "the run is as it would be without";

  const pid_t stopped = Start({"smooth", Path("b.plb")});
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  kill(stopped, SIGINT);
  if (WaitFor(stopped) == 1) {  // it may have been faster
    EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("keeps the run"));
    EXPECT_EQ(FramesIn("b.plb"), kFrames);
  }
  ASSERT_EQ(WaitFor(Start({"smooth", Path("b.plb"), "--json", Path("later.json")})), 0)
      << *ReadFile(Path("output.txt"));
  const nlohmann::json now = ReadJson(Path("now.json")).value();
  const nlohmann::json later = ReadJson(Path("later.json")).value();
  EXPECT_EQ(now.at("objects"), later.at("objects"));
  EXPECT_EQ(now.at("smoothed"), later.at("smoothed")) << "the same, from the same run";
  EXPECT_EQ(now.at("smoothed").at("objects").size(), 3u);
  EXPECT_EQ(WaitFor(Start({"export", Path("b.plb"), "--format", "ply", "--smoothed", "--out",
                           Path("b.ply")})),
            0)
      << *ReadFile(Path("output.txt"));
}

TEST_F(RunVerb, LiveItSaysWhatItPassedOverAndCanBeForkedButNotResumed) {
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"run", Path("sequence")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return WaitFor(Start(arguments));
  };
  const auto said = [&] { return ReadFile(Path("output.txt")).value(); };
  ASSERT_EQ(run({"--out", Path("live.plb"), "--live=50", "--json", Path("live.json")}), 0)
      << said();
  EXPECT_THAT(said(), testing::HasSubstr(" of 50 frames as they came (4.9 s at speed 50); "));
  EXPECT_THAT(said(), testing::HasSubstr("boxes: dataset, edges: dataset\n"));
  const nlohmann::json live = ReadJson(Path("live.json")).value().at("live");
  EXPECT_EQ(live.at("mapped").get<int>() + live.at("passed_over").get<int>(), kFrames);
  EXPECT_GT(live.at("passed_over"), 0);
  const int mapped = FramesIn("live.plb");
  EXPECT_EQ(live.at("mapped"), mapped);
  const auto whole = RunReader::Open(Path("live.plb")).value();
  EXPECT_EQ(whole->header().recipe.live_speed, 50);
  EXPECT_EQ(whole->LastFrame()->frame, kFrames - 1) << "the last is always mapped";
  ASSERT_EQ(WaitFor(Start({"info", Path("live.plb")})), 0);
  EXPECT_THAT(said(), testing::HasSubstr(std::to_string(mapped) + " of 50 frames that came"));
  EXPECT_EQ(WaitFor(Start({"smooth", Path("live.plb")})), 0) << said();

  EXPECT_EQ(run({"--out", Path("b.plb"), "--live", "--resume"}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("--live cannot go with --resume"));
  EXPECT_EQ(run({"--out", Path("b.plb"), "--live", "--fork", Path("live.plb")}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("--live cannot go with --fork"));
  EXPECT_EQ(run({"--out", Path("live.plb"), "--resume"}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("a live run cannot be resumed"));
  EXPECT_EQ(FramesIn("live.plb"), mapped);
  const int first = whole->Frames().value().front().frame;  // a busy machine passes over 0
  ASSERT_EQ(
      run({"--out", Path("fork.plb"), "--fork", Path("live.plb"), "--at", std::to_string(first)}),
      0)
      << said();
  EXPECT_EQ(FramesIn("fork.plb"), kFrames - first) << "every frame after what it took over";
  EXPECT_EQ(run({"--out", Path("b.plb"), "--live=fast"}), 1);
  EXPECT_THAT(said(), testing::HasSubstr("'fast' is no speed"));
}

TEST_F(RunVerb, ForkedWithTheSameOptionsItIsTheSameRun) {
  ASSERT_EQ(WaitFor(StartRun("whole.plb", false)), 0);
  const auto fork = [&](const char* file, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"run",    Path("sequence"),  "--out", Path(file),
                                          "--fork", Path("whole.plb"), "--at",  "20"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return WaitFor(Start(arguments));
  };
  ASSERT_EQ(fork("same.plb", {"--seed", "3"}), 0) << ReadFile(Path("output.txt")).value();
  ASSERT_EQ(fork("other.plb", {"--seed", "4", "--set", "alpha=1"}), 0);
  const auto whole = RunReader::Open(Path("whole.plb")).value();
  const auto same = RunReader::Open(Path("same.plb")).value();
  const auto other = RunReader::Open(Path("other.plb")).value();
  ASSERT_EQ(same->NumFrames().value(), kFrames);
  ASSERT_EQ(other->NumFrames().value(), kFrames);
  EXPECT_EQ(other->header().recipe.seed, 4u);
  for (int i = 0; i < kFrames; ++i)
    EXPECT_EQ(BytesOf(same->ReadFrame(i).value()), BytesOf(whole->ReadFrame(i).value())) << i;
  EXPECT_EQ(BytesOf(other->ReadFrame(20).value()), BytesOf(whole->ReadFrame(20).value()));
  EXPECT_NE(BytesOf(other->LastFrame().value()), BytesOf(whole->LastFrame().value()));
  EXPECT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("whole.plb"), "--fork",
                           Path("whole.plb")})),
            1);
  EXPECT_EQ(FramesIn("whole.plb"), kFrames) << "a run is not overwritten by its own fork";
}

TEST_F(RunVerb, WhatItMissedCanBePlanted) {
  nlohmann::json instances = nlohmann::json::array();
  for (const PlacedModel& object : DrawnObjects()) {
    const auto& model = MappingScene::Get().database()->model(object.label);
    instances.push_back({{"id", std::to_string(object.object.value)},
                         {"model", model.name},
                         {"category", model.category},
                         {"world_from_object", IsometryToJson(object.world_from_object)}});
  }
  const nlohmann::json truth = {{"gravity", {0, 0, -1}}, {"instances", instances}};
  ASSERT_TRUE(WriteFileAtomically(Path("sequence/ground_truth.json"), truth.dump()).ok());
  // Nothing is ever confirmed, so every instance is missed.
  ASSERT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("shy.plb"), "--set",
                           "confirm_evidence=50"})),
            0);
  ASSERT_EQ(WaitFor(Start({"evaluate", Path("shy.plb"), "--ground-truth",
                           Path("sequence/ground_truth.json"), "--models", Path("sequence/models"),
                           "--plant", Path("planted"), "--json", Path("result.json")})),
            0)
      << ReadFile(Path("output.txt")).value();
  const nlohmann::json result = ReadJson(Path("result.json")).value();
  int planted = 0;
  for (const nlohmann::json& missed : result.at("missed_instances")) {
    if (!missed.contains("planted")) continue;
    ++planted;
    EXPECT_EQ(missed["planted"]["blame"], "being there") << missed.dump(1);
    const std::string fork = "planted/shy." + missed["ground_truth"].get<std::string>() + ".plb";
    EXPECT_EQ(FramesIn(fork.c_str()), kFrames);
  }
  EXPECT_GE(planted, 3);
}

TEST_F(RunVerb, DoesNotResumeAnotherRun) {
  ASSERT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("a.plb"), "--frames", "0:3"})),
            0);
  EXPECT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("a.plb"), "--resume", "--set",
                           "particles=300"})),
            1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("a.plb"));
}

TEST_F(RunVerb, KeepsThePresetInTheRun) {
  const std::vector<std::string> paper = {
      "run", Path("sequence"), "--frames", "0:12", "--preset", "paper", "--set", "paper_depth_m=3"};
  const auto start = [&](std::vector<std::string> arguments, std::vector<std::string> more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return WaitFor(Start(arguments));
  };
  ASSERT_EQ(start(paper, {"--out", Path("whole.plb")}), 0) << *ReadFile(Path("output.txt"));
  const auto whole = RunReader::Open(Path("whole.plb")).value();
  EXPECT_EQ(whole->header().recipe.options.filter, FilterKind::kPaper);
  EXPECT_EQ(whole->header().recipe.options.paper.depth_m, 3);
  ASSERT_EQ(start(paper, {"--out", Path("fork.plb"), "--fork", Path("whole.plb"), "--at", "5"}), 0);
  const auto fork = RunReader::Open(Path("fork.plb")).value();
  EXPECT_EQ(BytesOf(fork->LastFrame().value()), BytesOf(whole->LastFrame().value()));

  EXPECT_EQ(WaitFor(Start({"run", Path("sequence"), "--frames", "0:12", "--out", Path("whole.plb"),
                           "--resume"})),
            1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("'filter'"));
}

TEST_F(RunVerb, WritesItsResultAsJson) {
  ASSERT_EQ(WaitFor(Start(
                {"run", Path("sequence"), "--out", Path("a.plb"), "--json", Path("result.json")})),
            0)
      << *ReadFile(Path("output.txt"));
  const nlohmann::json result = ReadJson(Path("result.json")).value();
  EXPECT_EQ(result.at("frames"), kFrames);
  EXPECT_EQ(result.at("skipped"), 0);
  int confirmed = 0;
  for (const nlohmann::json& object : result.at("objects")) {
    confirmed += object.at("confirmed").get<bool>() ? 1 : 0;
    EXPECT_EQ(object.at("world_from_object").size(), 4u);
  }
  EXPECT_EQ(confirmed, 3);
}

TEST_F(RunVerb, ExportsHowObjectsStandToOneAnother) {
  ASSERT_EQ(WaitFor(StartRun("a.plb", false)), 0);
  ASSERT_EQ(WaitFor(Start({"export", Path("a.plb"), "--format", "json", "--out", Path("a.json")})),
            0)
      << *ReadFile(Path("output.txt"));
  const nlohmann::json last = ReadJson(Path("a.json")).value().at("last_frame");
  EXPECT_EQ(last.at("frame"), kFrames - 1);
  int nearest = 0;
  for (const nlohmann::json& relation : last.at("relations")) {
    nearest += relation.at("is") == "is nearest to" && relation.at("gap_m") >= 0;
  }
  EXPECT_EQ(nearest, 3) << "one for each confirmed object";
}

TEST_F(RunVerb, GoesOnOnlyWithTheSamePoses) {
  const auto poses = folder_.path() / "poses.txt";
  std::filesystem::rename(folder_.path() / "sequence/trajectory.txt", poses);
  EXPECT_EQ(WaitFor(StartRun("none.plb", false)), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("--poses FILE"));
  EXPECT_FALSE(std::filesystem::exists(Path("none.plb")));

  std::vector<std::string> run = {"run",     Path("sequence"), "--out",    Path("run.plb"),
                                  "--poses", poses.string(),   "--frames", "0:8"};
  ASSERT_EQ(WaitFor(Start(run)), 0) << *ReadFile(Path("output.txt"));
  const RunHeader header = RunReader::Open(Path("run.plb")).value()->header();
  EXPECT_EQ(header.recipe.poses.file, poses);
  const std::vector<std::string> fork = {"run",      Path("sequence"), "--out", Path("fork.plb"),
                                         "--frames", "0:12",           "--at",  "4",
                                         "--fork",   Path("run.plb")};
  EXPECT_EQ(WaitFor(Start(fork)), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("poses"));
  run.back() = "0:12";
  run.push_back("--resume");
  std::filesystem::rename(poses, Path("moved.txt"));
  run[5] = Path("moved.txt");
  EXPECT_EQ(WaitFor(Start(run)), 0) << "the content counts, not the path";
  ASSERT_TRUE(WriteFileAtomically(Path("moved.txt"), *ReadFile(Path("moved.txt")) + "\n").ok());
  EXPECT_EQ(WaitFor(Start(run)), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("the source of poses"));
}

TEST_F(RunVerb, ARefusedForkLeavesTheRunThatIsThere) {
  ASSERT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("a.plb"), "--frames", "4:9"})),
            0);
  ASSERT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("b.plb"), "--frames", "0:6"})),
            0);
  const std::string before = *ReadFile(Path("b.plb"));
  const auto fork = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"run",         Path("sequence"), "--out",
                                          Path("b.plb"), "--fork",         Path("a.plb")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return WaitFor(Start(arguments));
  };
  EXPECT_EQ(fork({"--frames", "4:9", "--at", "-5"}), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("has no frame that early"));
  EXPECT_EQ(fork({}), 1) << "of other frames";
  EXPECT_EQ(*ReadFile(Path("b.plb")), before);
}

TEST_F(RunVerb, TwoRunsDoNotWriteOneFile) {
  const pid_t first = StartRun("a.plb", false);
  while (IsRunning(first) && FramesIn("a.plb") < 1)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  kill(first, SIGSTOP);
  for (const bool resume : {false, true}) {
    EXPECT_EQ(WaitFor(StartRun("a.plb", resume)), 1);
    EXPECT_THAT(*ReadFile(Path("output.txt")),
                testing::HasSubstr("a.plb' is open in another window or command (process " +
                                   std::to_string(first)));
  }
  kill(first, SIGCONT);
  EXPECT_EQ(WaitFor(first), 0);
  EXPECT_EQ(FramesIn("a.plb"), kFrames);
  EXPECT_FALSE(std::filesystem::exists(Path("a.plb.lock")));
}

TEST_F(RunVerb, WithoutAUsableFrameItFailsAndSaysWhy) {
  for (const auto& image :
       std::filesystem::directory_iterator(folder_.path() / "sequence" / "color")) {
    std::ofstream(image.path()) << "no image";
  }
  EXPECT_EQ(WaitFor(StartRun("a.plb", false)), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("none of the 50 frames of"));
}

TEST_F(RunVerb, OwnPosesNeedAnImuAndSaySo) {
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"run", Path("sequence"), "--out", Path("a.plb")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return WaitFor(Start(arguments));
  };
  EXPECT_EQ(run({"--poses", "vio"}), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("no readings of an IMU"));
  EXPECT_EQ(run({"--set-poses", "ready_tilt_deg=2"}), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("goes with --poses vio"));
  EXPECT_EQ(run({"--poses", "vio", "--set-poses", "ready_tilt=2"}), 1);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("did you mean 'ready_tilt_deg'"));
}

TEST_F(RunVerb, LiveItFindsItsPosesWhileItPlays) {
  ASSERT_EQ(WaitFor(Start({"synth", "--imu", "--rest", "2", "--size", "320x240", "--rate", "10",
                           "--frames", "60", "--light-rays", "4", "--out", Path("film")})),
            0);
  const auto run = [&](const char* file, const char* speed) {
    return WaitFor(Start({"run", Path("film"), "--poses", "vio", "--out", Path(file), speed}));
  };
  ASSERT_EQ(run("live.plb", "--live=1"), 0) << *ReadFile(Path("output.txt"));
  ASSERT_EQ(WaitFor(Start({"run", Path("film"), "--poses", "vio", "--set-poses", "loops=causal",
                           "--out", Path("whole.plb")})),
            0)
      << *ReadFile(Path("output.txt"));
  const auto poses = [&](const char* file) {
    return RunReader::Open(Path(file)).value()->ReadOwnPoses().value();
  };
  // However many images the mapper passed over: the filter looked at all, and found the same.
  const auto live = poses("live.plb"), whole = poses("whole.plb");
  ASSERT_EQ(live->frames.size(), 60u);
  ASSERT_EQ(whole->frames.size(), 60u);
  EXPECT_TRUE(live->causal);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(live->frames[i].ready, whole->frames[i].ready) << i;
    ASSERT_EQ(live->frames[i].world_from_cam.has_value(),
              whole->frames[i].world_from_cam.has_value());
    if (live->frames[i].world_from_cam) {
      EXPECT_EQ(live->frames[i].world_from_cam->matrix(),
                whole->frames[i].world_from_cam->matrix());
    }
  }
  EXPECT_TRUE(live->frames.back().ready) << live->frames.back().waits_for;
  // What goes on from it has the same poses.
  ASSERT_EQ(WaitFor(Start({"run", Path("film"), "--poses", "vio", "--set-poses", "loops=causal",
                           "--fork", Path("live.plb"), "--at", "30", "--out", Path("fork.plb")})),
            0)
      << *ReadFile(Path("output.txt"));
  EXPECT_EQ(poses("fork.plb")->frames.size(), 60u);
}

TEST_F(RunVerb, AsksForNamesInUtf8AndWholeSeeds) {
  const std::string folder = Path("caf\xe9");
  std::filesystem::rename(Path("sequence"), folder);
  EXPECT_EQ(WaitFor(Start({"run", folder, "--out", Path("a.plb")})), 2);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("is not UTF-8 text; rename"));
  EXPECT_EQ(WaitFor(Start({"run", Path("sequence"), "--out", Path("a.plb"), "--seed", "-1"})), 2);
  EXPECT_THAT(*ReadFile(Path("output.txt")), testing::HasSubstr("'-1' is no seed"));
}

}  // namespace
}  // namespace plumbline
