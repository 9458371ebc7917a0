// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <vtkActor.h>
#include <vtkSmartPointer.h>
#include <Eigen/Core>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Which side of a scan's triangles was seen from `eye`: +1 the front, -1 the back, 0 no clear
/// majority.
int SideTowards(const TriangleMesh& scan, const Eigen::Vector3d& eye);

/// A scan, dimmed so that the objects stand out: as a surface if it has triangles, else as points.
/// A surface that turns one side to the `eye`, as a room's does, is not drawn from the other: the
/// view looks in through the walls.
/// @param eye  About where the scan was seen from, in its frame; nothing: not known.
vtkSmartPointer<vtkActor> ScanActor(const TriangleMesh& scan, const Eigen::Vector3d& up_in_scan,
                                    const std::optional<Eigen::Vector3d>& eye);

}  // namespace plumbline
