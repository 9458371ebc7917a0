// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/image_refinement.h"
#include "engine/annotation/occluders.h"
#include "engine/annotation/outline_model.h"
#include "engine/annotation/refine_by.h"
#include "engine/base/progress.h"
#include "engine/registration/model_refinement.h"
#include "engine/registration/model_surface.h"
#include "engine/registration/scan_target.h"

namespace plumbline {

/// A pose and how well it is known, in the scan.
struct KnownPose {
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// Two estimates that know nothing of each other, as one.
struct FusedPose {
  KnownPose together;
  PoseChange apart;               ///< From the first to the second.
  PoseDeviations apart_expected;  ///< Standard deviations of `apart`, by both covariances.
  /// By how much more than expected they are apart, at least 1 (Birge's ratio, of all free moves);
  /// the covariance is widened by its square.
  double conflict = 1;
};
/// From here on two estimates contradict each other: of four free moves, 5 % of those that do not.
inline constexpr double kContradiction = 1.54;

/// The pose of greatest likelihood under both covariances. Both have the same tilt and differ only
/// by what `motion` leaves free. Source: docs/algorithms/image_refinement.md.
///
/// @param middle_in_object  Where shift and turn are told apart: the middle of the model [m].
FusedPose FusePoses(const KnownPose& first, const KnownPose& second,
                    const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                    const Eigen::Vector3d& middle_in_object);

/// What an object's pose is refined by. Without `scan` or without `images` (null) the other decides
/// alone.
struct RefinementEvidence {
  const ScanTarget* scan = nullptr;
  const ModelSurface* surface = nullptr;  ///< Not null where `scan` is not.
  const AnnotationImages* images = nullptr;
  const AnnotationImages* held_out = nullptr;  ///< Only for judging; may be null.
  const OutlineModel* outline = nullptr;       ///< Not null where there are images.
  Occluders occluders;
};

/// A pose and how well scan and images agree with it.
struct JudgedPose {
  KnownPose estimate;
  bool converged = false;
  PoseChange change;                         ///< From the start.
  double fitness = 0, rmse_m = 0;            ///< As of AlignmentFit; 0 without a scan.
  double agreement = 0, offset_px = 0;       ///< In the images that were refined on.
  std::optional<double> agreement_held_out;  ///< In the others, where they show the object.
};

/// What was found. `scan` and `images` are each on its own.
struct JointRefinement {
  JudgedPose before;
  std::optional<JudgedPose> by_scan, by_images, together;
  std::string scan_problem, images_problem;  ///< Why there is none.
  /// Where there are both.
  PoseChange apart;
  PoseDeviations apart_expected;
  double conflict = 1;
  bool Contradict() const { return conflict > kContradiction; }

  /// Both together; where they contradict each other, what agrees best with the images held out.
  RefineBy best = RefineBy::kBoth;
  /// Null if that found nothing.
  const JudgedPose* Of(RefineBy by) const;
};

/// By how much the cameras of a sequence are usually off in a scan: 1 cm and 0.3 degrees, what
/// smooth distortion makes of it in rooms recorded by hand (docs/algorithms/image_refinement.md).
inline constexpr double kUsualCameraStd_m = 0.01, kUsualCameraTurnStd_deg = 0.3;

struct JointRefinementOptions {
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
  ImageRefinementOptions images;
};

/// Refines by the scan and by the images, from the same start, and fuses both by their covariances.
/// A problem of one of them is no error. Errors: kDegenerate (neither shows the object),
/// kInvalidInput (options), kCancelled.
///
/// @param step  Is told every iteration on the scan.
Result<JointRefinement> RefineJointly(const RefinementEvidence& evidence,
                                      const Eigen::Isometry3d& scan_from_object,
                                      const Eigen::Vector3d& up_in_scan,
                                      const JointRefinementOptions& options = {},
                                      const std::function<void(const ModelRefinement&)>& step = {},
                                      const WorkContext& work = {});

}  // namespace plumbline
