// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <vtkActor.h>
#include <vtkSmartPointer.h>
#include <Eigen/Core>

#include "engine/geometry/mesh.h"
#include "ui/framework/annotate_view.h"

namespace plumbline {

/// Which side of a scan's triangles was seen from `eye`: +1 the front, -1 the back, 0 no clear
/// majority.
int SideTowards(const TriangleMesh& scan, const Eigen::Vector3d& eye);

/// RGB of each vertex, dimmed so that objects stand out. Without a coloring: as the map has it,
/// grey where the scan has no colours. By height: from dark to bright between its lowest and its
/// highest hundredth. By normal: walls red and green by their direction, floors blue; where a cloud
/// has no normals, by height.
std::vector<std::array<std::uint8_t, 3>> ScanColors(const TriangleMesh& scan,
                                                    const Eigen::Vector3d& up_in_scan,
                                                    std::optional<ScanColoring> coloring);
/// What a scan can be coloured by.
bool HasColors(const TriangleMesh& scan);
bool HasNormals(const TriangleMesh& scan);

/// Gives the actor of a scan other colours.
void ColorScan(vtkActor& actor, const std::vector<std::array<std::uint8_t, 3>>& colors);

/// A scan, dimmed so that the objects stand out: as a surface if it has triangles, else as points.
/// A surface that turns one side to the `eye`, as a room's does, is not drawn from the other: the
/// view looks in through the walls.
/// @param eye  About where the scan was seen from, in its frame; nothing: not known.
vtkSmartPointer<vtkActor> ScanActor(const TriangleMesh& scan, const Eigen::Vector3d& up_in_scan,
                                    const std::optional<Eigen::Vector3d>& eye);

}  // namespace plumbline
