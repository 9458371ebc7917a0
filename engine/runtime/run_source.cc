// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/run_source.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "engine/analysis/history.h"
#include "engine/analysis/sequence_view.h"
#include "engine/analysis/true_instances.h"
#include "engine/base/file_lock.h"
#include "engine/base/log.h"
#include "engine/base/timer.h"
#include "engine/pipeline/frame_pictures.h"
#include "engine/pipeline/hypothesis_probe.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/recording/smoothed_record.h"
#include "engine/runtime/past_frame.h"
#include "engine/runtime/probe_answer.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr std::size_t kPictureMemoryBytes = 300u << 20;
constexpr auto kReadAheadTime = std::chrono::milliseconds(8);
constexpr auto kLookAgain = std::chrono::milliseconds(40);
constexpr auto kAskWhoWrites = std::chrono::milliseconds(500);
/// A recorder that died is started again within this time, or not at all.
constexpr auto kWriterPatience = std::chrono::seconds(10);
/// Opening the sequence again may take this share of the time.
constexpr int kReopenShare = 20;

using Clock = std::chrono::steady_clock;

struct Inputs {
  std::unique_ptr<FramePictures> pictures;
  SequenceView view;
  std::shared_ptr<const ModelDatabase> database;
  bool has_sequence = false;
};

enum class Scan { kRead, kLeaveOut };

Result<Inputs> OpenInputs(const RunChoice& choice, RunReader& reader,
                          std::shared_ptr<const ModelDatabase> database, Scan scan,
                          const WorkContext& work) {
  const RunHeader& header = reader.header();
  auto sequence = OpenSequenceOfRun(choice, header);
  if (!sequence.ok() && !choice.sequence.empty()) return sequence.error();
  Inputs inputs{nullptr, {}, database};
  if (!sequence.ok()) {
    log::warn(
        "{}; the run's small pictures stand in for its images (--sequence names another folder)",
        sequence.error().message);
    inputs.pictures = std::make_unique<FramePictures>(header.camera, *database);
    inputs.view = ViewWithoutSequence(header, *database);
  } else {
    auto pictures = FramePictures::Create(*sequence, database, header.recipe.edges);
    if (!pictures.ok()) return pictures.error();
    inputs.pictures = std::move(pictures).value();
    inputs.has_sequence = true;
    inputs.view = scan == Scan::kRead ? MakeSequenceView(**sequence, *database, work)
                                      : MakeViewWithoutScan(**sequence, *database);
    if (Status status = MoveWithCorrections(*sequence, reader, inputs.view); !status.ok())
      return status.error();
  }
  inputs.view.name += ", " + choice.run.filename().string();
  auto smoothed = ReadSmoothed(choice.run);
  if (!smoothed.ok()) {
    log::warn("{}; the run is shown without its second pass", smoothed.error().message);
  } else if (*smoothed) {
    inputs.view.smoothed = std::make_shared<const SmoothedMap>(**smoothed);
  }
  return inputs;
}

/// A run file. While somebody writes it, its frames become known as they come (Grow).
class RunSource : public SnapshotSource {
 public:
  RunSource(RunChoice choice, std::unique_ptr<RunReader> reader, std::vector<RunFrame> frames,
            Inputs inputs, LazyProbe probe, bool grows)
      : choice_(std::move(choice)),
        reader_(std::move(reader)),
        database_(std::move(inputs.database)),
        pictures_(std::move(inputs.pictures)),
        view_(std::move(inputs.view)),
        has_sequence_(inputs.has_sequence),
        truths_(view_),
        probe_(std::move(probe)),
        mapped_with_(reader_->header()),
        grows_(grows) {
    Take(std::move(frames));
  }

  /// Events of the frames that are known. Errors: of the file.
  Status ReadEvents() {
    const int first = num_with_events_;
    auto events = reader_->Events(first);
    if (!events.ok()) return events.error();
    num_with_events_ = size();
    for (const RunEvent& event : *events) {
      if (event.position >= size()) break;  // written since
      poses_corrected_ |= event.event.kind == EventKind::kPosesCorrected;
      mapped_with_.Add(event.frame, event.event);
      events_.push_back({event.frame, event.event});
    }
    return {};
  }

