// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <imgui.h>
#include <Eigen/Core>

#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

// What handles in the 3-D view of the Annotate workspace are made with. `low`: its top left on the
// screen.

/// Nothing behind the eye.
std::optional<ImVec2> ScreenOf(const AnnotateSurface& scene, ImVec2 low,
                               const Eigen::Vector3d& in_level);

/// From a point to a line of pieces, in pixels; far where there is no line.
double DistanceTo(const std::vector<ImVec2>& line, ImVec2 point);
double DistanceToLine(ImVec2 point, ImVec2 a, ImVec2 b);

/// Where a line of sight meets a plane; nothing where that is seen nearly edge on, or behind.
std::optional<Eigen::Vector3d> OnPlane(const SightLine& sight, const Eigen::Vector3d& point,
                                       const Eigen::Vector3d& normal);

/// So that scripts and tests find what is drawn and is no widget.
void LogRect(const FrameContext& context, std::string name, ImVec2 middle, float half_size);

}  // namespace plumbline
