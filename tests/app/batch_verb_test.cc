// SPDX-License-Identifier: Apache-2.0
// The command `batch` as its user meets it: killed it goes on, a crash takes its own run only, and
// the gate tells what got worse.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/batch/batch_results.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/program_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class BatchVerb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    for (const char* name : {"a", "b"}) {
      WriteDrawnSequence(Path(name), {.frames = name[0] == 'a' ? 10 : 12});
      ASSERT_TRUE(WriteJson(Path(name) / "ground_truth.json", Truth()).ok());
    }
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::filesystem::path Path(const std::string& name) { return folder_->path() / name; }

  static json Truth() {
    json instances = json::array();
    for (const PlacedModel& object : DrawnObjects()) {
      const auto& model =
          MappingScene::Get().database()->models()[static_cast<std::size_t>(object.label.value)];
      json rows = json::array();
      for (int r = 0; r < 4; ++r) {
        json row = json::array();
        for (int c = 0; c < 4; ++c) row.push_back(object.world_from_object.matrix()(r, c));
        rows.push_back(row);
      }
      instances.push_back({{"id", "true-" + std::to_string(instances.size())},
                           {"model", model.name},
                           {"category", model.category},
                           {"world_from_object", rows}});
    }
    return {{"gravity", {0, 0, -1}}, {"instances", instances}};
  }

  static json Plan() {
    return {{"sequences", {"a", "b"}},
            {"recipes", {{{"name", "as it is"}}, {{"name", "short"}, {"frames", "0:6"}}}},
            {"seeds", {0, 1}},
            {"evaluate", {{"samples", 1000}}}};
  }
  static ProgramRun Batch(const json& plan, const std::string& out,
                          const std::string& more = "--jobs 2") {
    EXPECT_TRUE(WriteJson(Path("plan.json"), plan).ok());
    return RunProgram("batch plan.json --out " + out + " " + more + " 2>&1", folder_->path());
  }
  static std::size_t NumDone(const std::string& out) {
    std::error_code error;
    std::size_t done = 0;
    for (const auto& job : std::filesystem::directory_iterator(Path(out) / "jobs", error))
      done += std::filesystem::exists(job.path() / "result.json", error) ? 1 : 0;
    return done;
  }
  /// Why runs failed.
  static std::string Reasons(const std::string& out) {
    std::string reasons;
    for (const BatchRun& run : ReadBatchResults(Path(out)).value().runs) reasons += run.reason;
    return reasons;
  }
  static void ExpectSameResults(const std::string& a, const std::string& b) {
    const BatchTable first = ReadBatchResults(Path(a)).value();
    const BatchTable other = ReadBatchResults(Path(b)).value();
    ASSERT_EQ(first.runs.size(), other.runs.size());
    for (std::size_t i = 0; i < first.runs.size(); ++i) {
      EXPECT_EQ(first.runs[i].status, other.runs[i].status) << i;
      EXPECT_EQ(first.runs[i].figures, other.runs[i].figures) << i;
      EXPECT_EQ(first.runs[i].missed.size(), other.runs[i].missed.size()) << i;
    }
  }
  /// Starts a batch that is ended by hand.
  static pid_t Start(const std::string& out) {
    EXPECT_TRUE(WriteJson(Path("plan.json"), Plan()).ok());
    const std::string plan = Path("plan.json").string(), folder = Path(out).string(),
                      program = ProgramFile().string(), said = Path("said.txt").string();
    const pid_t process = fork();
    if (process == 0) {
      if (std::freopen(said.c_str(), "w", stdout) != nullptr &&
          std::freopen(said.c_str(), "a", stderr) != nullptr)
        execl(program.c_str(), program.c_str(), "batch", plan.c_str(), "--out", folder.c_str(),
              "--jobs", "2", nullptr);
      _exit(127);
    }
    return process;
  }
  static void WaitUntilDone(const std::string& out, std::size_t runs) {
    for (int i = 0; i < 6000 && NumDone(out) < runs; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_GE(NumDone(out), runs);
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(BatchVerb, LeavesATableAndAPage) {
  const ProgramRun run = Batch(Plan(), "whole");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("8 runs, 0 failed"));
  const BatchTable table = ReadBatchResults(Path("whole")).value();
  ASSERT_EQ(table.runs.size(), 8U);
  EXPECT_EQ(table.figures[1].name, "found");
  EXPECT_GT(table.runs[0].figures[1].value_or(0), 0) << "something is found";
  const std::string page = ReadFile(Path("whole") / "report.html").value();
  EXPECT_THAT(page, HasSubstr("Differences to as it is"));
  EXPECT_THAT(page, HasSubstr("run.plb"));
  // Again it has nothing to do, and with one run more it does that one alone.
  EXPECT_THAT(Batch(Plan(), "whole").output, HasSubstr("8 of 8 runs are done"));
  json more = Plan();
  more["seeds"] = {0, 1, 2};
  EXPECT_THAT(Batch(more, "whole").output, HasSubstr("8 of 12 runs are done"));
}

TEST_F(BatchVerb, KilledAgainAndAgainItEndsWithTheSameTable) {
  ASSERT_EQ(Batch(Plan(), "straight").exit_code, 0);
  for (const std::size_t runs : {0U, 2U, 5U}) {
    const pid_t process = Start("killed");
    WaitUntilDone("killed", runs);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ASSERT_EQ(kill(process, SIGKILL), 0);
    ASSERT_EQ(waitpid(process, nullptr, 0), process);
  }
  const ProgramRun last = Batch(Plan(), "killed");
  ASSERT_EQ(last.exit_code, 0) << last.output << Reasons("killed");
  ExpectSameResults("straight", "killed");
}

TEST_F(BatchVerb, InterruptedItSaysHowToGoOn) {
  const pid_t process = Start("stopped");
  WaitUntilDone("stopped", 1);
  ASSERT_EQ(kill(process, SIGINT), 0);
  int status = 0;
  ASSERT_EQ(waitpid(process, &status, 0), process);
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(ReadFile(Path("said.txt")).value(), HasSubstr("the same command goes on"));
  EXPECT_LT(NumDone("stopped"), 8U);
  EXPECT_EQ(Batch(Plan(), "stopped").exit_code, 0);
}

TEST_F(BatchVerb, AFailedRunIsToldAndCounts) {
  // Stands for another commit that crashes, and for one that hangs.
  const std::pair<const char*, const char*> programs[] = {{"crash", "kill -SEGV $$"},
                                                          {"hang", "sleep 100"}};
  json plan = Plan();
  plan["recipes"] = {{{"name", "as it is"}}};
  plan["seeds"] = {0};
  for (const auto& [name, does] : programs) {
    std::ofstream(Path(name)) << "#!/bin/sh\necho about to " << name << "\n" << does << "\n";
    std::filesystem::permissions(Path(name), std::filesystem::perms::owner_all);
    plan["recipes"].push_back({{"name", name}, {"program", name}});
  }
  plan["timeout_s"] = 20;
  const ProgramRun run = Batch(plan, "failing");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("4 of 6 runs failed"));
  const BatchTable table = ReadBatchResults(Path("failing")).value();
  for (const BatchRun& one : table.runs) {
    const bool ok = one.recipe == "as it is";
    EXPECT_EQ(one.status, ok ? "ok" : "failed");
    EXPECT_EQ(one.figures[0], ok ? 0.0 : 100.0);
    if (!ok) {
      EXPECT_EQ(one.figures[1], 0.0) << "it has found nothing";
    }
    if (one.recipe == "crash") {
      EXPECT_THAT(one.reason, HasSubstr("signal 11"));
    }
    if (one.recipe == "hang") {
      EXPECT_THAT(one.reason, HasSubstr("too long"));
    }
  }
  EXPECT_THAT(ReadFile(Path("failing") / "report.html").value(), HasSubstr("about to crash"));
}