  const SequenceView& view() const override { return view_; }
  int view_version() const override { return view_version_; }
  int size() const override { return static_cast<int>(frames_.size()); }
  int mapped() const override { return size(); }
  bool grows() const override { return grows_; }

  Result<bool> Grow() override {
    const auto now = Clock::now();
    if (!grows_ || now < look_again_) return false;
    look_again_ = now + kLookAgain;
    auto more = reader_->Frames(size());
    if (!more.ok()) return more.error();
    if (more->empty()) return SeeWhetherItEnded(now);
    Take(std::move(more).value());
    if (Status status = ReadEvents(); !status.ok()) return status.error();
    if (Status status = FollowSequence(now); !status.ok()) return status.error();
    return true;
  }
  int FrameAt(int position) const override {
    return frames_[static_cast<std::size_t>(position)].frame;
  }
  bool recorded() const override { return true; }
  const std::vector<FrameEvent>& events() const override { return events_; }
  const RunHistory& history() const override { return history_; }
  ProbeView Probe(const MapSnapshot& snapshot, const ProbeCommand& request) override {
    return AnswerProbe(probe_, snapshot, view_, mapped_with_.At(snapshot.report.frame), request);
  }
  MapperOptions options() const override { return mapped_with_.newest(); }
  MapperOptions OptionsAt(int frame) const override { return mapped_with_.At(frame); }
  std::shared_ptr<const RunHeader> header() const override {
    return std::make_shared<const RunHeader>(reader_->header());
  }
  std::filesystem::path recording() const override { return reader_->file(); }

  bool ReadAhead() override {
    const auto until = std::chrono::steady_clock::now() + kReadAheadTime;
    while (read_ < size() && std::chrono::steady_clock::now() < until) {
      if (auto report = reader_->ReadFrameBrief(read_); report.ok()) {
        history_.frames[static_cast<std::size_t>(read_)] =
            std::make_shared<const FrameSample>(SampleOf(*report, view_, &truths_));
      }
      if (WantsThumbnail(read_, size())) {
        if (auto image = reader_->ReadThumbnail(read_); image.ok() && !image->empty())
          history_.thumbnails.push_back({FrameAt(read_), ThumbnailOf(*image)});
      }
      ++read_;
    }
    return read_ < size();
  }

  Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token) override {
    return Error{ErrorCode::kUnsupported, "a recorded run has no further frames"};
  }

  Result<std::shared_ptr<const MapSnapshot>> Past(int position, std::stop_token) override {
    return PastFrame(position, *reader_, *pictures_, memory_);
  }

 private:
  void Take(std::vector<RunFrame> frames) {
    frames_.insert(frames_.end(), frames.begin(), frames.end());
    history_.frames.resize(frames_.size());
    came_ = Clock::now();
  }

  /// True once it has: its writer is gone, and nothing is left to read.
  Result<bool> SeeWhetherItEnded(Clock::time_point now) {
    if (now < ask_who_writes_) return false;
    ask_who_writes_ = now + kAskWhoWrites;
    if (FileLock::IsHeld(choice_.run)) {
      came_ = now;
      return false;
    }
    const auto finished = reader_->Finished();
    if (!finished.ok()) return finished.error();
    if (!*finished && now - came_ < kWriterPatience) return false;
    auto last = reader_->Frames(size());  // between the look above and the end
    if (!last.ok()) return last.error();
    Take(std::move(last).value());
    if (Status status = ReadEvents(); !status.ok()) return status.error();
    grows_ = false;
    if (!has_sequence_ || (!view_.own_poses && !SequenceGrew() && !poses_corrected_)) return true;
    if (Status status = Reopen(Scan::kRead); !status.ok()) return status.error();
    return true;
  }

  /// A sequence that is being recorded, too, has more frames by now; and corrected poses move the
  /// past.
  Status FollowSequence(Clock::time_point now) {
    if (!has_sequence_) {
      if (SequenceGrew()) {
        view_.num_frames = frames_.back().frame + 1;
        ++view_version_;
      }
      return {};
    }
    const RunRecipe& recipe = reader_->header().recipe;
    const bool poses_grow = recipe.live_speed && recipe.poses.source == PoseSource::kVio;
    if ((!SequenceGrew() && !poses_grow && !poses_corrected_) || now < reopen_) return {};
    return Reopen(Scan::kLeaveOut);
  }

  bool SequenceGrew() const { return frames_.back().frame >= view_.num_frames; }

  Status Reopen(Scan scan) {
    const Stopwatch watch;
    auto inputs = OpenInputs(choice_, *reader_, database_, scan, WorkContext());
    if (!inputs.ok()) return inputs.error();
    if (scan == Scan::kLeaveOut && !inputs->view.own_poses) {  // else it would move
      inputs->view.scan = view_.scan;
      inputs->view.scan_coarse = view_.scan_coarse;
    }
    pictures_ = std::move(inputs->pictures);
    view_ = std::move(inputs->view);
    truths_ = TruthVisibility(view_);
    ++view_version_;
    poses_corrected_ = false;
    const double pause_ms = std::max(1000.0, kReopenShare * watch.Milliseconds());
    reopen_ = Clock::now() + std::chrono::milliseconds(static_cast<int>(pause_ms));
    return {};
  }

  RunChoice choice_;
  std::unique_ptr<RunReader> reader_;
  std::shared_ptr<const ModelDatabase> database_;
  std::unique_ptr<FramePictures> pictures_;
  SequenceView view_;
  bool has_sequence_;  ///< Which may be gone.
  int view_version_ = 0;
  TruthVisibility truths_;
  LazyProbe probe_;
  OptionHistory mapped_with_;
  SnapshotMemory memory_{kPictureMemoryBytes};
  std::vector<RunFrame> frames_;
  std::vector<FrameEvent> events_;
  int num_with_events_ = 0;  ///< Positions whose events are read.
  RunHistory history_;
  int read_ = 0;  ///< Positions that the history knows.
  bool grows_ = false, poses_corrected_ = false;
  Clock::time_point look_again_{}, ask_who_writes_{}, reopen_{};
  Clock::time_point came_{};  ///< When a frame, or at least a writer, was last there.
};

