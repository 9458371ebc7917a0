// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <thread>

#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/batch/batch_figures.h"
#include "engine/batch/batch_jobs.h"
#include "engine/batch/child_process.h"
#include "engine/dataset/sequence.h"

namespace plumbline {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

std::string HostName() {
  char host[256] = {};
  ::gethostname(host, sizeof(host) - 1);
  return host;
}

std::string TimeNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[40] = {};
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", ::gmtime_r(&now, &utc));
  return text;
}

/// Whole numbers without a point: some options take no other.
std::string NumberWord(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15)
    return std::to_string(static_cast<std::int64_t>(value));
  return json(value).dump();
}

const PlannedSequence& SequenceOf(const Batch& batch, const BatchJob& job) {
  return batch.plan.sequences[static_cast<std::size_t>(job.sequence)];
}

const PlannedRecipe& RecipeOf(const Batch& batch, const BatchJob& job) {
  return batch.plan.recipes[static_cast<std::size_t>(job.recipe)];
}

/// The word behind `option`; "" where it is not there.
std::string ValueOfOption(const Words& words, const char* option) {
  const auto found = std::find(words.begin(), words.end(), option);
  return found == words.end() || found + 1 == words.end() ? "" : *(found + 1);
}

Words MapWords(const Batch& batch, const BatchJob& job) {
  const PlannedRecipe& recipe = RecipeOf(batch, job);
  const PlannedSequence& sequence = SequenceOf(batch, job);
  Words words = {batch.ProgramOf(job).string(),
                 "run",
                 batch.SequenceFolder(sequence).string(),
                 "--out",
                 "run.plb",
                 "--resume",
                 "--seed",
                 std::to_string(job.seed),
                 "--json",
                 "run.json"};
  if (!sequence.models.empty() && ValueOfOption(recipe.words, "--models").empty())
    words.insert(words.end(), {"--models", sequence.models.string()});
  words.insert(words.end(), recipe.words.begin(), recipe.words.end());
  for (std::size_t i = 0; i < job.point.size(); ++i)
    words.insert(words.end(),
                 {"--set", batch.plan.sweep[i].option + "=" + NumberWord(job.point[i])});
  return words;
}

/// Truth and models of a sequence, as the plan or the sequence itself names them.
struct SequenceTruth {
  std::filesystem::path ground_truth, models;
};

Result<SequenceTruth> TruthOf(const Batch& batch, const BatchJob& job) {
  const PlannedSequence& planned = SequenceOf(batch, job);
  const std::filesystem::path folder = batch.SequenceFolder(planned);
  SequenceTruth truth{planned.ground_truth, planned.models};
  if (const std::string models = ValueOfOption(RecipeOf(batch, job).words, "--models");
      !models.empty())
    truth.models = models;
  if (!truth.ground_truth.empty() && !truth.models.empty()) return truth;
  const auto sequence = OpenSequence(folder);
  if (!sequence.ok()) return sequence.error();
  if (truth.ground_truth.empty())
    truth.ground_truth = (*sequence)->ground_truth_file().value_or(std::filesystem::path());
  if (truth.models.empty())
    truth.models = (*sequence)->models_folder().value_or(std::filesystem::path());
  const char* missing = truth.ground_truth.empty() ? "ground_truth"
                        : truth.models.empty()     ? "models"
                                                   : nullptr;
  if (missing == nullptr) return truth;
  return InvalidInput("the sequence '" + folder.string() + "' has no " + missing +
                      " of its own; name '" + missing + "' in the plan");
}

Words EvaluateWords(const Batch& batch, const BatchJob& job, const SequenceTruth& truth) {
  const PlannedEvaluation& evaluation = batch.plan.evaluation;
  Words words = {batch.program.string(),
                 "evaluate",
                 "run.plb",
                 "--ground-truth",
                 truth.ground_truth.string(),
                 "--models",
                 truth.models.string(),
                 "--samples",
                 std::to_string(evaluation.samples),
                 "--single-frames",
                 std::to_string(evaluation.single_frames),
                 "--json",
                 "evaluation.json"};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {option, value});
  };
  add("--scene", SequenceOf(batch, job).scene.string());
  add("--align", evaluation.align);
  for (const std::string& category : evaluation.ignored_categories)
    add("--ignore-category", category);
  return words;
}

/// The last line of a log that says something.
std::string LastLine(const std::filesystem::path& log) {
  const Result<std::string> text = ReadFile(log);
  if (!text.ok()) return "";
  const std::size_t end = text->find_last_not_of(" \r\n");
  if (end == std::string::npos) return "";
  const std::size_t start = text->find_last_of("\r\n", end) + 1;  // npos + 1 is 0
  return text->substr(start, end - start + 1);
}

/// A run in its folder.
class JobRun {
 public:
  JobRun(const Batch& batch, const BatchJob& job)
      : batch_(batch), job_(job), folder_(batch.folder / job.folder) {
    result_ = {{"status", "failed"},
               {"host", HostName()},
               {"started", TimeNow()},
               {"program_hash", batch.HashOf(batch.ProgramOf(job))}};
  }

