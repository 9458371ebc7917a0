// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <imgui.h>

#include "engine/snapshot/object_relation.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/scene_surface.h"
#include "ui/framework/sight_line.h"

namespace plumbline {

/// What the colours of the models in the map mean.
enum class SceneColoring { kIdentity, kOwn, kState, kError, kOnTruth };
const char* ColoringName(SceneColoring coloring);
/// How the objects of this frame are drawn.
/// @param opacity  Of confirmed ones; tentative ones are the fainter, the less likely they are
/// there.
std::vector<SceneObject> SceneObjectsOf(const FrameContext& context, SceneColoring coloring,
                                        double opacity);

/// Points of the world on the picture of the 3-D view.
class SceneProjection {
 public:
  SceneProjection(const FrameContext& context, const SceneCamera& camera, ImVec2 low, ImVec2 high);
  std::optional<ImVec2> operator()(const Eigen::Vector3d& point_in_world) const;
  /// Through a point of the picture, in world.
  SightLine Sight(ImVec2 point) const;

 private:
  const FrameContext& context_;
  Eigen::Isometry3d view_from_world_ = Eigen::Isometry3d::Identity();  ///< z ahead, y down
  Eigen::Vector2d focal_, middle_;
  bool parallel_ = false;  ///< `focal_` is then pixels a metre.
};

struct SceneOverlay {
  bool names = true;
  bool spread = false;  ///< Ellipsoids that hold 95 % of the belief about the centre.
  bool links = false;
  bool points = true;           ///< Of the visual-inertial filter, found up to this frame.
  bool truth_names = false;     ///< Of all true instances; the selected one has its name anyway.
  bool parallel = false;        ///< The view has no perspective.
  bool tape = false;            ///< Clicks measure.
  std::optional<ClipBox> clip;  ///< Nothing outside of it has a name.
};

/// Two points in world; the tape lies between them.
struct Tape {
  std::vector<Eigen::Vector3d> points;  ///< Two at most.

  /// A third point begins anew.
  void Add(const Eigen::Vector3d& point_in_world);
};

/// What a tape between two points says: "1.414 m", and below how far that is across and up.
std::string TapeReading(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& up_in_world);

/// The tape over the 3-D view.
void DrawTape(const FrameContext& context, const SceneProjection& project, ImVec2 low, ImVec2 high,
              const Tape& tape);

/// Names, ellipsoids (of the camera, too, where its pose is estimated), points, relations and the
/// true instance that is selected, over the 3-D view.
void DrawSceneOverlay(const FrameContext& context, const SceneProjection& project, ImVec2 low,
                      ImVec2 high, const SceneOverlay& overlay,
                      const std::vector<ObjectRelation>& relations);

/// The true instance whose middle is nearest to a point of the picture, within some pixels; "":
/// none.
std::string TruthNear(const FrameContext& context, const SceneProjection& project, ImVec2 point);

}  // namespace plumbline