/// Frames of a run that has begun; waits for the first of one that somebody is writing.
Result<std::vector<RunFrame>> FirstFrames(const RunChoice& choice, RunReader& reader,
                                          const WorkContext& work) {
  while (true) {
    const bool grows = FileLock::IsHeld(choice.run);
    auto frames = reader.Frames();
    if (!frames.ok() || !frames->empty()) return frames;
    if (!grows)
      return Error{ErrorCode::kInvalidInput, "'" + choice.run.string() + "' holds no frames yet"};
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    work.report({"Waiting for the first frame"});
    std::this_thread::sleep_for(kLookAgain);
  }
}

}  // namespace

Result<std::unique_ptr<SnapshotSource>> OpenRunSource(const RunChoice& choice,
                                                      const WorkContext& work) {
  work.report({"Opening the run"});
  auto reader = RunReader::Open(choice.run);
  if (!reader.ok()) return reader.error();
  const RunHeader header = (*reader)->header();
  auto frames = FirstFrames(choice, **reader, work);
  if (!frames.ok()) return frames.error();
  auto database = LoadModelsOfRun(choice, header);
  if (!database.ok()) return database.error();
  auto inputs = OpenInputs(choice, **reader, *database, Scan::kRead, work);
  if (!inputs.ok()) return inputs.error();
  auto source = std::make_unique<RunSource>(
      choice, std::move(reader).value(), std::move(frames).value(), std::move(inputs).value(),
      LazyProbe(header.camera, *database, header.floor_in_world), FileLock::IsHeld(choice.run));
  if (Status status = source->ReadEvents(); !status.ok()) return status.error();
  return std::unique_ptr<SnapshotSource>(std::move(source));
}

}  // namespace plumbline
