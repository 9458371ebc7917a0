// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

namespace plumbline {
namespace {

constexpr std::int64_t kMaxReferenceStepNs = 200'000'000;

struct MatchedPose {
  std::int64_t stamp_ns;
  Eigen::Isometry3d estimate, reference;
  const Eigen::Matrix<double, 6, 6>* covariance;
};

std::optional<Eigen::Isometry3d> ReferenceAt(std::span<const TimedPose> reference,
                                             std::int64_t stamp_ns) {
  const auto after = std::lower_bound(
      reference.begin(), reference.end(), stamp_ns,
      [](const TimedPose& pose, std::int64_t stamp) { return pose.stamp_ns < stamp; });
  if (after == reference.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->world_from_sensor;
  if (after == reference.begin()) return std::nullopt;
  const TimedPose& before = *std::prev(after);
  const std::int64_t step = after->stamp_ns - before.stamp_ns;
  if (step > kMaxReferenceStepNs) return std::nullopt;
  const double share = static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(step);
  const Eigen::Quaterniond from(before.world_from_sensor.linear()),
      to(after->world_from_sensor.linear());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = from.slerp(share, to).toRotationMatrix();
  pose.translation() = (1 - share) * before.world_from_sensor.translation() +
                       share * after->world_from_sensor.translation();
  return pose;
}

double Angle(const Eigen::Matrix3d& rotation) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(rotation)).angle();
}

/// The points of both, one column each.
std::pair<Eigen::Matrix3Xd, Eigen::Matrix3Xd> Places(const std::vector<MatchedPose>& matched) {
  Eigen::Matrix3Xd estimate(3, matched.size()), reference(3, matched.size());
  for (std::size_t i = 0; i < matched.size(); ++i) {
    estimate.col(static_cast<Eigen::Index>(i)) = matched[i].estimate.translation();
    reference.col(static_cast<Eigen::Index>(i)) = matched[i].reference.translation();
  }
  return {estimate, reference};
}

/// The turn about z and the translation with the least squared distance.
Eigen::Matrix4d AlignYaw(const Eigen::Matrix3Xd& estimate, const Eigen::Matrix3Xd& reference) {
  const Eigen::Vector3d e0 = estimate.rowwise().mean(), r0 = reference.rowwise().mean();
  const Eigen::Matrix3Xd e = estimate.colwise() - e0, r = reference.colwise() - r0;
  const double sine = e.row(0).dot(r.row(1)) - e.row(1).dot(r.row(0));
  const double cosine = e.row(0).dot(r.row(0)) + e.row(1).dot(r.row(1));
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() =
      Eigen::AngleAxisd(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  result.translation() = r0 - result.linear() * e0;
  return result.matrix();
}

Eigen::Matrix4d Align(const std::vector<MatchedPose>& matched, TrajectoryAlignment kind) {
  const auto [estimate, reference] = Places(matched);
  switch (kind) {
    case TrajectoryAlignment::kNone:
      break;
    case TrajectoryAlignment::kYaw:
      return AlignYaw(estimate, reference);
    case TrajectoryAlignment::kSe3:
      return Eigen::umeyama(estimate, reference, false);
    case TrajectoryAlignment::kSim3:
      return Eigen::umeyama(estimate, reference, true);
  }
  return Eigen::Matrix4d::Identity();
}

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Errors of the motion from each pose to the first later one that is `span` away on `axis`.
RelativeError Relative(const std::vector<MatchedPose>& matched, const std::vector<double>& axis,
                       double span) {
  std::vector<double> translation, rotation;
  std::size_t j = 0;
  for (std::size_t i = 0; i < matched.size(); ++i) {
    // Half a microsecond or micrometre: stamps and places are rounded.
    while (j < matched.size() && axis[j] - axis[i] < span - 5e-7) ++j;
    if (j == matched.size()) break;
    const Eigen::Isometry3d error =
        (matched[i].reference.inverse() * matched[j].reference).inverse() *
        (matched[i].estimate.inverse() * matched[j].estimate);
    translation.push_back(error.translation().norm());
    rotation.push_back(Angle(error.linear()));
  }
  return {span, static_cast<int>(translation.size()), RootMeanSquare(translation),
          Median(translation), RootMeanSquare(rotation)};
}

void MeasureNees(const std::vector<MatchedPose>& matched, TrajectoryErrors& errors) {
  // The reference moved onto the first estimate in heading and position.
  const Eigen::Isometry3d& r0 = matched.front().reference;
  const Eigen::Isometry3d& e0 = matched.front().estimate;
  const Eigen::Matrix3d turn = e0.linear() * r0.linear().transpose();
  const double yaw = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  move.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  move.translation() = e0.translation() - move.linear() * r0.translation();
  double sum = 0;
  for (const MatchedPose& pose : matched) {
    if (pose.covariance == nullptr) continue;
    const Eigen::Isometry3d reference = move * pose.reference;
    const Eigen::AngleAxisd off{
        Eigen::Quaterniond(reference.linear() * pose.estimate.linear().transpose())};
    Eigen::Matrix<double, 6, 1> error;
    error << reference.translation() - pose.estimate.translation(), off.angle() * off.axis();
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(*pose.covariance);
    if (factor.info() != Eigen::Success) continue;
    sum += error.dot(factor.solve(error));
    ++errors.nees_poses;
  }
  if (errors.nees_poses > 0) errors.nees = sum / errors.nees_poses;
}

}  // namespace

Result<TrajectoryErrors> CompareTrajectories(std::span<const TimedPose> estimate,
                                             std::span<const TimedPose> reference,
                                             const TrajectoryErrorOptions& options) {
  std::vector<MatchedPose> matched;
  for (const TimedPose& pose : estimate) {
    const auto truth = ReferenceAt(reference, pose.stamp_ns);
    if (truth)
      matched.push_back({pose.stamp_ns, pose.world_from_sensor, *truth,
                         pose.covariance ? &*pose.covariance : nullptr});
  }
  if (matched.size() < 3) {
    return Error{ErrorCode::kDegenerate,
                 "only " + std::to_string(matched.size()) +
                     " poses of the trajectory have a reference at their time; are both on the "
                     "same clock?"};
  }
  TrajectoryErrors errors;
  errors.matched = static_cast<int>(matched.size());
  errors.reference_from_estimate = Align(matched, options.align);
  errors.scale =
      std::cbrt(Align(matched, TrajectoryAlignment::kSim3).topLeftCorner<3, 3>().determinant());
  const double aligned_scale =
      std::cbrt(errors.reference_from_estimate.topLeftCorner<3, 3>().determinant());
  const Eigen::Matrix3d turn = errors.reference_from_estimate.topLeftCorner<3, 3>() / aligned_scale;
  std::vector<double> distances, angles, tilts, seconds, metres;
  for (const MatchedPose& pose : matched) {
    const Eigen::Vector3d place = aligned_scale * (turn * pose.estimate.translation()) +
                                  errors.reference_from_estimate.topRightCorner<3, 1>();
    distances.push_back((place - pose.reference.translation()).norm());
    angles.push_back(Angle(pose.reference.linear().transpose() * turn * pose.estimate.linear()));
    const Eigen::Vector3d down = pose.estimate.linear().row(2).transpose(),
                          true_down = pose.reference.linear().row(2).transpose();
    tilts.push_back(std::atan2(down.cross(true_down).norm(), down.dot(true_down)));
    seconds.push_back(static_cast<double>(pose.stamp_ns - matched.front().stamp_ns) * 1e-9);
    if (!metres.empty()) {
      const MatchedPose& last = *(&pose - 1);
      errors.path_m += (pose.reference.translation() - last.reference.translation()).norm();
    }
    metres.push_back(errors.path_m);
  }
  errors.ate_m = RootMeanSquare(distances);
  errors.ate_max_m = *std::max_element(distances.begin(), distances.end());
  errors.ate_rad = RootMeanSquare(angles);
  errors.tilt_rad = RootMeanSquare(tilts);
  for (const double span : options.spans_s)
    errors.by_time.push_back(Relative(matched, seconds, span));
  for (const double span : options.lengths_m)
    errors.by_length.push_back(Relative(matched, metres, span));
  MeasureNees(matched, errors);
  return errors;
}

}  // namespace plumbline
