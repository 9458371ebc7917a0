// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/joint_refinement.h"

#include <algorithm>
#include <cmath>

#include "engine/annotation/outline_equations.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

/// Beyond this a place between two results is a place where neither saw anything.
constexpr double kBetween_m = 0.05, kBetween_rad = 5 / kDegPerRad;
constexpr double kWithin_m = 0.02;  // As of AlignmentFit.
constexpr double kRoundWithin_m = 0.01;
constexpr int kFineIterations = 40;
constexpr double kClearlyBetter = 0.1;  // Of agreement, as for placements.

/// From (translation of the origin, rotation vector) to (shift of the middle, turn about up).
Eigen::Matrix<double, 4, 6> MoveFromPose(const Eigen::Isometry3d& scan_from_object,
                                         const Eigen::Vector3d& up, const Eigen::Vector3d& middle) {
  const Eigen::Vector3d lever = scan_from_object.linear() * middle;
  Eigen::Matrix<double, 4, 6> move = Eigen::Matrix<double, 4, 6>::Zero();
  move.topLeftCorner<3, 3>().setIdentity();
  move.topRightCorner<3, 3>() << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(),
      -lever.x(), 0;
  move.bottomRightCorner<1, 3>() = up.transpose();
  return move;
}

PoseCovariance PoseCovarianceOf(const Eigen::Matrix4d& of_move,
                                const Eigen::Isometry3d& scan_from_object,
                                const Eigen::Vector3d& up, const Eigen::Vector3d& middle) {
  Eigen::Matrix<double, 6, 4> pose = Eigen::Matrix<double, 6, 4>::Zero();
  pose.topLeftCorner<3, 3>().setIdentity();
  pose.topRightCorner<3, 1>() = -up.cross(scan_from_object.linear() * middle);
  pose.bottomRightCorner<3, 1>() = up;
  return pose * of_move * pose.transpose();
}

/// The coordinates in a subspace of what lies in it.
Subspace CoordinatesOf(const Eigen::MatrixXd& directions) {
  return Subspace(directions * InverseOfSymmetric(directions.transpose() * directions));
}

/// Directions that one of them does not show may be far apart.
bool AreNear(const FusedPose& fused) {
  const auto near = [](double apart, double expected, double limit) {
    return std::abs(apart) <= std::max(limit, 3 * expected);
  };
  const PoseChange& apart = fused.apart;
  const PoseDeviations& expected = fused.apart_expected;
  return near(apart.horizontal_m, expected.horizontal_m, kBetween_m) &&
         near(apart.height_m, expected.height_m, kBetween_m) &&
         near(apart.azimuth_rad, expected.azimuth_rad, kBetween_rad);
}

class JointRefiner {
 public:
  JointRefiner(const RefinementEvidence& evidence, const Eigen::Isometry3d& start,
               const Eigen::Vector3d& up, const JointRefinementOptions& options,
               const WorkContext& work)
      : evidence_(evidence), start_(start), up_(up), options_(options), work_(work) {
    if (evidence_.scan != nullptr) {
      crop_ =
          CropScan(*evidence_.scan, *evidence_.surface, start_, up_, options_.images.max_shift_m);
      is_round_ = options_.motion != FreeMotion::kRigid &&
                  evidence_.surface->SymmetryOrder(kRoundWithin_m) == 0;
    }
  }

  Result<JointRefinement> Run(const std::function<void(const ModelRefinement&)>& step) {
    JointRefinement result;
    result.before = Judged({start_, PoseCovariance::Zero()});
    if (const Status scan = RefineByScan(step, result); !scan.ok()) return scan.error();
    if (const Status images = RefineInAllImages(result); !images.ok()) return images.error();
    if (result.by_scan && result.by_images) {
      Fuse(result);
    } else if (result.by_scan) {
      result.best = RefineBy::kScan;
    } else if (result.by_images) {
      result.best = RefineBy::kImages;
    } else {
      return Error{ErrorCode::kDegenerate,
                   evidence_.scan == nullptr ? result.images_problem
                   : evidence_.images == nullptr
                       ? result.scan_problem
                       : result.scan_problem + ", and " + result.images_problem};
    }
    return result;
  }

