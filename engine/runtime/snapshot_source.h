// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/mapping/mapper_options.h"
#include "engine/recording/run_header.h"
#include "engine/snapshot/commands.h"
#include "engine/snapshot/playback_view.h"
#include "engine/snapshot/probe_view.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct MapSnapshot;

/// Where the frames of the window come from: a mapper at work on a sequence, or a run file.
/// Positions count the frames that are mapped, from 0; a run may leave out frames of its sequence.
/// Used from one thread.
class SnapshotSource {
 public:
  virtual ~SnapshotSource() = default;

  virtual const SequenceView& view() const = 0;
  /// Rises when view() has changed.
  virtual int view_version() const { return 0; }
  /// Positions there will be in the end (live: at most); at least 1.
  virtual int size() const = 0;
  /// Positions that Past can give now.
  virtual int mapped() const = 0;
  /// Number in the sequence of the frame at a position 0 .. size() - 1.
  virtual int FrameAt(int position) const = 0;
  /// Nothing is mapped here: every frame is a past one.
  virtual bool recorded() const = 0;

  /// Maps the frame at position mapped() < size(). Errors: what went wrong; kCancelled once `stop`
  /// is asked for.
  virtual Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token stop) = 0;
  /// A frame 0 .. mapped() - 1 as it was when it was mapped.
  virtual Result<std::shared_ptr<const MapSnapshot>> Past(int position, std::stop_token stop) = 0;
  /// Life events of the frames that are mapped, by frame.
  virtual const std::vector<FrameEvent>& events() const = 0;
  /// Of the frames that are mapped, as far as it is known yet.
  virtual const RunHistory& history() const = 0;
  /// Answers about a frame that this source gave.
  virtual ProbeView Probe(const MapSnapshot& snapshot, const ProbeCommand& request);
  /// The options of the frame that is mapped next; of a recorded run, of its last one.
  virtual MapperOptions options() const { return {}; }
  /// The options that a frame was mapped with.
  virtual MapperOptions OptionsAt(int /*frame*/) const { return options(); }
  /// What the run is made from; null: it is none.
  virtual std::shared_ptr<const RunHeader> header() const { return nullptr; }
  /// Takes effect with the next frame that is mapped. Errors: kUnsupported where nothing is mapped.
  virtual Status SetOptions(const MapperOptions&) {
    return Error{ErrorCode::kUnsupported,
                 "what is recorded keeps its options; fork the run to try others"};
  }
  /// The run file that holds the frames which are mapped; empty: none.
  virtual std::filesystem::path recording() const { return {}; }
  /// How a recording that is played to the mapper by the clock fares; nothing: every frame is
  /// mapped. Such a source leaves frames out: what comes after the mapped ones moves up, and size()
  /// falls, with each that it passes over.
  virtual std::optional<LiveReport> live() const { return std::nullopt; }
  /// Frames come by themselves, so the newest is what is shown first: a live source, or a run that
  /// somebody is mapping.
  virtual bool grows() const { return live().has_value(); }
  /// Of a recorded source that grows: takes what has come since; true if there is a new frame, or
  /// if no more will come. Returns at once. Errors: of the file.
  virtual Result<bool> Grow() { return false; }
  /// Reads a little more of the history, for some milliseconds; false once there is no more to
  /// read.
  virtual bool ReadAhead() { return false; }
};

}  // namespace plumbline
