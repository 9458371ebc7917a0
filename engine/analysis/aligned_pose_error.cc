// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/aligned_pose_error.h"

#include <Eigen/Geometry>

#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

using Gauge = Eigen::Matrix<double, 6, 4>;  ///< A shift and a turn about up, as a pose's error.
using OfGauge = Eigen::Matrix<double, 4, 6>;

constexpr double kNothing = 1e-12;     ///< Of covariances in m and rad: a micrometre.
constexpr double kTurnless_m2 = 1e-6;  ///< Poses nearer together than this have no heading.

/// A pose about the middle of all.
struct Step {
  std::size_t frame = 0;
  Eigen::Vector3d arm{0, 0, 0};  ///< From the middle to the camera.
  /// Of the error as a motion of everything about the middle, in which errors add up from pose to
  /// pose; of that, what later poses go on from.
  PoseCovariance whole, kept;
  OfGauge share;  ///< Of the error in the alignment.
};

std::vector<Step> AboutTheMiddle(std::span<const std::optional<ToldPose>> poses) {
  std::vector<Step> steps;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    Step& step = steps.emplace_back();
    step.frame = i;
    step.arm = poses[i]->cam_in_world;
    step.whole = poses[i]->covariance;
    middle += step.arm;
  }
  middle /= std::max<double>(1, static_cast<double>(steps.size()));
  for (Step& step : steps) {
    step.arm -= middle;
    step.whole = MovedBy(-step.arm, step.whole);
  }
  return steps;
}

/// What two errors have in common at most: the largest covariance of its kind that is within both.
PoseCovariance Common(const PoseCovariance& one, const PoseCovariance& other) {
  const SymmetricEigen axes = EigenOf(one);
  const Eigen::VectorXd deviations = axes.values.cwiseMax(kNothing).cwiseSqrt();
  const PoseCovariance root = axes.vectors * deviations.asDiagonal() * axes.vectors.transpose();
  const PoseCovariance inverse_root =
      axes.vectors * deviations.cwiseInverse().asDiagonal() * axes.vectors.transpose();
  // Where the first is 1 in every direction, the other is `shares` along its own axes.
  const SymmetricEigen shares = EigenOf(inverse_root * other * inverse_root);
  const PoseCovariance turned = root * shares.vectors;
  return turned * shares.values.cwiseMax(0).cwiseMin(1).asDiagonal() * turned.transpose();
}

/// Poses that a closed loop has made better than ones before: those have an error of their own,
/// which later ones do not go on from.
void SplitWhatIsKept(std::vector<Step>& steps) {
  for (std::size_t i = steps.size(); i-- > 0;) {
    const bool last = i + 1 == steps.size();
    steps[i].kept = last ? steps[i].whole : Common(steps[i].whole, steps[i + 1].kept);
  }
}

/// The alignment is the mean error of the positions and the turn about up that is left, both least
/// squares.
void ShareInAlignment(std::vector<Step>& steps, const Eigen::Vector3d& up) {
  double reach_m2 = 0;
  for (const Step& step : steps) reach_m2 += up.cross(step.arm).squaredNorm();
  for (Step& step : steps) {
    Eigen::Matrix<double, 3, 6> shift = Eigen::Matrix<double, 3, 6>::Identity();
    shift.block<3, 3>(0, 3) << 0, step.arm.z(), -step.arm.y(), -step.arm.z(), 0, step.arm.x(),
        step.arm.y(), -step.arm.x(), 0;
    step.share.topRows<3>() = shift / static_cast<double>(steps.size());
    step.share.row(3).setZero();
    if (reach_m2 > kTurnless_m2)
      step.share.row(3) = up.cross(step.arm).transpose() * shift / reach_m2;
  }
}

}  // namespace

std::vector<PoseCovariance> ErrorsAfterAlignment(std::span<const std::optional<ToldPose>> poses,
                                                 const Eigen::Vector3d& up_in_world) {
  std::vector<PoseCovariance> errors(poses.size(), PoseCovariance::Zero());
  std::vector<Step> steps = AboutTheMiddle(poses);
  SplitWhatIsKept(steps);
  ShareInAlignment(steps, up_in_world);
  // How each error goes with the alignment: a later one contains an earlier one.
  std::vector<Gauge> with_alignment(steps.size());
  OfGauge later = OfGauge::Zero();
  for (const Step& step : steps) later += step.share;
  Gauge earlier = Gauge::Zero();
  Eigen::Matrix4d alignment = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    with_alignment[i] = earlier + step.kept * later.transpose();
    earlier += step.kept * step.share.transpose();
    later -= step.share;
    alignment += step.share * with_alignment[i];
  }
  Gauge move = Gauge::Zero();
  move.topLeftCorner<3, 3>().setIdentity();
  move.block<3, 1>(3, 3) = up_in_world;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const PoseCovariance common = with_alignment[i] * move.transpose();
    const PoseCovariance left =
        steps[i].whole - common - common.transpose() + move * alignment * move.transpose();
    errors[steps[i].frame] = MovedBy(steps[i].arm, left);
  }
  return errors;
}

}  // namespace plumbline
