// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "engine/base/progress.h"
#include "engine/base/queue.h"
#include "engine/runtime/frame_analyst.h"
#include "engine/runtime/snapshot_source.h"
#include "engine/snapshot/commands.h"
#include "engine/snapshot/playback_view.h"
#include "engine/snapshot/timing_statistics.h"
#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// Gives a SnapshotSource a thread: takes playback commands, publishes snapshots. Nobody waits for
/// it: Post returns at once (a full queue drops the command) and the slots hold the newest state.
/// Opening the source happens on the thread, too. A source that fails or throws turns the state to
/// kFailed with its sentence; frames that are already mapped can still be shown. The destructor
/// stops within one step of the source and joins.
class MappingProcess {
 public:
  /// `work` tells the window how far it is and asks to stop.
  using OpenSource =
      std::function<Result<std::unique_ptr<SnapshotSource>>(const WorkContext& work)>;

  /// @param on_publish  Called on the thread after every publication (to wake the window). May be
  /// empty.
  MappingProcess(OpenSource open, std::optional<int> start_frame, std::function<void()> on_publish);
  ~MappingProcess();
  MappingProcess(const MappingProcess&) = delete;
  MappingProcess& operator=(const MappingProcess&) = delete;

  void Post(PlaybackCommand command);

  /// Null until the source is open.
  std::shared_ptr<const SequenceView> Sequence() const { return sequence_.Latest(); }
  /// Null until the first frame.
  std::shared_ptr<const MapSnapshot> Snapshot() const { return snapshot_.Latest(); }
  /// The last answer to a ProbeCommand; null before the first.
  std::shared_ptr<const ProbeView> Probe() const { return probe_.Latest(); }
  /// Of the newest snapshot, published just before it; null before the first.
  std::shared_ptr<const FrameAnalysis> Analysis() const { return analysis_.Latest(); }
  /// Null while nobody watches an object's history.
  std::shared_ptr<const ObjectHistory> History() const { return object_history_.Latest(); }
  /// Of the stages over all frames; null while nobody watches them.
  std::shared_ptr<const TimingStatistics> Timings() const { return timings_.Latest(); }
  /// What the run has of the ground truth, and what not; null without any.
  std::shared_ptr<const TruthsView> Truths() const { return truths_.Latest(); }
  /// What the run is made from; null until the source is open, or if it has none.
  std::shared_ptr<const RunHeader> Header() const { return header_.Latest(); }
  /// Never null.
  std::shared_ptr<const PlaybackView> Playback() const { return playback_.Latest(); }

 private:
  using Clock = std::chrono::steady_clock;

  void Run(std::stop_token stop);
  void Loop(std::stop_token stop);
  void ReportProgress(const Progress& progress);
  void Apply(const PlaybackCommand& command);
  void Play(bool on);
  void TogglePlay();
  void Step(int frames);
  void Seek(int frame);
  void SetRange(const SetRangeCommand& range);
  void AnswerProbe(const ProbeCommand& question);
  void SetOptions(const MapperOptions& options);
  void Watch(const WatchCommand& what);
  const RunRecipe* recipe() const { return made_from_ ? &made_from_->recipe : nullptr; }
  /// Of the last frame that is at most `frame`.
  int PositionOf(int frame) const;
  int LastPosition() const;
  int RangeBegin() const;
  int RangeEnd() const;
  std::optional<PlaybackCommand> NextCommand();
  void SetTarget(int position);
  void TakeCommands();
  void Advance(std::stop_token stop);
  bool MapsOn() const;
  bool growing() const;
  void LookForMore();
  void MapOn(std::stop_token stop);
  void Follow(bool on);
  void PublishView();
  void Show(Result<std::shared_ptr<const MapSnapshot>> snapshot, int position);
  void Fail(std::string message);
  void MeasureRate();
  void PublishPlayback();

  OpenSource open_;
  std::optional<int> start_frame_;
  std::function<void()> on_publish_;
  BoundedQueue<PlaybackCommand> commands_{1024};
  SnapshotSlot<SequenceView> sequence_;
  SnapshotSlot<MapSnapshot> snapshot_;
  SnapshotSlot<PlaybackView> playback_;
  SnapshotSlot<ProbeView> probe_;
  SnapshotSlot<FrameAnalysis> analysis_;
  SnapshotSlot<ObjectHistory> object_history_;
  SnapshotSlot<TimingStatistics> timings_;
  SnapshotSlot<TruthsView> truths_;
  SnapshotSlot<RunHeader> header_;
  std::shared_ptr<const RunHeader> made_from_;  ///< The same, for the process itself.

  // Of the thread only.
  std::unique_ptr<SnapshotSource> source_;
  FrameAnalyst analyst_;
  PlaybackView state_;
  std::size_t published_events_ = 0;
  int published_view_ = 0;
  bool playing_ = false;
  bool failed_ = false;
  bool reads_ahead_ = true;  ///< The source may have more to read.
  bool history_changed_ = true;
  Clock::time_point history_published_{};
  int position_ = -1;                       ///< Shown.
  std::optional<int> target_;               ///< Position to show next, or to map towards.
  Clock::time_point due_{};                 ///< When the next frame of playing is due.
  std::deque<Clock::time_point> shown_at_;  ///< The last frames of one going on.

  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
