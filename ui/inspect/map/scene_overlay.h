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

namespace plumbline {

/// What the colours of the models in the map mean.
enum class SceneColoring { kIdentity, kState, kError, kOnTruth };
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

 private:
  const FrameContext& context_;
  Eigen::Isometry3d view_from_world_ = Eigen::Isometry3d::Identity();  ///< z ahead, y down
  Eigen::Vector2d focal_, middle_;
};

struct SceneOverlay {
  bool names = true;
  bool spread = false;  ///< Ellipsoids that hold 95 % of the belief about the centre.
  bool links = false;
  bool points = true;        ///< Of the visual-inertial filter, found up to this frame.
  bool truth_names = false;  ///< Of all true instances; the selected one has its name anyway.
};

/// Names, ellipsoids (of the camera, too, where its pose is estimated), points, relations and the
/// true instance that is selected, over the 3-D view.
void DrawSceneOverlay(const FrameContext& context, const SceneProjection& project, ImVec2 low,
                      ImVec2 high, const SceneOverlay& overlay,
                      const std::vector<ObjectRelation>& relations);

/// The true instance whose middle is nearest to a point of the picture, within some pixels; "":
/// none.
std::string TruthNear(const FrameContext& context, const SceneProjection& project, ImVec2 point);

}  // namespace plumbline
