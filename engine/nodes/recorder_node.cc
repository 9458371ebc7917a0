// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <deque>
#include <limits>
#include <mutex>
#include <thread>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/base/timer.h"
#include "engine/mapping/map_report.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/recording_parts.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/nodes/report_message.h"
#include "engine/recording/landmark_history.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

/// A message for a copy of the run is not larger than this and one frame.
constexpr std::size_t kRecordedBytes = std::size_t{2} << 20;
/// How long a recorder waits at its end for copies that have asked lately.
constexpr std::int64_t kLinger_ns = 1'000'000'000;
constexpr double kMostLinger_ms = 10'000;
constexpr double kMostLingerStopped_ms = 3'000;  ///< Whoever stops a graph waits for this.

class RecorderProcess {
 public:
  RecorderProcess(const NodeSetup& setup, NodeLink& link)
      : setup_(setup), link_(link), stop_(setup.work.stop), out_(setup.plan.out) {}

  Status Run() {
    const Result<NodeClient*> mapper = link_.Ask(setup_.node.reports);
    if (!mapper.ok()) return mapper.error();
    const Result<NodeClient*> player = link_.Ask(setup_.node.images);
    if (!player.ok()) return player.error();
    link_.SetState("waiting for '" + setup_.node.reports + "'");
    wire::Request request;
    request.mutable_header();
    const Result<SharedReply> reply = (*mapper)->AskAndWait(std::move(request), stop_);
    if (!reply.ok()) return reply.error();
    NodeClient* vio = nullptr;
    if (!setup_.node.poses.empty()) {
      const Result<NodeClient*> found = link_.Ask(setup_.node.poses);
      if (!found.ok()) return found.error();
      vio = *found;
    }
    const bool live = setup_.plan.recipe->live_speed.has_value();
    if (vio != nullptr && !live) {
      auto poses = RunPoses::Ask(*vio, stop_);
      if (!poses.ok()) return poses.error();
      poses_ = std::move(poses).value();
    }
    auto opened = OpenRun((*reply)->header().json());
    if (!opened.ok()) return opened.error();
    writer_ = std::move(opened->writer);
    if (opened->last) handed_ = kept_ = opened->last->frame;
    num_handed_ = writer_->num_written();
    if (Status status = WriteFileAtomically(Begun(), out_.string() + "\n"); !status.ok())
      return status;
    if (vio != nullptr && live)
      poses_ = RunPoses::Follow(*vio, opened->own_pose_images, opened->own_pose_corrections);
    std::jthread serving([this](const std::stop_token& end) { Serve(end); });
    Status status = Record(**mapper, **player);
    if (status.ok()) status = KeepWhatItBecame(**mapper);
    {
      const std::lock_guard lock(mutex_);
      const Status closed = writer_->Close();
      if (status.ok()) status = closed;
    }
    interrupted_ = !status.ok() && status.error().code == ErrorCode::kCancelled;
    if (status.ok() || interrupted_) LetCopiesEnd();
    return status;
  }

 private:
  /// That this graph has begun the run file: whoever starts this node again must go on with it.
  std::filesystem::path Begun() const { return setup_.plan.folder / kRunBegun; }

  /// Begins the run, or goes on with it.
  Result<RunWriter::Resumed> OpenRun(const std::string& json) {
    Result<RunHeader> header = HeaderFromJson(ParseJson(json));
    if (!header.ok())
      return Error{header.error().code,
                   "the mapper sent a run whose header is none: " + header.error().message};
    num_models_ = static_cast<int>(header->models.size());
    std::error_code ignored;
    const bool go_on = std::filesystem::exists(out_, ignored) &&
                       (setup_.plan.resume || std::filesystem::exists(Begun(), ignored));
    if (go_on) {
      return setup_.plan.recipe->live_speed ? RunWriter::Reopen(out_)
                                            : RunWriter::OpenToResume(out_, *header, poses_.all());
    }
    Result<std::unique_ptr<RunWriter>> created = RunWriter::Create(out_, *header, {}, poses_.all());
    if (!created.ok()) return created.error();
    return RunWriter::Resumed{std::move(created).value(), nullptr};
  }