TEST_F(BatchVerb, TheGateCatchesWhatGotWorse) {
  json plan = Plan();
  plan["recipes"] = {{{"name", "mine"}}};
  plan["seeds"] = {0, 1, 2, 3};
  plan["gate"] = {"found"};
  ASSERT_EQ(Batch(plan, "before").exit_code, 0);
  EXPECT_THAT(Batch(plan, "before", "--against before/results.sqlite").output,
              HasSubstr("names this batch itself"));
  const ProgramRun same = Batch(plan, "same", "--jobs 2 --against before");
  EXPECT_EQ(same.exit_code, 0) << same.output;
  plan["recipes"][0]["frames"] = "0:3";  // too few to confirm anything
  const ProgramRun worse = Batch(plan, "worse", "--jobs 2 --against before/results.sqlite");
  EXPECT_EQ(worse.exit_code, 1);
  EXPECT_THAT(worse.output, HasSubstr("WORSE"));
  EXPECT_THAT(worse.output, HasSubstr("1 figures got significantly worse"));
}

TEST_F(BatchVerb, SpeaksToAnyBatchSystem) {
  ASSERT_EQ(Batch(Plan(), "here").exit_code, 0);
  const json system = {
      {"submit",
       "setsid sh -c 'touch at_work; for i in $(seq {tasks}); do sh {script} $i; done >{log} 2>&1; "
       "rm at_work' >/dev/null 2>&1 & echo {name}-1"},
      {"left", "ls at_work 2>/dev/null || true"},
      {"cancel", "true"},
      {"script", {"exec {command} \"$1\""}},
      {"most_tasks", 3}};
  ASSERT_TRUE(WriteJson(Path("system.json"), system).ok());
  const ProgramRun run = Batch(Plan(), "there", "--engine system.json");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  ExpectSameResults("here", "there");
  EXPECT_EQ(ReadJson(Path("there") / "cluster/tasks.json")->size(), 3U);
}

TEST_F(BatchVerb, SaysWhatIsWrong) {
  json plan = Plan();
  plan["sequences"] = {"a", "nowhere"};
  EXPECT_THAT(Batch(plan, "x").output, HasSubstr("nowhere"));
  EXPECT_EQ(Batch(plan, "x").exit_code, 1);
  plan["sequences"] = {{{"name", "s"}, {"synth", {{"scene", "no such"}}}}};
  EXPECT_THAT(Batch(plan, "x").output, HasSubstr("could not be made"));
  EXPECT_THAT(Batch(Plan(), "x", "--engine no_such_file").output, HasSubstr("no_such_file"));
  EXPECT_THAT(Batch(Plan(), "x", "--against nowhere").output, HasSubstr("nowhere"));
  EXPECT_EQ(Batch(Plan(), "x", "--jobs 0").exit_code, 2);
  const ProgramRun none = RunProgram("batch --out no_batch 2>&1", Path("."));
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, HasSubstr("is no folder of a batch"));
  EXPECT_THAT(RunProgram("batch plan.json --out x --task 1 2>&1", Path(".")).output,
              HasSubstr("tasks.json"));
}

}  // namespace
}  // namespace plumbline
