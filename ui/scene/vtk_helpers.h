// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <imgui.h>
#include <vtkActor.h>
#include <vtkImageData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Triangles with normals that break at sharp edges, and the mesh's colours as scalars, if any.
vtkSmartPointer<vtkPolyData> SurfaceOf(const TriangleMesh& mesh);
/// Sharp edges and borders as lines.
vtkSmartPointer<vtkPolyData> SharpEdgesOf(vtkPolyData* surface);
vtkSmartPointer<vtkPolyData> PolylineOf(const std::vector<Eigen::Vector3d>& points);
/// Consecutive pairs of points.
vtkSmartPointer<vtkPolyData> SegmentsOf(const std::vector<Eigen::Vector3d>& points);

vtkSmartPointer<vtkActor> ActorOf(vtkPolyData* data, ImU32 color);
/// Unlit lines of `width` pixels.
vtkSmartPointer<vtkActor> LineActorOf(vtkPolyData* data, ImU32 color, double width);
void SetData(vtkActor& actor, vtkPolyData* data);
/// The colours of its surface, where that has some, instead of the actor's one.
void ShowOwnColors(vtkActor& actor, bool show);
void SetColor(vtkActor& actor, ImU32 color);
void SetPose(vtkActor& actor, const Eigen::Isometry3d& world_from_actor, double scale = 1);
/// RGB, origin at the lower left; at most `max_width` wide.
vtkSmartPointer<vtkImageData> TextureImage(const cv::Mat& bgr, int max_width);

}  // namespace plumbline
