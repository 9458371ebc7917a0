// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <limits>
#include <list>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/base/timer.h"
#include "engine/models/model_database.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_detectors.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/nodes/report_message.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/pipeline/pipeline_parts.h"
#include "engine/recording/run_header.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/transport/message_checks.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {
namespace {

/// The mapper waits when so many reports were not asked for.
constexpr std::size_t kReportsAhead = 16;
constexpr int kBeforeAll = std::numeric_limits<int>::min();

/// Reports until the recorder has kept them, and who waits for one. For two threads: the mapper
/// puts reports on it, the server takes requests.
class ReportShelf {
 public:
  explicit ReportShelf(NodeServer& server) : server_(server) {}

  void SetHeader(std::string json) {
    const std::lock_guard lock(mutex_);
    header_ = std::move(json);
    AnswerAll();
  }
  /// The frame after which the mapper goes on.
  void Begin(int after) {
    const std::lock_guard lock(mutex_);
    asked_after_ = forgotten_ = after;
  }

  /// Waits for room. False once `stop` is requested.
  bool Put(const FrameReport& report, int done, int selected, const std::stop_token& stop) {
    wire::Report message = ReportToWire(report, true);
    message.set_done(done);
    message.set_selected(selected);
    std::unique_lock lock(mutex_);
    if (!room_.wait(lock, stop, [&] { return NumAhead() < kReportsAhead; })) return false;
    mapped_.push_back(report.frame);
    newest_ = message;
    for (wire::ReportObject& object : *newest_.mutable_objects()) object.clear_particles();
    reports_.push_back(std::move(message));
    AnswerAll();
    return true;
  }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    AnswerAll();
  }

  void Take(AskedRequest asked) {
    const std::lock_guard lock(mutex_);
    if (asked.request.has_report()) {
      const wire::ReportRequest& wanted = asked.request.report();
      asked_after_ = wanted.after();
      while (!reports_.empty() && reports_.front().frame() <= wanted.kept()) {
        forgotten_ = reports_.front().frame();
        reports_.pop_front();
      }
      room_.notify_all();
    }
    waiting_.push_back(std::move(asked));
    AnswerAll();
  }

 private:
  std::size_t NumAhead() const {
    return static_cast<std::size_t>(
        std::count_if(reports_.begin(), reports_.end(),
                      [&](const wire::Report& report) { return report.frame() > asked_after_; }));
  }

  void AnswerAll() {
    std::erase_if(waiting_, [&](const AskedRequest& asked) {
      wire::Reply reply;
      if (!Fill(asked.request, reply)) return false;
      server_.Answer(asked, std::move(reply));
      return true;
    });
  }

  /// False where there is nothing to answer yet.
  bool Fill(const wire::Request& request, wire::Reply& reply) const {
    if (request.has_header()) {
      if (!header_.empty()) reply.mutable_header()->set_json(header_);
      return !header_.empty();
    }
    const int after = request.has_report() ? request.report().after() : request.map().after();
    if (request.has_map()) {
      const auto unseen = std::upper_bound(mapped_.begin(), mapped_.end(), after);
      if (unseen == mapped_.end()) return false;
      reply.mutable_map()->set_dropped(static_cast<int>(mapped_.end() - unseen) - 1);
      *reply.mutable_map()->mutable_report() = newest_;
      return true;
    }
    if (after < forgotten_) {
      reply = RefusalOf({ErrorCode::kNotFound, "the report after frame " + std::to_string(after) +
                                                   " is not here any more; the run file has it"});
      return true;
    }
    const auto next =
        std::find_if(reports_.begin(), reports_.end(),
                     [&](const wire::Report& report) { return report.frame() > after; });
    if (next != reports_.end()) {
      *reply.mutable_report() = *next;
      return true;
    }
    if (!ended_) return false;
    reply.mutable_report()->set_end(true);
    return true;
  }

  NodeServer& server_;
  std::mutex mutex_;
  std::condition_variable_any room_;
  std::string header_;
  std::deque<wire::Report> reports_;
  wire::Report newest_;      ///< Without particles, for who looks on ...
  std::vector<int> mapped_;  ///< ... and all frames since this mapper began, to count drops.
  std::list<AskedRequest> waiting_;
  int asked_after_ = kBeforeAll;  ///< By the recorder, the last time.
  int forgotten_ = kBeforeAll;    ///< Up to this frame reports are not here any more.
  bool ended_ = false;
};

