// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "engine/sources/frame_source.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {

class Mapper;
struct FrameReport;
struct MapperInput;

/// Points found and poses told since the frame before, in their order.
using PoseNews = std::vector<std::variant<PointEstimates, PoseEstimate>>;

/// Stands between the poses of a source and the mapper: with poses of a filter, objects that are
/// seen again correct them; given poses go through as they are. Single-threaded.
class CorrectedPoses {
 public:
  /// Poses that are given.
  CorrectedPoses() = default;
  /// Those of a filter. @param loops  What objects have corrected so far.
  explicit CorrectedPoses(LandmarkLoops loops) : loops_(std::move(loops)) {}

  /// Tells the mapper what the source told.
  void Take(const PoseNews& news, Mapper& mapper);
  /// The frame that is mapped next has this pose. @param input  Of the frame, or null; gets the
  ///        pose as it is known by now.
  void See(const std::optional<PoseEstimate>& told, MapperInput* input);
  /// Objects that this frame shows again correct poses, its own as later ones see it included. The
  /// report gets the event.
  void CloseLoops(FrameReport& report, Mapper& mapper);
  /// Goes on after corrections that a run file keeps.
  void Add(std::span<const LandmarkEdge> edges, Mapper& mapper);

  /// A pose of the source as it is known now.
  std::optional<PoseEstimate> Now(const std::optional<PoseEstimate>& told) const {
    return told && loops_ ? loops_->Now(*told) : told;
  }
  /// Null for poses that are given.
  const LandmarkLoops* loops() const { return loops_ ? &*loops_ : nullptr; }

 private:
  void TellAll(Mapper& mapper) const;

  std::optional<LandmarkLoops> loops_;
};

}  // namespace plumbline
