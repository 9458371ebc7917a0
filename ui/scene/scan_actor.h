// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkActor.h>
#include <vtkSmartPointer.h>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

/// A scan, dimmed so that the objects stand out: as a surface if it has triangles, else as points.
/// A surface that turns its front to the cameras of the sequence, as a room's does, is not drawn
/// from behind: the view looks in through the walls.
vtkSmartPointer<vtkActor> ScanActor(const TriangleMesh& scan, const SequenceView& sequence);

}  // namespace plumbline
