// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/run_mirror.h"

#include <chrono>
#include <limits>
#include <utility>

#include "engine/base/json_text.h"
#include "engine/base/log.h"
#include "engine/mapping/map_report.h"
#include "engine/nodes/node_link.h"
#include "engine/nodes/recording_parts.h"
#include "engine/nodes/report_message.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

constexpr auto kAskAgain = std::chrono::milliseconds(100);

Result<std::unique_ptr<NodeClient>> ConnectTo(const GraphPlan& plan, const std::string& node,
                                              const std::shared_ptr<SocketContext>& context) {
  const GraphNode* found = plan.Find(node);
  if (found == nullptr)
    return Error{ErrorCode::kInvalidInput, "the graph has no node '" + node + "'"};
  const Result<Endpoint> endpoint = Endpoint::Parse(found->endpoint);
  if (!endpoint.ok()) return endpoint.error();
  return NodeClient::Connect(context, node, *endpoint);
}

wire::Request FramesFrom(int position) {
  wire::Request request;
  request.mutable_recorded()->set_from(position);
  return request;
}

}  // namespace

RunMirror::RunMirror() = default;

RunMirror::~RunMirror() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

Result<std::unique_ptr<RunMirror>> RunMirror::Start(const GraphPlan& plan, const std::string& name,
                                                    const std::filesystem::path& file,
                                                    const WorkContext& work) {
  const GraphNode* recorder = plan.FirstOf(NodeKind::kRecorder);
  if (recorder == nullptr)
    return Error{ErrorCode::kInvalidInput, "the graph has no recorder, so there is no run to show"};
  const auto context = ContextOf(plan, name);
  if (!context.ok()) return context.error();
  std::unique_ptr<RunMirror> mirror(new RunMirror());
  auto client = ConnectTo(plan, recorder->name, *context);
  if (!client.ok()) return client.error();
  mirror->recorder_ = std::move(client).value();
  work.report({"Waiting for '" + recorder->name + "' to begin the run"});
  // From behind the end: the header alone.
  const Result<SharedReply> reply =
      mirror->recorder_->AskAndWait(FramesFrom(std::numeric_limits<int>::max()), work.stop);
  if (!reply.ok()) return reply.error();
  const Result<RunHeader> header = HeaderFromJson(ParseJson((*reply)->recorded().header()));
  if (!header.ok())
    return Error{header.error().code,
                 "the recorder sent a run whose header is none: " + header.error().message};
  mirror->num_models_ = static_cast<int>(header->models.size());
  mirror->poses_ = std::make_unique<RunPoses>();
  if (!recorder->poses.empty()) {
    auto vio = ConnectTo(plan, recorder->poses, *context);
    if (!vio.ok()) return vio.error();
    mirror->vio_ = std::move(vio).value();
    work.report({"Waiting for the poses of '" + recorder->poses + "'"});
    if (header->recipe.live_speed) {
      *mirror->poses_ = RunPoses::Follow(*mirror->vio_, 0, 0);
    } else {
      auto poses = RunPoses::Ask(*mirror->vio_, work.stop);
      if (!poses.ok()) return poses.error();
      *mirror->poses_ = std::move(poses).value();
    }
  }
  auto writer = RunWriter::Create(file, *header, {}, mirror->poses_->all());
  if (!writer.ok()) return writer.error();
  mirror->writer_ = std::move(writer).value();
  mirror->thread_ =
      std::jthread([raw = mirror.get()](const std::stop_token& stop) { raw->Run(stop); });
  return mirror;
}

void RunMirror::Run(const std::stop_token& stop) {
  Status status = Copy(stop);
  const Status closed = writer_->Close();
  if (status.ok()) status = closed;
  if (!status.ok() && status.error().code != ErrorCode::kCancelled)
    log::error("the run is not followed any further: {}", status.error().message);
}

Status RunMirror::Copy(const std::stop_token& stop) {
  ParticleSharing sharing;
  int position = 0, last_frame = -1;
  while (true) {
    const Result<SharedReply> reply = recorder_->AskAndWait(FramesFrom(position), stop);
    if (!reply.ok()) return reply.error();
    const wire::Recorded& recorded = (*reply)->recorded();
    for (const wire::RecordedFrame& frame : recorded.frames()) {
      Result<FrameReport> report = ReportFromWire(frame.report(), num_models_);
      if (!report.ok()) return report.error();
      if (report->frame <= last_frame)
        return Error{ErrorCode::kCorrupt,
                     "the recorder sent frame " + std::to_string(report->frame) + " again"};
      last_frame = report->frame;
      sharing.Share(frame.report(), *report);
      cv::Mat image;
      if (frame.has_thumbnail()) {
        auto pixels = PixelsFromWire(frame.thumbnail());
        if (!pixels.ok()) return pixels.error();
        image = std::move(pixels).value();
      }
      const auto grown = poses_->GrownUpTo(last_frame, stop);
      if (Status status = writer_->Write(std::move(report).value(), image, grown); !status.ok())
        return status;
      ++position;
    }
    if (recorded.interrupted()) {
      log::info("the graph was stopped; what came until then is kept");
      return {};
    }
    if (recorded.end()) {
      const Result<RunHeader> header = HeaderFromJson(ParseJson(recorded.header()));
      if (!header.ok()) return header.error();
      if (auto poses = poses_->RestUpTo(last_frame, stop)) writer_->SetGrown(*header, poses);
      return {};
    }
    if (recorded.frames().empty()) {
      const auto until = std::chrono::steady_clock::now() + kAskAgain;
      while (!stop.stop_requested() && std::chrono::steady_clock::now() < until)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  }
}

}  // namespace plumbline
