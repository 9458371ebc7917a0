// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/mapping_process.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "engine/base/log.h"
#include "engine/base/overloaded.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

namespace {
constexpr auto kHistoryPeriod = std::chrono::milliseconds(150);
constexpr auto kLookForMore = std::chrono::milliseconds(50);
}  // namespace

MappingProcess::MappingProcess(OpenSource open, std::optional<int> start_frame,
                               std::function<void()> on_publish)
    : open_(std::move(open)), start_frame_(start_frame), on_publish_(std::move(on_publish)) {
  state_.message = "Opening";
  playback_.Publish(std::make_shared<const PlaybackView>(state_));
  thread_ = std::jthread([this](std::stop_token stop) { Run(stop); });
}

MappingProcess::~MappingProcess() {
  thread_.request_stop();
  commands_.Close();
  if (thread_.joinable()) thread_.join();
}

void MappingProcess::Post(PlaybackCommand command) {
  if (!commands_.TryPush(std::move(command))) {
    log::warn("the playback does not keep up with its commands; one was dropped");
  }
}

void MappingProcess::Run(std::stop_token stop) {
  try {
    const WorkContext work{[this](const Progress& progress) { ReportProgress(progress); }, stop};
    auto source = open_(work);
    if (source.ok()) {
      source_ = std::move(source).value();
      Loop(stop);
    } else if (source.error().code != ErrorCode::kCancelled) {
      Fail(source.error().message);
    }
  } catch (const std::exception& error) {
    Fail(std::string("This is a bug in Plumbline: ") + error.what());
  }
  source_.reset();  // It may own things of this thread.
}

void MappingProcess::ReportProgress(const Progress& progress) {
  state_.message = std::string(progress.stage);
  if (progress.total > 0) {
    state_.message +=
        ": " + std::to_string(progress.done) + " of " + std::to_string(progress.total);
  }
  PublishPlayback();
}

void MappingProcess::Loop(std::stop_token stop) {
  state_.recorded = source_->recorded();
  state_.options = std::make_shared<const MapperOptions>(source_->options());
  state_.recording = source_->recording().string();
  state_.message.clear();
  if (auto header = source_->header()) {
    state_.seed = header->recipe.seed;
    if (header->recipe.edges) state_.edges = ToText(*header->recipe.edges);
    if (header->recipe.detector) state_.detector = ToText(*header->recipe.detector);
    made_from_ = header;
    header_.Publish(std::move(header));
  }
  PublishView();
  state_.frame = source_->FrameAt(0);
  if (source_->grows() && !start_frame_)
    Follow(true);
  else
    SetTarget(start_frame_ ? PositionOf(*start_frame_) : 0);
  PublishPlayback();
  while (!stop.stop_requested()) {
    LookForMore();
    if (target_ || (playing_ && Clock::now() >= due_)) {
      TakeCommands();
      Advance(stop);
    } else if (MapsOn()) {
      TakeCommands();
      MapOn(stop);
    } else if (auto command = NextCommand()) {
      Apply(*command);
      TakeCommands();
      if (!target_) PublishPlayback();
    }
  }
}

/// Waits for a command, while playing until the next frame is due; reads ahead meanwhile.
std::optional<PlaybackCommand> MappingProcess::NextCommand() {
  while (reads_ahead_) {
    if (auto command = commands_.TryPop()) return command;
    if (playing_ && Clock::now() >= due_) return std::nullopt;
    reads_ahead_ = source_->ReadAhead();
    if (!reads_ahead_ || Clock::now() - history_published_ > kHistoryPeriod) {
      history_changed_ = true;
      PublishPlayback();
    }
  }
  const auto look = Clock::now() + kLookForMore;
  if (growing()) return commands_.PopUntil(playing_ ? std::min(due_, look) : look);
  return playing_ ? commands_.PopUntil(due_) : commands_.Pop();
}

/// A run that somebody is mapping: its frames come by themselves.
bool MappingProcess::growing() const { return source_->recorded() && source_->grows() && !failed_; }

void MappingProcess::LookForMore() {
  if (!growing()) return;
  const Result<bool> more = source_->Grow();
  if (!more.ok()) return Fail(more.error().message);
  if (!*more) return;
  reads_ahead_ = true;
  if (source_->view_version() != published_view_) PublishView();
  if (state_.follow && position_ < LastPosition()) SetTarget(LastPosition());
  if (!growing()) state_.follow = false;
  PublishPlayback();
}

void MappingProcess::TakeCommands() {
  while (auto command = commands_.TryPop()) Apply(*command);
}

int MappingProcess::PositionOf(int frame) const {
  int low = 0, high = source_->size();  // the last position whose frame is at most `frame`
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    (source_->FrameAt(middle) <= frame ? low : high) = middle;
  }
  return low;
}

/// A failed source goes no further than it came.
int MappingProcess::LastPosition() const {
  return failed_ ? std::max(source_->mapped() - 1, 0) : source_->size() - 1;
}