 private:
  JudgedPose Judged(KnownPose estimate) const {
    JudgedPose judged;
    const Eigen::Isometry3d& pose = estimate.scan_from_object;
    judged.change = ChangeBetween(start_, pose, up_);
    if (evidence_.scan != nullptr && !crop_.fine.points.empty()) {
      const AlignmentFit fit = Measure(crop_, *evidence_.surface, pose, kWithin_m);
      judged.fitness = fit.fitness;
      judged.rmse_m = fit.rmse_m;
    }
    if (evidence_.images != nullptr) {
      const auto checks =
          CheckImages(*evidence_.images, *evidence_.outline, pose, evidence_.occluders);
      judged.agreement = MeanAgreement(checks);
      judged.offset_px = MedianOffset(checks);
    }
    if (evidence_.held_out != nullptr) {
      const auto checks =
          CheckImages(*evidence_.held_out, *evidence_.outline, pose, evidence_.occluders);
      const bool seen = std::any_of(checks.begin(), checks.end(),
                                    [](const ImageCheck& check) { return check.visible_px > 0; });
      if (seen) judged.agreement_held_out = MeanAgreement(checks);
    }
    judged.estimate = std::move(estimate);
    return judged;
  }

  /// What is round keeps the azimuth that it had: neither scan nor images show it, whatever their
  /// residuals say.
  KnownPose WithoutAzimuth(KnownPose known) const {
    if (!is_round_) return known;
    Eigen::Isometry3d& pose = known.scan_from_object;
    const Eigen::Vector3d axis = pose * evidence_.surface->middle();
    const UprightFrame upright(-up_);
    const double turn =
        WrapAngle(upright.Azimuth(start_.linear()) - upright.Azimuth(pose.linear()));
    pose.linear() = Eigen::AngleAxisd(turn, up_) * pose.linear();
    pose.translation() = axis - pose.linear() * evidence_.surface->middle();
    Eigen::Matrix4d about_axis = MoveFromPose(pose, up_, evidence_.surface->middle()) *
                                 known.covariance *
                                 MoveFromPose(pose, up_, evidence_.surface->middle()).transpose();
    about_axis.row(3).setZero();
    about_axis.col(3).setZero();
    about_axis(3, 3) = 1;
    known.covariance = PoseCovarianceOf(about_axis, pose, up_, evidence_.surface->middle());
    return known;
  }

  /// A failure only if it was stopped or asked for wrongly.
  Status RefineByScan(const std::function<void(const ModelRefinement&)>& step,
                      JointRefinement& result) {
    if (evidence_.scan == nullptr) return {};
    const auto refined = RefineModel(
        *evidence_.scan, *evidence_.surface, start_, up_, options_.motion,
        [&](const ModelRefinement& now) {
          if (step) step(now);
        },
        work_);
    if (!refined && refined.error().code != ErrorCode::kDegenerate) return refined.error();
    if (!refined) {
      result.scan_problem = refined.error().message;
      return {};
    }
    result.by_scan = Judged(WithoutAzimuth({refined->scan_from_model, refined->covariance}));
    result.by_scan->converged = refined->converged;
    return {};
  }

  Status RefineInAllImages(JointRefinement& result) {
    if (evidence_.images == nullptr) return {};
    ImageRefinementOptions options = options_.images;
    options.motion = options_.motion;
    const auto refined = RefineByImages(*evidence_.images, *evidence_.outline, start_, up_,
                                        evidence_.occluders, options, work_);
    if (!refined && refined.error().code != ErrorCode::kDegenerate) return refined.error();
    if (!refined || refined->stop == RefinementStop::kNoBetter) {
      result.images_problem =
          refined ? "no place nearby agrees better with the images" : refined.error().message;
      return {};
    }
    result.by_images = Judged(WithoutAzimuth({refined->scan_from_object, refined->covariance}));
    result.by_images->converged = refined->stop == RefinementStop::kConverged;
    return {};
  }

