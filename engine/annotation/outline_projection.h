// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/annotation/occluders.h"
#include "engine/annotation/outline_model.h"
#include "engine/sensor/camera.h"

namespace plumbline {

enum class OutlineKind { kContour, kCrease };

/// A piece of outline in one image, all of it visible or all of it hidden.
struct OutlinePolyline {
  OutlineKind kind = OutlineKind::kContour;
  bool hidden = false;                  ///< By the scan or another object.
  std::vector<Eigen::Vector2f> pixels;  ///< Two or more.
};

/// A point of the outline to be compared with the image.
struct OutlineSample {
  Eigen::Vector2f pixel{0, 0};
  Eigen::Vector2f normal{0, 0};        ///< Unit, across the line; of a contour outwards.
  Eigen::Vector3f in_object{0, 0, 0};  ///< [m]
  float length_px = 0;                 ///< Of the line that it stands for.
  OutlineKind kind = OutlineKind::kContour;
  bool hidden = false;
};

struct ModelOutline {
  std::vector<OutlinePolyline> lines;
  std::vector<OutlineSample> samples;
};

struct OutlineOptions {
  double step_px = 4;  ///< Between samples along a line, > 0.
  /// A step of depth that makes a contour [m]; less for models with a radius under 13 cm.
  double contour_step_m = 0.04;
  double occlusion_margin_m = 0.03;  ///< What is not nearer by this hides nothing.
  /// Scanned surface this near to the posed model is taken for the object itself [m].
  double own_scan_m = 0.06;
};

/// The lines of a posed model in an image: where its surface ends or folds away from the camera
/// (occluding contour), and its creases. What the model hides itself and what lies outside the
/// image is left out. Exact on the mesh; on one core a model of 20 000 faces takes a few
/// milliseconds.
ModelOutline ProjectOutline(const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
                            const Eigen::Isometry3d& scan_from_cam, const PinholeCamera& camera,
                            const Occluders& occluders, const OutlineOptions& options = {});

}  // namespace plumbline
