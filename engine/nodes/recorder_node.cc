// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/base/timer.h"
#include "engine/mapping/map_report.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/nodes/report_message.h"
#include "engine/recording/landmark_history.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

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
    std::shared_ptr<const OwnPoses> poses;
    if (!setup_.node.poses.empty()) {
      const Result<NodeClient*> vio = link_.Ask(setup_.node.poses);
      if (!vio.ok()) return vio.error();
      if (setup_.plan.recipe->live_speed) {
        own_poses_ = std::make_unique<OwnPoseStore>(MakeRemoteOwnPoses(**vio));
      } else {
        auto found = AskForOwnPoses(**vio, stop_);
        if (!found.ok()) return found.error();
        poses = std::move(found).value();
      }
    }
    if (Status status = OpenRun((*reply)->header().json(), poses.get()); !status.ok())
      return status;
    std::jthread serving([this](const std::stop_token& end) { Serve(end); });
    Status status = Record(**mapper, **player);
    if (status.ok() && own_poses_ != nullptr) status = TellWhatItBecame(**mapper);
    const std::lock_guard lock(mutex_);
    const Status closed = writer_->Close();
    return status.ok() ? closed : status;
  }

 private:
  /// That this graph has begun the run file: whoever starts this node again must go on with it.
  std::filesystem::path Begun() const { return setup_.plan.folder / "recording"; }

  /// @param poses  Null unless poses = vio.
  Status OpenRun(const std::string& json, const OwnPoses* poses) {
    Result<RunHeader> header = HeaderFromJson(ParseJson(json));
    if (!header.ok())
      return Error{header.error().code,
                   "the mapper sent a run whose header is none: " + header.error().message};
    num_models_ = static_cast<int>(header->models.size());
    std::error_code ignored;
    const bool go_on = std::filesystem::exists(out_, ignored) &&
                       (setup_.plan.resume || std::filesystem::exists(Begun(), ignored));
    if (go_on) {
      Result<RunWriter::Resumed> resumed = setup_.plan.recipe->live_speed
                                               ? RunWriter::Reopen(out_)
                                               : RunWriter::OpenToResume(out_, *header, poses);
      if (!resumed.ok()) return resumed.error();
      writer_ = std::move(resumed->writer);
      if (resumed->last) handed_ = kept_ = resumed->last->frame;
    } else {
      Result<std::unique_ptr<RunWriter>> created = RunWriter::Create(out_, *header, {}, poses);
      if (!created.ok()) return created.error();
      writer_ = std::move(created).value();
    }
    num_handed_ = writer_->num_written();
    return WriteFileAtomically(Begun(), out_.string() + "\n");
  }

  /// Of a live run: its last frame, and poses up to it.
  Status TellWhatItBecame(NodeClient& mapper) {
    wire::Request request;
    request.mutable_header();
    const Result<SharedReply> reply = mapper.AskAndWait(std::move(request), stop_);
    if (!reply.ok()) return reply.error();
    const Result<RunHeader> header = HeaderFromJson(ParseJson((*reply)->header().json()));
    if (!header.ok()) return header.error();
    own_poses_->Advance(header->end_frame - 1, stop_);
    const std::lock_guard lock(mutex_);
    writer_->SetGrown(*header, own_poses_->Copy());
    return {};
  }

  /// Of a live run, those that are known by now; about once a second, else null.
  std::shared_ptr<const OwnPoses> GrownPoses(int frame) {
    if (own_poses_ == nullptr) return nullptr;
    own_poses_->Advance(frame, stop_);
    if (since_grown_.Milliseconds() < grown_pause_ms_) return nullptr;
    since_grown_ = Stopwatch();
    auto poses = own_poses_->Copy();
    grown_pause_ms_ = std::max(1000.0, 20 * since_grown_.Milliseconds());
    return poses;
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
      ShareParticles(message, *report);
      // As in one process, a frame whose image cannot be read has no picture.
      const Result<cv::Mat> image = TakePixels(
          images, report->frame, stop_,
          [](const wire::Reply& answer) { return PixelsFromWire(answer.image().pixels()); });
      if (!image.ok() && image.error().code == ErrorCode::kCancelled) return image.error();
      const auto grown = GrownPoses(report->frame);
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
      link_.SetState("recorded " + std::to_string(message.done()) + " of " +
                     std::to_string(message.selected()) + " frames");
    }
  }

  /// Sets of particles that an object has kept since the frame before are one set again, as the
  /// mapper has them: the run file stores them once.
  void ShareParticles(const wire::Report& message, FrameReport& report) {
    std::map<int, KeptParticles> now;
    for (int i = 0; i < message.objects_size(); ++i) {
      const std::string& bytes = message.objects(i).particles();
      if (bytes.empty()) continue;
      auto& particles = report.objects[static_cast<std::size_t>(i)].particles;
      const auto before = particles_.find(message.objects(i).id());
      if (before != particles_.end() && before->second.bytes == bytes)
        particles = before->second.particles;
      now[message.objects(i).id()] = {bytes, particles};
    }
    particles_ = std::move(now);
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
      if (!request.has_resume()) return DoesNotAnswer(request, setup_.node);
      return Resume(end);
    });
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

  struct KeptParticles {
    std::string bytes;
    std::shared_ptr<const std::vector<Particle>> particles;
  };

  const NodeSetup& setup_;
  NodeLink& link_;
  const std::stop_token stop_;
  const std::filesystem::path out_;
  int num_models_ = 0;
  std::map<int, KeptParticles> particles_;   ///< By object, of the last frame.
  std::unique_ptr<OwnPoseStore> own_poses_;  ///< Of a live run with poses = vio, else null.
  Stopwatch since_grown_;
  double grown_pause_ms_ = 0;

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