int MappingProcess::RangeBegin() const {
  return state_.range_begin ? PositionOf(*state_.range_begin) : 0;
}
int MappingProcess::RangeEnd() const {
  return state_.range_end ? std::min(PositionOf(*state_.range_end), LastPosition())
                          : LastPosition();
}

/// Nobody can tell what a live source will have mapped by then: it goes as far as the newest frame.
void MappingProcess::SetTarget(int position) {
  const int last = LastPosition();
  const bool unknown = source_->grows() && !source_->recorded();
  target_ = std::clamp(position, 0, unknown ? std::min(last, source_->mapped()) : last);
}

void MappingProcess::Apply(const PlaybackCommand& command) {
  std::visit(
      Overloaded{[&](const PlayCommand&) { Play(true); }, [&](const PauseCommand&) { Play(false); },
                 [&](const TogglePlayCommand&) { TogglePlay(); },
                 [&](const StepCommand& c) { Step(c.frames); },
                 [&](const SeekCommand& c) { Seek(c.frame); },
                 [&](const SetSpeedCommand& c) {
                   state_.speed = c.speed;
                   due_ = Clock::now();
                 },
                 [&](const SetRangeCommand& c) { SetRange(c); },
                 [&](const SetLoopCommand& c) { state_.loop = c.loop; },
                 [&](const FollowNewestCommand& c) { Follow(c.on); },
                 [&](const SetOptionsCommand& c) { SetOptions(c.options); },
                 [&](const ProbeCommand& c) { AnswerProbe(c); },
                 [&](const WatchCommand& c) { Watch(c); }},
      command);
}

void MappingProcess::Play(bool on) {
  if (!on) state_.mapping = false;
  state_.follow = false;
  if (on && growing() && position_ >= LastPosition() && !state_.loop) return Follow(true);
  playing_ = on && !(failed_ && position_ >= LastPosition());
  if (playing_ && (position_ >= RangeEnd() || position_ < RangeBegin())) SetTarget(RangeBegin());
  if (!on) target_.reset();
  due_ = Clock::now();
}

void MappingProcess::TogglePlay() {
  const bool in_past = state_.mapping && !state_.follow;
  if (in_past && playing_)
    playing_ = false;  // the mapper stays at work
  else
    Play(!playing_ && !target_ && !state_.follow);
}

void MappingProcess::Step(int frames) {
  playing_ = false;
  const int wanted = target_.value_or(position_) + frames;
  SetTarget(wanted);
  state_.follow = (state_.mapping || growing()) && wanted >= source_->mapped();
}

void MappingProcess::Seek(int frame) {
  SetTarget(PositionOf(frame));
  state_.follow = (state_.mapping || growing()) && *target_ + 1 >= source_->mapped();
}

void MappingProcess::SetRange(const SetRangeCommand& range) {
  state_.range_begin = range.begin;
  state_.range_end = range.end;
  if (range.begin && range.end && *range.begin > *range.end)
    std::swap(state_.range_begin, state_.range_end);
}

void MappingProcess::AnswerProbe(const ProbeCommand& question) {
  if (const auto shown = snapshot_.Latest())
    probe_.Publish(std::make_shared<const ProbeView>(source_->Probe(*shown, question)));
}

void MappingProcess::SetOptions(const MapperOptions& options) {
  if (const Status status = source_->SetOptions(options); !status.ok())
    log::warn("{}", status.error().message);
  state_.options = std::make_shared<const MapperOptions>(source_->options());
}

void MappingProcess::Watch(const WatchCommand& what) {
  analyst_.Watch(what);
  if (const auto shown = snapshot_.Latest())
    analysis_.Publish(analyst_.OfFrame(shown, source_->view(), *state_.shown_options, recipe()));
  object_history_.Publish(analyst_.OfHistory(source_->history(), source_->view()));
  timings_.Publish(analyst_.OfTimings(source_->history()));
}

void MappingProcess::Follow(bool on) {
  playing_ = false;
  target_.reset();
  state_.mapping = on && !failed_ && source_->mapped() < source_->size();
  state_.follow = on && (state_.mapping || growing());
  if (on && source_->mapped() > 0 && position_ + 1 < source_->mapped())
    SetTarget(source_->mapped() - 1);
}

bool MappingProcess::MapsOn() const { return state_.mapping && !failed_; }

/// Maps a frame while a past one is shown, or to be shown.
void MappingProcess::MapOn(std::stop_token stop) {
  if (!MapsOn() || target_) return PublishPlayback();
  const int next = source_->mapped();
  if (next >= source_->size()) {
    state_.mapping = state_.follow = false;
    return PublishPlayback();
  }
  auto snapshot = source_->Next(stop);
  if (source_->view_version() != published_view_) PublishView();
  if (state_.follow || !snapshot.ok()) return Show(std::move(snapshot), next);
  history_changed_ = true;
  PublishPlayback();
}