  /// Of a live run whose poses grew: its last frame, and poses up to it.
  Status KeepWhatItBecame(NodeClient& mapper) {
    if (setup_.node.poses.empty() || !setup_.plan.recipe->live_speed) return {};
    wire::Request request;
    request.mutable_header();
    const Result<SharedReply> reply = mapper.AskAndWait(std::move(request), stop_);
    if (!reply.ok()) return reply.error();
    const Result<RunHeader> header = HeaderFromJson(ParseJson((*reply)->header().json()));
    if (!header.ok()) return header.error();
    auto poses = poses_.RestUpTo(header->end_frame - 1, stop_);
    const std::lock_guard lock(mutex_);
    writer_->SetGrown(*header, std::move(poses));
    return {};
  }

  /// Whoever keeps a copy asks until it is told the end.
  void LetCopiesEnd() {
    ended_ = true;
    const Stopwatch since;
    const auto most_ms = [this] {
      return stop_.stop_requested() ? kMostLingerStopped_ms : kMostLinger_ms;
    };
    while (since.Milliseconds() < most_ms() && SystemClockNs() - copied_ns_ < kLinger_ns)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }

  Status Record(NodeClient& mapper, NodeClient& player) {
    StreamMeter& recorded = link_.AddStream("reports");
    RequestsAhead images(player, FramesOf(*setup_.plan.recipe), ImageRequestOf);
    while (true) {
      wire::Request request;
      request.mutable_report()->set_after(handed_);
      request.mutable_report()->set_kept(Kept());
      const Result<SharedReply> reply = mapper.AskAndWait(std::move(request), stop_);
      if (!reply.ok()) return reply.error();
      const wire::Report& message = (*reply)->report();
      if (message.end()) return {};
      Result<FrameReport> report = ReportFromWire(message, num_models_);
      if (!report.ok()) return report.error();
      if (report->frame <= handed_)
        return Error{ErrorCode::kCorrupt,
                     "the mapper sent frame " + std::to_string(report->frame) + " again"};
      sharing_.Share(message, *report);
      // As in one process, a frame whose image cannot be read has no picture.
      const Result<cv::Mat> image = TakePixels(
          images, report->frame, stop_,
          [](const wire::Reply& answer) { return PixelsFromWire(answer.image().pixels()); });
      if (!image.ok() && image.error().code == ErrorCode::kCancelled) return image.error();
      const auto grown = poses_.GrownUpTo(report->frame, stop_);
      {
        const std::lock_guard lock(mutex_);
        handed_ = report->frame;
        ++num_handed_;
        waiting_.push_back(handed_);
        if (Status status =
                writer_->Write(std::move(*report), image.ok() ? *image : cv::Mat(), grown);
            !status.ok())
          return status;
      }
      recorded.Count(0);
      const std::string state = setup_.plan.recipe->live_speed
                                    ? std::to_string(NumHanded()) + " frames"
                                    : std::to_string(message.done()) + " of " +
                                          std::to_string(message.selected()) + " frames";
      link_.SetState("recorded " + state);
    }
  }

  int NumHanded() {
    const std::lock_guard lock(mutex_);
    return num_handed_;
  }

  /// The last frame that is safely in the file.
  int Kept() {
    const std::lock_guard lock(mutex_);
    const int written = writer_->num_written();
    while (!waiting_.empty() && num_handed_ - static_cast<int>(waiting_.size()) < written) {
      kept_ = waiting_.front();
      waiting_.pop_front();
    }
    return kept_;
  }

  void Serve(const std::stop_token& end) {
    link_.Serve(end, [&](const wire::Request& request) -> Result<wire::Reply> {
      if (request.has_resume()) return Resume(end);
      if (request.has_recorded()) return Recorded(request);
      return DoesNotAnswer(request, setup_.node);
    });
  }

