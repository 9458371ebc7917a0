// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/snapshot/commands.h"
#include "engine/snapshot/truths_view.h"
#include "ui/framework/frame_context.h"
#include "ui/inspect/timeline/timeline_track.h"

namespace plumbline {

/// The life of one object.
struct ObjectLane {
  ObjectId id;  ///< Not valid: all objects that were never confirmed, together.
  int spawned = 0;
  int confirmed = -1;  ///< -1: never
  int ended = -1;      ///< -1: lives
  std::string name;    ///< "#3 chair_slat"
  std::vector<const FrameEvent*> events;
};
/// Objects that were confirmed at some time, and `also`, by birth; then one lane for the others,
/// unless `confirmed_only` leaves it out.
std::vector<ObjectLane> LanesOf(const std::vector<FrameEvent>& events, ObjectId also,
                                bool confirmed_only = false);

/// A true instance over the frames: where it shows, where a box lies over it, and which object it
/// is paired with.
struct TruthLane {
  std::size_t index = 0;  ///< In SequenceView::truth.
  std::string id;
  struct Span {
    enum class Kind { kSeen, kBoxed, kTentative, kConfirmed };
    Kind kind = Kind::kSeen;
    int from = 0, to = 0;  ///< Frames, both included.
    ObjectId object;       ///< Of the last two kinds.
  };
  std::vector<Span> spans;
};
/// Of one instance: frames that follow one another in the same way become one span.
TruthLane TruthLaneOf(const RunHistory& history, const std::string& id, std::size_t index);

/// A lane for every object of the run that is shown: its life, its events, its name; below them one
/// for each true instance that was missed, and for the selected one. Lanes that do not fit scroll
/// by the wheel or a drag over their names; a click there selects.
class TimelineLanes {
 public:
  /// Reads again what has changed.
  /// @param all_truths  Lanes for the true instances that were found, too.
  void Update(const FrameContext& context, bool all_truths);
  std::size_t size() const { return lanes_.size() + truths_.size(); }
  /// Between y0 and y1; names begin at label_x, left of the axis.
  void Draw(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
            CommandSink& sink);

 private:
  void NameLanes(const FrameContext& context);
  void UpdateTruths(const FrameContext& context, bool all);
  void Scroll(const FrameContext& context, float view_height);
  void DrawLane(const FrameContext& context, const TimeAxis& axis, const ObjectLane& lane,
                float label_x, float y) const;
  static void DrawTruthLane(const FrameContext& context, const TimeAxis& axis,
                            const TruthLane& lane, float label_x, float y);
  void DrawScrollBar(const FrameContext& context, float x, float y0, float y1) const;

  std::shared_ptr<const std::vector<FrameEvent>> events_;  ///< What lanes_ points into.
  std::shared_ptr<const RunHistory> history_;              ///< What names are from.
  ObjectId lane_for_, seen_;     ///< The selection as of lanes_, and as last scrolled to.
  bool confirmed_only_ = false;  ///< As of lanes_.
  std::vector<ObjectLane> lanes_;
  std::shared_ptr<const TruthsView> of_truths_;  ///< What truths_ was made for:
  std::string truth_for_, truth_seen_;           ///< the selection then, and as last scrolled to,
  bool all_truths_ = false;                      ///< and whether all have lanes.
  std::vector<TruthLane> truths_;
  float scroll_ = 0;  ///< Of the first lane above the top [px].
};

}  // namespace plumbline
