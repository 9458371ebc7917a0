// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where playing stands, and what happened so far.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/mapping/event_report.h"
#include "engine/snapshot/run_history.h"
#include "engine/sources/live_report.h"

namespace plumbline {

struct MapperOptions;

struct FrameEvent {
  int frame = 0;
  LifeEvent event;
};

enum class PlaybackState { kPaused, kPlaying, kFinished, kFailed };

struct PlaybackView {
  PlaybackState state = PlaybackState::kPaused;
  int frame = 0;                   ///< Shown now.
  int newest_mapped_frame = -1;    ///< The mapper has come this far.
  std::string message;             ///< Of a failure, or what it does now.
  double speed = 1;                ///< Factor on the rate of the sequence; 0: as fast as it goes.
  std::optional<int> seek_target;  ///< Mapping towards this frame.
  double frames_per_second =
      0;                  ///< Measured over the last frames that were shown; 0 while it rests.
  bool recorded = false;  ///< All frames come from a run file: nothing is mapped here.
  bool growing = false;   ///< Somebody else is mapping that run: more frames come.
  /// Life events of all frames so far, by frame; never null.
  std::shared_ptr<const std::vector<FrameEvent>> events =
      std::make_shared<const std::vector<FrameEvent>>();
  /// Never null.
  std::shared_ptr<const RunHistory> history = std::make_shared<const RunHistory>();
  bool mapping = false;  ///< The mapper goes on, whatever is shown.
  bool follow = false;   ///< Shows the newest frame; only while `mapping` or `growing`.
  bool loop = false;     ///< Playing starts again at the end.
  /// Of the frame that is mapped next; null until the source is open.
  std::shared_ptr<const MapperOptions> options;
  /// That the shown frame was mapped with; null until there is one.
  std::shared_ptr<const MapperOptions> shown_options;
  std::uint64_t seed = 0;  ///< Of the run.
  /// What edges and boxes come from, as --edges and --detector name it; "": not known.
  std::string edges, detector;
  std::string recording;  ///< The run file that holds the mapped frames; "": none.
  /// How a recording that is played to the mapper by the clock fares; nothing: every frame is
  /// mapped.
  std::optional<LiveReport> live;
  std::optional<int> range_begin, range_end;  ///< Frames that playing keeps to, both included.
};

}  // namespace plumbline