  void Fuse(JointRefinement& result) const {
    const Eigen::Vector3d middle = evidence_.outline->center().cast<double>();
    FusedPose fused = FusePoses(result.by_scan->estimate, result.by_images->estimate, up_,
                                options_.motion, middle);
    result.apart = fused.apart;
    result.apart_expected = fused.apart_expected;
    result.conflict = fused.conflict;
    if (!AreNear(fused)) {
      // The scan may have its own minimum where the images put the object.
      ConstrainedPose near(result.by_images->estimate.scan_from_object, up_, options_.motion);
      const FineAlignment fine =
          AlignFinely(crop_, *evidence_.surface, IcpResidual::kPointToPlane, kFineIterations, near);
      fused = FusePoses(WithoutAzimuth({near.scan_from_model(), fine.covariance}),
                        result.by_images->estimate, up_, options_.motion, middle);
    }
    result.together = Judged(fused.together);
    result.together->converged = result.by_scan->converged && result.by_images->converged;
    result.best = RefineBy::kBoth;
    if (!result.Contradict()) return;
    const auto held_out = [](const JudgedPose& pose) {
      return pose.agreement_held_out.value_or(pose.agreement);
    };
    double best = held_out(*result.together) + kClearlyBetter;
    for (const RefineBy by : {RefineBy::kScan, RefineBy::kImages}) {
      const double alone = held_out(*result.Of(by));
      if (alone <= best) continue;
      best = alone;
      result.best = by;
    }
  }

  const RefinementEvidence& evidence_;
  const Eigen::Isometry3d start_;
  const Eigen::Vector3d up_;
  const JointRefinementOptions& options_;
  const WorkContext& work_;
  AlignmentCrop crop_;
  bool is_round_ = false;
};

}  // namespace

FusedPose FusePoses(const KnownPose& first, const KnownPose& second,
                    const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                    const Eigen::Vector3d& middle_in_object) {
  const Eigen::Isometry3d &a = first.scan_from_object, &b = second.scan_from_object;
  const UprightMotion moves(a, up_in_scan, middle_in_object);
  const Subspace free = moves.Free(motion);
  const Subspace coordinates = CoordinatesOf(free.directions());
  const auto covariance_of = [&](const KnownPose& estimate) -> Eigen::MatrixXd {
    const auto move = MoveFromPose(estimate.scan_from_object, up_in_scan, middle_in_object);
    return coordinates.RestrictForm(move * estimate.covariance * move.transpose());
  };
  FusedPose fused;
  fused.apart = ChangeBetween(a, b, up_in_scan);
  PoseMove between;
  between << b * middle_in_object - a * middle_in_object, fused.apart.azimuth_rad;
  const Eigen::VectorXd difference = coordinates.RestrictGradient(between);
  const Eigen::MatrixXd of_first = covariance_of(first), of_second = covariance_of(second);
  const Eigen::MatrixXd of_difference = of_first + of_second;
  // V1 (V1 + V2)^-1 of the way from the first to the second.
  const Eigen::VectorXd pull = SolveSymmetric(of_difference, difference);
  const PoseMove move = free.ExpandStep(of_first * pull);
  const double squared = difference.dot(pull);
  fused.conflict = std::sqrt(std::max(1.0, squared / static_cast<double>(free.size())));
  const Eigen::MatrixXd of_both =
      of_first * InverseOfSymmetric(of_difference) * of_second * fused.conflict * fused.conflict;
  fused.together.scan_from_object = moves.At(move);
  fused.together.covariance =
      PoseCovarianceOf(free.ExpandCovariance(0.5 * (of_both + of_both.transpose())),
                       fused.together.scan_from_object, up_in_scan, middle_in_object);
  fused.apart_expected = DeviationsOf(
      PoseCovarianceOf(free.ExpandCovariance(of_difference), a, up_in_scan, middle_in_object),
      up_in_scan);
  return fused;
}

const JudgedPose* JointRefinement::Of(RefineBy by) const {
  const std::optional<JudgedPose>& found = by == RefineBy::kScan     ? by_scan
                                           : by == RefineBy::kImages ? by_images
                                                                     : together;
  return found ? &*found : nullptr;
}

Result<JointRefinement> RefineJointly(const RefinementEvidence& evidence,
                                      const Eigen::Isometry3d& scan_from_object,
                                      const Eigen::Vector3d& up_in_scan,
                                      const JointRefinementOptions& options,
                                      const std::function<void(const ModelRefinement&)>& step,
                                      const WorkContext& work) {
  if (evidence.scan == nullptr && evidence.images == nullptr) {
    return Error{ErrorCode::kDegenerate,
                 "there is neither a scan nor an image to refine it by; open one of them"};
  }
  return JointRefiner(evidence, scan_from_object, up_in_scan, options, work).Run(step);
}

}  // namespace plumbline
