// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/occluders.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// A box with two triangles to a side; its foot in the origin.
TriangleMesh BoxMesh(const Eigen::Vector3f& size);
/// Boxes that look different from every side: a seat with a back and an arm, 0.9 m high.
TriangleMesh SeatMesh();

/// A camera at `eye` [m] that looks at `target`, with the image's down as near to -z as can be.
Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// 640x480, 60 degrees wide.
PinholeCamera TestCamera();

/// Frames without pixels on an arc around the origin. Their images are a pattern.
std::shared_ptr<const Sequence> ArcSequence(int frames, double arc_deg, double distance_m);

/// The edges that a posed model leaves in an image: its visible outline, drawn.
AnnotationImage DrawnImage(int frame, const OutlineModel& model,
                           const Eigen::Isometry3d& scan_from_object,
                           const Eigen::Isometry3d& scan_from_cam, const Occluders& occluders = {});

}  // namespace plumbline