/// What a node says that it finds things with. Another program's has a name at least.
template <typename Source>
Result<InputChoice<Source>> ChoiceOf(NodeClient& node, const GraphNode& described, Source with_file,
                                     const std::stop_token& stop) {
  while (true) {
    wire::Request request;
    request.mutable_about();
    const Result<SharedReply> reply = node.AskAndWait(std::move(request), stop);
    if (!reply.ok() && reply.error().code == ErrorCode::kCancelled) return reply.error();
    if (described.kind == NodeKind::kOther) {
      const std::string program =
          reply.ok() && !(*reply)->about().program().empty() ? (*reply)->about().program() : "";
      return InputChoice<Source>{with_file, "process:" + described.name, HashHex(program)};
    }
    if (!reply.ok()) return reply.error();
    const nlohmann::json json = ParseJson((*reply)->about().choice());
    if (json.is_object() && json.contains("source") && json["source"].is_string()) {
      InputChoice<Source> choice;
      const auto& names = EnumNames<Source>::names;
      for (std::size_t i = 0; i < std::size(names); ++i)
        if (names[i] == json["source"].template get<std::string>())
          choice.source = static_cast<Source>(i);
      choice.file = json.value("file", "");
      choice.hash = json.value("hash", "");
      return choice;
    }
    // It is not ready yet.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  }
}

class MapperProcess {
 public:
  MapperProcess(const NodeSetup& setup, NodeLink& link)
      : setup_(setup), link_(link), stop_(setup.work.stop), shelf_(link.server()) {}

  Status Run() {
    const std::jthread serving([this](const std::stop_token& end) { Serve(end); });
    try {
      return Map();
    } catch (const StoppedWaiting&) {
      return {};
    }
  }

 private:
  void Serve(const std::stop_token& end) {
    while (auto asked = link_.server().Next(end)) {
      const wire::Request& request = asked->request;
      if (request.has_header() || request.has_report() || request.has_map()) {
        shelf_.Take(std::move(*asked));
      } else {
        link_.server().Answer(*asked, RefusalOf(DoesNotAnswer(request, setup_.node)));
      }
    }
  }

  Result<PipelineParts> Parts() {
    PipelineParts parts;
    const GraphNode& node = setup_.node;
    FramesAhead ahead = FramesOf(*setup_.plan.recipe);
    link_.SetState("waiting for '" + node.images + "'");
    const Result<NodeClient*> player = link_.Ask(node.images);
    if (!player.ok()) return player.error();
    auto sequence = RemoteSequence::Open(**player, ahead, stop_);
    if (!sequence.ok()) return sequence.error();
    sequence_ = *sequence;
    parts.sequence = *sequence;
    if (GrowingRecordingOf(*sequence_) == nullptr)
      ahead.end = std::min(ahead.end, sequence_->num_frames());
    if (!node.poses.empty()) {
      link_.SetState("waiting for '" + node.poses + "'");
      const Result<NodeClient*> vio = link_.Ask(node.poses);
      if (!vio.ok()) return vio.error();
      if (setup_.plan.recipe->live_speed) {
        parts.own_pose_feed = MakeRemoteOwnPoses(**vio);
      } else {
        auto poses = AskForOwnPoses(**vio, stop_);
        if (!poses.ok()) return poses.error();
        parts.own_poses = std::move(poses).value();
      }
    }
    if (!node.edges.empty()) {
      link_.SetState("waiting for '" + node.edges + "'");
      const Result<NodeClient*> edges = link_.Ask(node.edges);
      if (!edges.ok()) return edges.error();
      auto choice = ChoiceOf(**edges, *setup_.plan.Find(node.edges), EdgeSource::kNetwork, stop_);
      if (!choice.ok()) return choice.error();
      parts.edge_choice = std::move(choice).value();
      parts.edges = MakeRemoteEdgeDetector(**edges, ahead, stop_);
    }
    if (!node.proposals.empty()) {
      link_.SetState("waiting for '" + node.proposals + "'");
      const Result<NodeClient*> detector = link_.Ask(node.proposals);
      if (!detector.ok()) return detector.error();
      auto choice =
          ChoiceOf(**detector, *setup_.plan.Find(node.proposals), DetectorSource::kNetwork, stop_);
      if (!choice.ok()) return choice.error();
      parts.detector_choice = std::move(choice).value();
      parts.detector = MakeRemoteDetector(**detector, ahead, stop_);
    }
    return parts;
  }

  /// Where the recorder stands; the pipeline then goes on from there.
  Status GoOn(MappingPipeline& pipeline) {
    link_.SetState("waiting for '" + setup_.node.recorder + "'");
    const Result<NodeClient*> recorder = link_.Ask(setup_.node.recorder);
    if (!recorder.ok()) return recorder.error();
    wire::Request request;
    request.mutable_resume();
    const Result<SharedReply> reply = (*recorder)->AskAndWait(std::move(request), stop_);
    if (!reply.ok()) return reply.error();
    const wire::Resume& resume = (*reply)->resume();
    if (!resume.has_frames()) return {};
    const auto last =
        ReportFromWire(resume.last(), static_cast<int>(pipeline.database()->models().size()));
    if (!last.ok()) return last.error();
    link_.SetState("going on after frame " + std::to_string(last->frame));
    MapperOptions options = pipeline.recipe().options;
    const nlohmann::json stored = ParseJson(resume.options());
    if (stored.is_object()) options = KnownOptions(stored);
    LandmarkHistory landmarks;
    for (const wire::Landmarks& row : resume.landmarks()) {
      auto edges = LandmarkEdgesFromText(row.edges());
      if (!edges.ok()) return edges.error();
      landmarks[row.frame()] = std::move(edges).value();
    }
    if (Status status = pipeline.Resume(*last, options, landmarks); !status.ok()) return status;
    shelf_.Begin(last->frame);
    return {};
  }

  Status Map() {
    Result<PipelineParts> parts = Parts();
    if (!parts.ok()) return parts.error();
    link_.SetState("opening");
    RunRecipe recipe = *setup_.plan.recipe;
    const Result<std::unique_ptr<MappingPipeline>> pipeline =
        MappingPipeline::OpenWith(std::move(parts).value(), recipe, setup_.work);
    if (!pipeline.ok()) return pipeline.error();
    shelf_.SetHeader(JsonText(HeaderToJson(HeaderOf(**pipeline, setup_.program_version))));
    if (Status status = GoOn(**pipeline); !status.ok()) return status;
    StreamMeter& mapped = link_.AddStream("map");
    int passed_over = 0;
    while (!stop_.stop_requested()) {
      const auto snapshot = (*pipeline)->Next(stop_);
      if (!snapshot) break;
      // What a stop cut short is no report: this frame is mapped again by the next one of us.
      if (stop_.stop_requested()) return {};
      const FrameReport& report = (*snapshot)->report;
      mapped.Count(sequence_->AgeMs(report.frame).value_or(0));
      std::string state = "mapped " + std::to_string((*pipeline)->num_done()) + " of " +
                          std::to_string((*pipeline)->num_selected()) + " frames";
      if (const auto live = (*pipeline)->live()) {
        mapped.Drop(live->passed_over - passed_over);
        passed_over = live->passed_over;
        state = "mapped " + std::to_string(live->done) + " of " + std::to_string(live->came()) +
                " images that came, " + std::to_string(std::lround(live->done_age_ms)) +
                " ms old by then";
      }
      link_.SetState(state);
      if (!shelf_.Put(report, (*pipeline)->num_done(), (*pipeline)->num_selected(), stop_))
        return {};
    }
    if (stop_.stop_requested()) return {};
    if ((*pipeline)->grows())  // what it has become
      shelf_.SetHeader(JsonText(HeaderToJson(HeaderOf(**pipeline, setup_.program_version))));
    shelf_.End();
    link_.SetState("mapped all " + std::to_string((*pipeline)->num_selected()) + " frames");
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait(lock, stop_, [] { return false; });
    return {};
  }

  const NodeSetup& setup_;
  NodeLink& link_;
  const std::stop_token stop_;
  std::shared_ptr<const RemoteSequence> sequence_;
  ReportShelf shelf_;
};

}  // namespace

Status RunMapperNode(const NodeSetup& setup) {
  Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  MapperProcess process(setup, **link);
  const Status status = process.Run();
  if (!status.ok() && status.error().code == ErrorCode::kCancelled) return {};
  return status;
}

}  // namespace plumbline