  /// Frames that the file has, for a copy of it.
  Result<wire::Reply> Recorded(const wire::Request& request) {
    const bool ended = ended_;  // before the file is looked at
    copied_ns_ = SystemClockNs();
    if (reader_ == nullptr || ended) {  // the end may have changed the header
      auto reader = RunReader::Open(out_);
      if (!reader.ok()) return reader.error();
      reader_ = std::move(reader).value();
    }
    const Result<int> frames = reader_->NumFrames();
    if (!frames.ok()) return frames.error();
    wire::Reply reply;
    wire::Recorded& recorded = *reply.mutable_recorded();
    recorded.set_header(HeaderToJson(reader_->header()).dump());
    std::size_t bytes = 0;
    int position = std::max(0, request.recorded().from());
    for (; position < *frames && bytes < kRecordedBytes; ++position) {
      const Result<FrameReport> report = reader_->ReadFrame(position);
      if (!report.ok()) return report.error();
      wire::RecordedFrame& frame = *recorded.add_frames();
      *frame.mutable_report() = ReportToWire(*report, true);
      const Result<cv::Mat> thumbnail = reader_->ReadThumbnail(position);
      if (thumbnail.ok() && !thumbnail->empty()) {
        wire::Request elsewhere;  // as for another machine: no shared memory for so little
        Result<wire::Pixels> pixels = SendablePixels(*thumbnail, link_.pixels()).For(elsewhere);
        if (!pixels.ok()) return pixels.error();
        *frame.mutable_thumbnail() = std::move(pixels).value();
      }
      bytes += frame.ByteSizeLong();
    }
    recorded.set_end(ended && position >= *frames);
    recorded.set_interrupted(recorded.end() && interrupted_);
    return reply;
  }

  /// Where a mapper that starts now goes on: read from the file, as `run --resume` does.
  Result<wire::Reply> Resume(const std::stop_token& end) {
    const std::lock_guard lock(mutex_);
    while (writer_->num_written() < num_handed_) {
      if (end.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    wire::Reply reply;
    wire::Resume& resume = *reply.mutable_resume();
    if (num_handed_ == 0) return reply;
    const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(out_);
    if (!reader.ok()) return reader.error();
    const Result<FrameReport> last = (*reader)->LastFrame();
    if (!last.ok()) return last.error();
    const Result<OptionHistory> options = OptionHistory::Read(**reader);
    if (!options.ok()) return options.error();
    const Result<LandmarkHistory> landmarks = ReadLandmarks(**reader);
    if (!landmarks.ok()) return landmarks.error();
    for (const auto& [frame, edges] : *landmarks) {
      wire::Landmarks& row = *resume.add_landmarks();
      row.set_frame(frame);
      row.set_edges(LandmarkEdgesToText(edges));
    }
    resume.set_has_frames(true);
    *resume.mutable_last() = ReportToWire(*last, true);
    resume.set_options(OptionsToJson(options->newest()).dump());
    return reply;
  }

  const NodeSetup& setup_;
  NodeLink& link_;
  const std::stop_token stop_;
  const std::filesystem::path out_;
  int num_models_ = 0;
  ParticleSharing sharing_;
  RunPoses poses_;

  // Of whoever keeps a copy.
  std::unique_ptr<RunReader> reader_;  ///< Of the thread that serves.
  std::atomic<std::int64_t> copied_ns_{0};
  std::atomic<bool> ended_{false}, interrupted_{false};

  std::mutex mutex_;  ///< Of what follows.
  std::unique_ptr<RunWriter> writer_;
  std::deque<int> waiting_;  ///< Frames handed over that are not known to be written.
  int num_handed_ = 0;       ///< Frames in the file and on their way.
  int handed_ = std::numeric_limits<int>::min(), kept_ = std::numeric_limits<int>::min();
};

}  // namespace

Status RunRecorderNode(const NodeSetup& setup) {
  Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  const Status status = RecorderProcess(setup, **link).Run();
  if (!status.ok() && status.error().code == ErrorCode::kCancelled) {
    return Error{ErrorCode::kCancelled,
                 "stopped; '" + setup.plan.out.string() + "' keeps what was recorded"};
  }
  return status;
}

}  // namespace plumbline
