// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/base/options.h"
#include "engine/base/timer.h"
#include "engine/batch/batch_engines.h"
#include "engine/batch/child_process.h"

namespace plumbline {
namespace {

using nlohmann::json;

constexpr double kAskEveryS = 3;
constexpr int kMostSilent = 60;  ///< So often the batch system may not answer, in a row.
constexpr int kSurelyOver = 2;   ///< So often, in a row, it has to say that nothing is left.

std::string Trimmed(std::string text) {
  text.erase(text.find_last_not_of(" \t\r\n") + 1);
  text.erase(0, text.find_first_not_of(" \t\r\n"));
  return text;
}

std::string Filled(std::string text, const std::map<std::string, std::string>& values) {
  for (const auto& [name, value] : values) {
    const std::string key = "{" + name + "}";
    for (std::size_t at = text.find(key); at != std::string::npos;
         at = text.find(key, at + value.size()))
      text.replace(at, key.size(), value);
  }
  return text;
}

bool SleepUnlessStopped(double seconds, const std::stop_token& stop) {
  for (const Stopwatch watch; watch.Milliseconds() < 1000 * seconds;) {
    if (stop.stop_requested()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return !stop.stop_requested();
}

/// A batch at a batch system.
class Cluster {
 public:
  Cluster(const Batch& batch, const ClusterCommands& commands, int at_once)
      : batch_(batch), commands_(commands), folder_(batch.folder / "cluster") {
    values_["name"] = "plumbline-" + HashHex(batch.folder.string()).substr(0, 8);
    values_["script"] = ShellWords({(folder_ / "task.sh").string()});
    values_["log"] = ShellWords({(folder_ / "tasks.log").string()});
    values_["command"] =
        ShellWords({batch.program.string(), "batch", "--out", batch.folder.string(), "--task"});
    values_["at_once"] = at_once > 0 ? std::to_string(at_once) : "";
    if (const auto id = ReadFile(folder_ / "id.txt"); id.ok()) values_["id"] = Trimmed(*id);
  }

  /// Whether an earlier call has left tasks there.
  Result<bool> IsAtWork(const std::stop_token& stop) {
    if (!values_.contains("id")) return false;
    const auto left = NumLeft(stop);
    if (!left.ok()) return left.error();
    return *left > 0;
  }

  Status Submit(const PendingJobs& jobs, const std::stop_token& stop) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    const std::size_t tasks = std::min(jobs.size(), static_cast<std::size_t>(commands_.most_tasks));
    json lists = json::array();
    for (std::size_t i = 0; i < jobs.size(); ++i) lists[i % tasks].push_back(jobs[i]->folder);
    std::string script;
    for (const std::string& line : commands_.script) script += Filled(line, values_) + "\n";
    if (Status status = WriteJson(folder_ / "tasks.json", lists); !status.ok()) return status;
    if (Status status = WriteFileAtomically(folder_ / "task.sh", script); !status.ok())
      return status;
    std::filesystem::permissions(folder_ / "task.sh", std::filesystem::perms::owner_exec,
                                 std::filesystem::perm_options::add, error);
    values_["tasks"] = std::to_string(tasks);
    if (values_["at_once"].empty()) values_["at_once"] = std::to_string(tasks);
    const Result<std::string> id = Ask(commands_.submit, stop);
    if (!id.ok()) return id.error();
    values_["id"] = *id;
    return WriteFileAtomically(folder_ / "id.txt", *id + "\n");
  }

  /// Waits until every run has a result or nothing is left there.
  Status Wait(const PendingJobs& jobs, const WorkContext& work) {
    int silent = 0, over = 0;
    for (;;) {
      const int done = NumDone(jobs);
      work.report({"running on the cluster", done, static_cast<int>(jobs.size())});
      if (done == static_cast<int>(jobs.size()) || over == kSurelyOver) return {};
      if (!SleepUnlessStopped(over > 0 ? 1 : kAskEveryS, work.stop)) return Cancel();
      const Result<int> left = NumLeft(work.stop);
      if (!left.ok() && work.stop.stop_requested()) return Cancel();
      if (!left.ok() && silent++ == 0)
        log::warn("the batch system does not answer and is asked again: {}", left.error().message);
      if (silent > kMostSilent) return left.ok() ? Status() : Status(left.error());
      if (left.ok()) silent = 0;
      over = left.ok() && *left == 0 ? over + 1 : 0;
    }
  }

 private:
  int NumDone(const PendingJobs& jobs) const {
    std::error_code error;
    return static_cast<int>(std::count_if(jobs.begin(), jobs.end(), [&](const BatchJob* job) {
      return std::filesystem::exists(batch_.ResultFile(*job), error);
    }));
  }

  Result<int> NumLeft(const std::stop_token& stop) {
    const Result<std::string> lines = Ask(commands_.left, stop);
    if (!lines.ok()) return lines.error();
    if (lines->empty()) return 0;
    return 1 + static_cast<int>(std::count(lines->begin(), lines->end(), '\n'));
  }

  Status Cancel() {
    if (const auto said = Ask(commands_.cancel, {}); !said.ok()) return said.error();
    return Error{ErrorCode::kCancelled, "stopped"};
  }

  /// What a command of the batch system says.
  Result<std::string> Ask(const std::string& command, const std::stop_token& stop) {
    const std::string line = Filled(command, values_);
    const std::filesystem::path output = folder_ / "said.txt";
    std::error_code error;
    std::filesystem::remove(output, error);
    const auto end = RunChild({"/bin/sh", "-c", line}, {folder_, output, 120.0}, stop);
    if (!end.ok()) return end.error();
    const auto said = ReadFile(output);
    if (!said.ok()) return said.error();
    if (end->ok()) return Trimmed(*said);
    return Error{ErrorCode::kIo, fmt::format("'{}' {}: {}", line, InWords(*end), Trimmed(*said))};
  }

  const Batch& batch_;
  const ClusterCommands& commands_;
  std::filesystem::path folder_;
  std::map<std::string, std::string> values_;
};

}  // namespace

ClusterCommands SlurmCommands(const std::vector<std::string>& options) {
  ClusterCommands commands;
  commands.submit =
      "sbatch --parsable --job-name={name} --array=1-{tasks}%{at_once} --output={log} "
      "--open-mode=append " +
      ShellWords(options) + " {script}";
  commands.left = "squeue --noheader --name={name} --format=%i";
  commands.cancel = "scancel --name={name}";
  commands.script = {"#!/bin/sh", "exec {command} \"$SLURM_ARRAY_TASK_ID\""};
  return commands;
}

Result<ClusterCommands> ReadClusterCommands(const std::filesystem::path& file) {
  const Result<json> given = ReadJson(file);
  if (!given.ok()) return given.error();
  const auto wrong = [&](const std::string& what) {
    return InvalidInput("'" + file.string() + "': " + what);
  };
  if (!given->is_object()) return wrong("a batch system is described by a JSON object");
  ClusterCommands commands;
  const std::map<std::string, std::string*> texts = {
      {"submit", &commands.submit}, {"left", &commands.left}, {"cancel", &commands.cancel}};
  const std::vector<std::string> known = {"submit", "left", "cancel", "script", "most_tasks"};
  for (const auto& [key, value] : given->items()) {
    if (const auto text = texts.find(key); text != texts.end()) {
      if (!value.is_string()) return wrong("'" + key + "' must be a text");
      *text->second = value.get<std::string>();
    } else if (key == "script") {
      if (!value.is_array()) return wrong("'script' must be a list of lines");
      for (const json& line : value) {
        if (!line.is_string()) return wrong("'script' must be a list of lines");
        commands.script.push_back(line.get<std::string>());
      }
    } else if (key == "most_tasks") {
      if (!value.is_number_integer() || value < 1 || value > 1'000'000)
        return wrong("'most_tasks' must be a whole number from 1");
      commands.most_tasks = value.get<int>();
    } else {
      return wrong("unknown key '" + key + "'; did you mean '" + NearestName(key, known) + "'?");
    }
  }
  for (const auto& [key, text] : texts) {
    if (text->empty()) return wrong("'" + key + "' is missing: the command for it");
  }
  const bool calls = std::any_of(commands.script.begin(), commands.script.end(), [](const auto& l) {
    return l.find("{command}") != std::string::npos;
  });
  if (!calls) return wrong("no line of 'script' has {command}, which does the work");
  return commands;
}

Status RunOnCluster(const Batch& batch, const ClusterCommands& commands, int at_once,
                    const WorkContext& work) {
  std::error_code error;
  std::filesystem::create_directories(batch.folder / "cluster", error);
  Cluster cluster(batch, commands, at_once);
  const Result<bool> at_work = cluster.IsAtWork(work.stop);
  if (!at_work.ok()) return at_work.error();
  if (*at_work) {
    log::info("an array of an earlier call is still at work; waiting for it");
    if (Status status = cluster.Wait(PendingJobsOf(batch), work); !status.ok()) return status;
  }
  const PendingJobs jobs = PendingJobsOf(batch);
  if (jobs.empty()) return {};
  if (Status status = cluster.Submit(jobs, work.stop); !status.ok()) return status;
  return cluster.Wait(jobs, work);
}

Status RunTask(const Batch& batch, int task, const WorkContext& work) {
  const std::filesystem::path file = batch.folder / "cluster" / "tasks.json";
  const Result<json> lists = ReadJson(file);
  if (!lists.ok()) return lists.error();
  if (!lists->is_array() || task < 1 || task > static_cast<int>(lists->size()))
    return InvalidInput(fmt::format("'{}' has no task {}", file.string(), task));
  Status first_error;
  for (const json& folder : (*lists)[static_cast<std::size_t>(task - 1)]) {
    const auto job = std::find_if(batch.jobs.begin(), batch.jobs.end(),
                                  [&](const BatchJob& one) { return folder == one.folder; });
    if (job == batch.jobs.end())
      return InvalidInput("task " + std::to_string(task) + " is of another plan or program than '" +
                          batch.folder.string() + "' has now; submit it again");
    const Status status = RunJob(batch, *job, work.stop);
    if (!status.ok() && status.error().code == ErrorCode::kCancelled) return status;
    if (!status.ok() && first_error.ok()) first_error = status;
  }
  return first_error;
}

}  // namespace plumbline