/// One frame: the target if it is mapped, else the next towards it; without a target the next of
/// playing.
void MappingProcess::Advance(std::stop_token stop) {
  if (!target_ && !playing_) return PublishPlayback();
  if (!target_ && position_ >= RangeEnd() && state_.loop && !failed_) SetTarget(RangeBegin());
  const int wanted = target_.value_or(position_ + 1);
  if (wanted > (target_ ? LastPosition() : RangeEnd())) {
    playing_ = false;
    target_.reset();
    if (growing() && !state_.range_end) Follow(true);
    return PublishPlayback();
  }
  if (wanted < source_->mapped()) {
    target_.reset();
    Show(source_->Past(wanted, stop), wanted);
  } else {
    const int next = source_->mapped();
    if (target_ && next >= *target_) target_.reset();
    auto snapshot = source_->Next(stop);
    if (source_->view_version() != published_view_) PublishView();
    Show(std::move(snapshot), next);
  }
  const int at = std::max(position_, 0), after = std::min(at + 1, source_->size() - 1);
  const double frames = source_->FrameAt(after) - source_->FrameAt(at);
  const double rate = source_->view().rate_hz * state_.speed;
  const auto period = std::chrono::duration<double>(rate > 0 ? std::max(frames, 1.0) / rate : 0.0);
  // A frame that came late does not hurry the ones after it.
  due_ = std::max(due_ + std::chrono::duration_cast<Clock::duration>(period), Clock::now());
}

void MappingProcess::Show(Result<std::shared_ptr<const MapSnapshot>> snapshot, int position) {
  if (!snapshot.ok()) {
    if (snapshot.error().code != ErrorCode::kCancelled) Fail(snapshot.error().message);
    return;
  }
  MeasureRate();
  position_ = position;
  history_changed_ = history_changed_ || !source_->recorded();
  state_.frame = source_->FrameAt(position);
  state_.shown_options = std::make_shared<const MapperOptions>(source_->OptionsAt(state_.frame));
  analysis_.Publish(analyst_.OfFrame(*snapshot, source_->view(), *state_.shown_options, recipe()));
  snapshot_.Publish(std::move(snapshot).value());
  PublishPlayback();
}

/// Over the last second, and at least the last two frames: two that follow at once (a seek, then
/// playing) say nothing of a rate.
void MappingProcess::MeasureRate() {
  constexpr double kWindow_s = 1.0, kLeast_s = 0.25, kRest_s = 30.0;
  const auto now = Clock::now();
  const auto age_s = [&](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  if (!shown_at_.empty() && age_s(shown_at_.back()) > kRest_s) shown_at_.clear();
  shown_at_.push_back(now);
  while (shown_at_.size() > 2 && age_s(shown_at_[1]) > kWindow_s) shown_at_.pop_front();
  const double span_s = age_s(shown_at_.front());
  state_.frames_per_second =
      span_s < kLeast_s ? 0.0 : static_cast<double>(shown_at_.size() - 1) / span_s;
}

void MappingProcess::PublishView() {
  published_view_ = source_->view_version();
  sequence_.Publish(std::make_shared<const SequenceView>(source_->view()));
}

void MappingProcess::Fail(std::string message) {
  log::error("{}", message);
  failed_ = true;
  playing_ = state_.mapping = state_.follow = false;
  target_.reset();
  state_.message = std::move(message);
  PublishPlayback();
}

void MappingProcess::PublishPlayback() {
  if (source_ != nullptr) {
    state_.live = source_->live();
    state_.newest_mapped_frame =
        source_->mapped() > 0 ? source_->FrameAt(source_->mapped() - 1) : -1;
    if (source_->events().size() != published_events_) {
      published_events_ = source_->events().size();
      state_.events = std::make_shared<const std::vector<FrameEvent>>(source_->events());
    }
    if (history_changed_) {
      history_changed_ = false;
      history_published_ = Clock::now();
      state_.history = std::make_shared<const RunHistory>(source_->history());
      object_history_.Publish(analyst_.OfHistory(source_->history(), source_->view()));
      truths_.Publish(FrameAnalyst::OfTruths(source_->history(), source_->events(), source_->view(),
                                             source_->options()));
      timings_.Publish(analyst_.OfTimings(source_->history()));
    }
    state_.growing = growing();
    const bool at_end = !playing_ && !target_ && !state_.mapping && !state_.growing &&
                        position_ + 1 >= source_->size();
    state_.state = failed_                     ? PlaybackState::kFailed
                   : playing_ || state_.follow ? PlaybackState::kPlaying
                   : at_end                    ? PlaybackState::kFinished
                                               : PlaybackState::kPaused;
  } else if (failed_) {
    state_.state = PlaybackState::kFailed;
  }
  state_.seek_target =
      target_ && source_ != nullptr ? std::optional(source_->FrameAt(*target_)) : std::nullopt;
  if (!playing_ && !target_ && !state_.follow) {
    state_.frames_per_second = 0;
    shown_at_.clear();
  }
  playback_.Publish(std::make_shared<const PlaybackView>(state_));
  if (on_publish_) on_publish_();
}

}  // namespace plumbline
