// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "engine/annotation/image_check.h"
#include "engine/base/progress.h"
#include "engine/registration/constrained_fit.h"

namespace plumbline {

struct ImageRefinementOptions {
  /// What may change; kRigid is not offered: images alone would tilt what stands upright.
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
  double max_shift_m = 0.1;    ///< From the start, across and along up, > 0.
  double max_turn_deg = 8;     ///< From the start, > 0.
  int starts = 6;              ///< Best places of a coarse search that are refined, >= 1.
  int coarse_samples = 600;    ///< Places that it tries, >= 0.
  double min_visible_px = 60;  ///< Outline that the images must show at the start.
  /// By how much all cameras together may be off in the scan, standard deviations along each axis
  /// and about up, >= 0: no residual shows it, and it counts in the covariance.
  double camera_std_m = 0, camera_turn_std_deg = 0;
};

enum class RefinementStop {
  kConverged,  ///< The last step was below 0.3 mm and 0.03 degrees.
  kMoving,     ///< Out of iterations while it still moved.
  kNoBetter,   ///< No pose within reach agrees better with the images: the start is returned.
};

/// What a refinement found.
struct ImageRefinement {
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  /// As of registration: translation of the model's origin [m], then rotation vector, in the scan.
  /// From the scatter between images and between parts of the model, so that a thousand samples of
  /// one line do not count as a thousand measurements (docs/algorithms/image_refinement.md).
  PoseCovariance covariance = PoseCovariance::Zero();
  RefinementStop stop = RefinementStop::kMoving;
  double agreement_before = 0, agreement_after = 0;  ///< As of MeanAgreement.
  double offset_before_px = 0, offset_after_px = 0;  ///< Median over the images of their medians.
  int iterations = 0;
  int start = 0;    ///< The place of the coarse search that won; 0: where it began.
  int samples = 0;  ///< Of the outline, that met an edge.
  int images = 0;   ///< With any of them.

  /// What it moved: about up, across up and along up.
  double azimuth_rad = 0, horizontal_m = 0, height_m = 0;
};

/// Moves a model so that its outline lies on the edges of all images at once; upright stays
/// upright, exactly. Source: docs/algorithms/image_refinement.md. Runs on all cores; the same for
/// the same input.
///
/// @param up_in_scan  Unit vector against gravity.
/// Errors: kInvalidInput (options), kDegenerate (the images do not show the model), kCancelled.
Result<ImageRefinement> RefineByImages(const AnnotationImages& images, const OutlineModel& model,
                                       const Eigen::Isometry3d& scan_from_object,
                                       const Eigen::Vector3d& up_in_scan,
                                       const Occluders& occluders,
                                       const ImageRefinementOptions& options = {},
                                       const WorkContext& work = {});

}  // namespace plumbline