  Status Do(const std::stop_token& stop) {
    Status status = Attempt(stop);
    if (!status.ok() && status.error().code == ErrorCode::kCancelled) return status;
    if (!status.ok()) {
      result_["reason"] = status.error().message;
      Put(FiguresOfFailure());
    }
    return WriteJson(folder_ / "result.json", result_);
  }

 private:
  Status Attempt(const std::stop_token& stop) {
    const Result<SequenceTruth> truth = TruthOf(batch_, job_);
    if (!truth.ok()) return truth.error();
    if (Status status = Step("run", MapWords(batch_, job_), stop); !status.ok()) return status;
    if (const auto run = ReadJson(folder_ / "run.json"); run.ok() && run->is_object()) {
      result_["frames"] = run->value("frames", 0);
      const json header = run->value("run", json::object());
      result_["program_version"] = header.value("program_version", "");
    }
    if (Status status = Step("evaluate", EvaluateWords(batch_, job_, *truth), stop); !status.ok())
      return status;
    const auto evaluation = ReadJson(folder_ / "evaluation.json");
    if (!evaluation.ok()) return evaluation.error();
    Put(FiguresOf(*evaluation));
    result_["missed"] = json::array();
    for (const BatchMiss& miss : MissesOf(*evaluation)) {
      result_["missed"].push_back({{"truth", miss.truth},
                                   {"model", miss.model},
                                   {"cause", miss.cause},
                                   {"text", miss.text}});
    }
    result_["status"] = "ok";
    return {};
  }

  /// One program; it and its time are kept.
  Status Step(const std::string& name, const Words& words, const std::stop_token& stop) {
    const std::filesystem::path log = folder_ / "log.txt";
    AppendToLog(log, "$ " + ShellWords(words) + "\n");
    const Stopwatch watch;
    const Result<ChildEnd> end = RunChild(words, {folder_, log, batch_.plan.timeout_s}, stop);
    result_[name + "_s"] = watch.Milliseconds() / 1000;
    if (!end.ok()) return end.error();
    if (end->ok()) return {};
    const std::string said = end->signal == 0 && !end->timed_out ? ": " + LastLine(log) : "";
    return Error{ErrorCode::kInvalidInput, name + " " + InWords(*end) + said};
  }

  static void AppendToLog(const std::filesystem::path& log, const std::string& text) {
    if (std::FILE* file = std::fopen(log.c_str(), "a")) {
      std::fputs(text.c_str(), file);
      std::fclose(file);
    }
  }

  void Put(const std::vector<std::optional<double>>& figures) {
    json& put = result_["figures"] = json::object();
    for (std::size_t i = 0; i < figures.size(); ++i)
      put[BatchFigures()[i].name] = figures[i] ? json(*figures[i]) : json();
  }

  const Batch& batch_;
  const BatchJob& job_;
  std::filesystem::path folder_;
  json result_;
};

/// Programs of a batch that was killed take a moment to end, and hold their run file until then.
void WaitForTheDying(const std::filesystem::path& run, const std::stop_token& stop) {
  constexpr double kLongestMs = 20'000;
  const Stopwatch watch;
  while (FileLock::IsHeld(run) && watch.Milliseconds() < kLongestMs && !stop.stop_requested())
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

}  // namespace

Status RunJob(const Batch& batch, const BatchJob& job, const std::stop_token& stop) {
  const std::filesystem::path folder = batch.folder / job.folder;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  const auto lock = FileLock::Acquire(folder / "run");
  if (!lock.ok()) return lock.error();
  if (ReadJobResult(batch, job)) return {};
  WaitForTheDying(folder / "run.plb", stop);
  return JobRun(batch, job).Do(stop);
}

Status CheckJobInputs(const Batch& batch, const BatchJob& job) {
  const Result<SequenceTruth> truth = TruthOf(batch, job);
  return truth.ok() ? Status() : Status(truth.error());
}

Status MakeSequence(const Batch& batch, const PlannedSequence& sequence,
                    const std::stop_token& stop) {
  if (sequence.synth.empty()) return {};
  const std::filesystem::path folder = batch.SequenceFolder(sequence);
  const std::filesystem::path made = folder.string() + ".made.json",
                              log = folder.string() + ".log.txt";
  const auto before = ReadJson(made);
  if (before.ok() && *before == json(sequence.synth)) return {};
  std::error_code error;
  std::filesystem::create_directories(folder.parent_path(), error);
  std::filesystem::remove(log, error);
  Words words = {batch.program.string(), "synth", "--out", folder.string()};
  words.insert(words.end(), sequence.synth.begin(), sequence.synth.end());
  const Result<ChildEnd> end = RunChild(words, {folder.parent_path(), log, std::nullopt}, stop);
  if (!end.ok()) return end.error();
  if (end->ok()) return WriteJson(made, sequence.synth);
  return InvalidInput("the sequence '" + sequence.name + "' could not be made; synth " +
                      InWords(*end) + ": " + LastLine(log));
}

}  // namespace plumbline
