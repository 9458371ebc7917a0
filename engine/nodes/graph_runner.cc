// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/graph_runner.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/files.h"
#include "engine/batch/child_process.h"

namespace plumbline {
namespace {

using RunnerClock = std::chrono::steady_clock;

/// One that ends with an error of its own so often within this time will not do better.
constexpr int kMostFailures = 3;
constexpr auto kFailsSoon = std::chrono::seconds(10);
/// A recording that was stopped is mapped to its end within this, or as far as it has come.
constexpr auto kMapsTheRest = std::chrono::seconds(20);
constexpr auto kPauseAfterFailure = std::chrono::milliseconds(300);

/// Whoever asks is ended before those whom it asks.
int EndsBy(NodeKind kind) {
  switch (kind) {
    case NodeKind::kMapper:
      return 0;
    case NodeKind::kRecorder:
      return 1;
    case NodeKind::kPlayer:
      return 3;
    default:
      return 2;
  }
}

std::string LastLineOf(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return "";
  std::string line = *text;
  while (!line.empty() && line.back() == '\n') line.pop_back();
  const std::size_t begin = line.rfind('\n');
  if (begin != std::string::npos) line.erase(0, begin + 1);
  constexpr std::size_t kMost = 400;
  if (line.size() > kMost) line.resize(kMost);
  return line;
}

void ReplaceAll(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
}

class GraphRunner {
 public:
  GraphRunner(const GraphPlan& plan, GraphRunOptions options)
      : plan_(plan), options_(std::move(options)), records_(options_.recording != nullptr) {}

  Result<GraphRunEnd> Run(const std::stop_token& stop) {
    for (const GraphNode& node : plan_.nodes) {
      if (!node.start) continue;
      auto& watched = watched_.emplace_back(std::make_unique<Watched>());
      watched->node = &node;
      watched->thread = std::jthread([this, one = watched.get()] { Watch(*one); });
    }
    const auto over = [this] { return recorded_ || !failure_.ok(); };
    if (options_.recording != nullptr) Record(stop);
    {
      std::unique_lock lock(mutex_);
      if (records_ && stop.stop_requested())
        changed_.wait_for(lock, kMapsTheRest, over);
      else
        changed_.wait(lock, stop, over);
    }
    for (int turn = 0; turn <= 3; ++turn) {
      for (const auto& one : watched_)
        if (EndsBy(one->node->kind) == turn) one->stop.request_stop();
      for (const auto& one : watched_)
        if (EndsBy(one->node->kind) == turn && one->thread.joinable()) one->thread.join();
    }
    const std::lock_guard lock(mutex_);
    if (!failure_.ok()) return failure_.error();
    if (!recorded_) return Error{ErrorCode::kCancelled, "stopped"};
    return end_;
  }

 private:
  static bool IsSensor(NodeKind kind) {
    return kind == NodeKind::kCamera || kind == NodeKind::kImu;
  }

  /// Until there is nothing more to record.
  void Record(const std::stop_token& stop) {
    {
      std::unique_lock lock(mutex_);
      const auto over = [this] { return sensor_ended_ || recorded_ || !failure_.ok(); };
      if (plan_.recording.seconds > 0) {
        const auto until = std::chrono::steady_clock::time_point(
            std::chrono::nanoseconds(plan_.recording.began_ns) +
            std::chrono::duration_cast<std::chrono::nanoseconds>(
                std::chrono::duration<double>(plan_.recording.seconds)));
        changed_.wait_until(lock, stop, until, over);
      } else {
        changed_.wait(lock, stop, over);
      }
    }
    for (const auto& one : watched_)
      if (IsSensor(one->node->kind)) one->stop.request_stop();
    for (const auto& one : watched_)
      if (IsSensor(one->node->kind)) one->thread.join();
    options_.recording.reset();
    const std::lock_guard lock(mutex_);
    if (failure_.ok() && !recorded_)
      options_.tell("the recording has ended; mapping what has come");
  }

  struct Watched {
    const GraphNode* node = nullptr;
    std::stop_source stop;
    std::jthread thread;
  };

  std::vector<std::string> WordsFor(const GraphNode& node) const {
    if (node.command.empty())
      return {options_.program.string(),
              "node",
              std::string(NameOf(node.kind)),
              "--graph",
              options_.graph_file.string(),
              "--name",
              node.name};
    std::vector<std::string> words = node.command;
    const GraphNode* images = plan_.Find(node.images);
    for (std::string& word : words) {
      ReplaceAll(word, "{endpoint}", node.endpoint);
      ReplaceAll(word, "{name}", node.name);
      if (images != nullptr) ReplaceAll(word, "{images}", images->endpoint);
    }
    return words;
  }

  void Watch(Watched& watched) {
    const GraphNode& node = *watched.node;
    const std::stop_token stop = watched.stop.get_token();
    const std::filesystem::path log = plan_.folder / (node.name + ".log");
    int failures = 0;
    while (!stop.stop_requested()) {
      const auto started = RunnerClock::now();
      const Result<ChildEnd> end =
          RunChild(WordsFor(node), {std::filesystem::current_path(), log, {}}, stop);
      if (stop.stop_requested()) return;
      if (!end.ok()) return Fail(end.error());
      if (end->ok() && node.kind == NodeKind::kRecorder) return Recorded();
      if (end->ok() && IsSensor(node.kind)) return SensorEnded(node.kind);
      if (RunnerClock::now() - started > kFailsSoon) failures = 0;
      const std::string how = "the node '" + node.name + "' " + InWords(*end);
      if (end->signal == 0 && ++failures >= kMostFailures) {
        const std::string why = LastLineOf(log);
        return Fail({ErrorCode::kInvalidInput, how + " " + std::to_string(failures) + " times" +
                                                   (why.empty() ? "" : "; it last said: " + why) +
                                                   " (" + log.string() + ")"});
      }
      options_.tell(how + "; starting it again");
      {
        const std::lock_guard lock(mutex_);
        ++end_.restarts[node.name];
      }
      if (end->signal == 0) Pause(stop);
    }
  }

  void Pause(const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    never.wait_for(lock, stop, kPauseAfterFailure, [] { return false; });
  }

  /// Without a camera a recording is over; an IMU that is gone may be that it was played.
  void SensorEnded(NodeKind kind) {
    const std::lock_guard lock(mutex_);
    sensor_ended_ = sensor_ended_ || kind == NodeKind::kCamera;
    changed_.notify_all();
  }
  void Recorded() {
    const std::lock_guard lock(mutex_);
    recorded_ = true;
    changed_.notify_all();
  }
  void Fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (failure_.ok()) failure_ = error;
    changed_.notify_all();
  }

  const GraphPlan& plan_;
  GraphRunOptions options_;
  const bool records_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool recorded_ = false, sensor_ended_ = false;
  Status failure_;
  GraphRunEnd end_;
  std::vector<std::unique_ptr<Watched>> watched_;
};

}  // namespace

Result<GraphRunEnd> RunGraph(const GraphPlan& plan, GraphRunOptions options,
                             const WorkContext& work) {
  return GraphRunner(plan, std::move(options)).Run(work.stop);
}

}  // namespace plumbline
