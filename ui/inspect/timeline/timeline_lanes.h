// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/snapshot/commands.h"
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
/// Objects that were confirmed at some time, by birth; then `also`, then one lane for the others.
std::vector<ObjectLane> LanesOf(const std::vector<FrameEvent>& events, ObjectId also);

/// A lane for every object of the run that is shown: its life, its events, its name. Lanes that do
/// not fit scroll by the wheel or a drag over their names; a click there selects the object.
class TimelineLanes {
 public:
  /// Reads again what has changed.
  void Update(const FrameContext& context);
  std::size_t size() const { return lanes_.size(); }
  /// Between y0 and y1; names begin at label_x, left of the axis.
  void Draw(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
            CommandSink& sink);

 private:
  void NameLanes(const FrameContext& context);
  void Scroll(const FrameContext& context, float view_height);
  void DrawLane(const FrameContext& context, const TimeAxis& axis, const ObjectLane& lane,
                float label_x, float y) const;
  void DrawScrollBar(const FrameContext& context, float x, float y0, float y1) const;

  std::shared_ptr<const std::vector<FrameEvent>> events_;  ///< What lanes_ points into.
  std::shared_ptr<const RunHistory> history_;              ///< What names are from.
  ObjectId lane_for_, seen_;  ///< The selection as of lanes_, and as last scrolled to.
  std::vector<ObjectLane> lanes_;
  float scroll_ = 0;  ///< Of the first lane above the top [px].
};

}  // namespace plumbline
