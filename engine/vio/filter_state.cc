// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/filter_state.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "engine/base/check.h"
#include "engine/vio/point_view.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

int TotalSize(std::span<const RowRange> rows) {
  int size = 0;
  for (const RowRange& range : rows) size += range.size;
  return size;
}

/// The rows of `all` that the ranges name, below one another.
Eigen::MatrixXd RowsOf(const Eigen::MatrixXd& all, std::span<const RowRange> rows) {
  Eigen::MatrixXd chosen(TotalSize(rows), all.cols());
  int at = 0;
  for (const RowRange& range : rows) {
    chosen.middleRows(at, range.size) = all.middleRows(range.begin, range.size);
    at += range.size;
  }
  return chosen;
}

Eigen::MatrixXd ColumnsOf(const Eigen::MatrixXd& covariance, std::span<const RowRange> rows) {
  Eigen::MatrixXd chosen(covariance.rows(), TotalSize(rows));
  int at = 0;
  for (const RowRange& range : rows) {
    chosen.middleCols(at, range.size) = covariance.middleCols(range.begin, range.size);
    at += range.size;
  }
  return chosen;
}

/// jacobian * covariance * jacobian' of these rows alone.
Eigen::MatrixXd ProjectedOf(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& jacobian,
                            std::span<const RowRange> rows) {
  return jacobian * RowsOf(ColumnsOf(covariance, rows), rows) * jacobian.transpose();
}

/// Adds an error at the end: `cross` its covariance with all before, `own` its own.
void Append(const Eigen::MatrixXd& cross, const Eigen::MatrixXd& own, Eigen::MatrixXd& covariance) {
  const Eigen::Index before = covariance.rows(), added = own.rows();
  covariance.conservativeResize(before + added, before + added);
  covariance.bottomLeftCorner(added, before) = cross;
  covariance.topRightCorner(before, added) = cross.transpose();
  covariance.bottomRightCorner(added, added) = (own + own.transpose()) / 2;
}

}  // namespace

Eigen::Isometry3d Moved(const Eigen::Isometry3d& world_from_body,
                        const Eigen::Matrix<double, 6, 1>& error) {
  const Eigen::Vector3d phi = error.head<3>();
  const Eigen::Matrix3d turn = RotationExp(phi);
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.linear() = Orthonormal(turn * world_from_body.linear());
  moved.translation() = turn * world_from_body.translation() + LeftJacobian(phi) * error.tail<3>();
  return moved;
}

FilterState::FilterState(const InertialState& inertial, const Eigen::Isometry3d& body_from_cam,
                         double time_offset_s, const LensVector& lens,
                         const CalibratedMatrix& covariance)
    : inertial_(inertial),
      body_from_cam_(body_from_cam),
      time_offset_s_(time_offset_s),
      lens_(lens),
      covariance_(covariance),
      by_images_(CalibratedMatrix::Zero()) {}

const PoseClone* FilterState::FindClone(std::int64_t id) const {
  for (const PoseClone& clone : clones_) {
    if (clone.id == id) return &clone;
  }
  return nullptr;
}

void FilterState::Propagate(const Integration& integration) {
  inertial_ = integration.state;
  const int rest = size() - kInertialSize;
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_}) {
    const InertialMatrix present = covariance->topLeftCorner<kInertialSize, kInertialSize>();
    covariance->topLeftCorner<kInertialSize, kInertialSize>() =
        integration.transition * present * integration.transition.transpose();
    const Eigen::MatrixXd cross =
        integration.transition * covariance->topRightCorner(kInertialSize, rest);
    covariance->topRightCorner(kInertialSize, rest) = cross;
    covariance->bottomLeftCorner(rest, kInertialSize) = cross.transpose();
  }
  covariance_.topLeftCorner<kInertialSize, kInertialSize>() += integration.noise;
}

const PoseClone& FilterState::AddClone(std::int64_t stamp_ns,
                                       const Eigen::Vector3d& angular_velocity_in_body,
                                       double flow_px, double jitter_rad, double jitter_m) {
  const int before = size();
  const Eigen::Vector3d turn = inertial_.world_from_body * angular_velocity_in_body;
  Eigen::Matrix<double, kPoseSize, 1> by_offset;
  by_offset << turn, inertial_.velocity_in_world - turn.cross(inertial_.position_in_world);
  // A turn about the body itself: xi_p = p x phi.
  Eigen::Matrix<double, kPoseSize, 3> by_turn;
  by_turn << Eigen::Matrix3d::Identity(), Hat(inertial_.position_in_world);
  Eigen::Matrix<double, kPoseSize, kPoseSize> jitter =
      jitter_rad * jitter_rad * by_turn * by_turn.transpose();
  jitter.diagonal().tail<3>().array() += jitter_m * jitter_m;
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_}) {
    Eigen::MatrixXd added(kPoseSize, before);
    added.topRows<3>() = covariance->middleRows<3>(kPhi);
    added.bottomRows<3>() = covariance->middleRows<3>(kXiP);
    added += by_offset * covariance->row(kTimeOffset);
    Eigen::Matrix<double, kPoseSize, kPoseSize> own;
    own << added.middleCols<3>(kPhi), added.middleCols<3>(kXiP);
    own += added.col(kTimeOffset) * by_offset.transpose() + jitter;
    Append(added, own, *covariance);
  }
  clones_.push_back({next_clone_++, stamp_ns, inertial_.pose(), before, flow_px, by_offset});
  return clones_.back();
}

Eigen::MatrixXd FilterState::Projected(const Eigen::MatrixXd& jacobian,
                                       std::span<const RowRange> rows) const {
  return ProjectedOf(covariance_, jacobian, rows);
}

bool FilterState::Update(const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows,
                         const Eigen::VectorXd& residual, NoiseOf noise) {
  PLB_CHECK(jacobian.rows() == residual.size());
  const Eigen::MatrixXd cross = ColumnsOf(covariance_, rows) * jacobian.transpose();
  Eigen::MatrixXd innovation = jacobian * RowsOf(cross, rows);
  innovation.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(innovation);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::MatrixXd root = factor.matrixL().solve(cross.transpose());
  const Eigen::VectorXd error = root.transpose() * factor.matrixL().solve(residual);
  if (!error.allFinite()) return false;
  covariance_.selfadjointView<Eigen::Lower>().rankUpdate(root.transpose(), -1);
  covariance_.triangularView<Eigen::StrictlyUpper>() = covariance_.transpose();
  // (I - K H) B (I - K H)' + K K', of which the last is only there where images are measured.
  const Eigen::MatrixXd gain = factor.matrixU().solve(root).transpose();
  const Eigen::MatrixXd cross_by_images = ColumnsOf(by_images_, rows) * jacobian.transpose();
  Eigen::MatrixXd innovation_by_images = jacobian * RowsOf(cross_by_images, rows);
  if (noise == NoiseOf::kImages) innovation_by_images.diagonal().array() += 1;
  const Eigen::MatrixXd half = cross_by_images - 0.5 * gain * innovation_by_images;
  const Eigen::MatrixXd change = gain * half.transpose();
  by_images_ -= change + change.transpose();
  Retract(error);
  return true;
}

void FilterState::AddPoint(const StatePoint& point, const Eigen::MatrixXd& by_state,
                           std::span<const RowRange> rows, const Eigen::Matrix3d& by_point,
                           const Eigen::Vector3d& residual) {
  const int before = size();
  const Eigen::Matrix3d inverse = by_point.inverse();
  const Eigen::MatrixXd to_point = inverse * by_state;
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_}) {
    const Eigen::MatrixXd added = -to_point * ColumnsOf(*covariance, rows).transpose();
    const Eigen::Matrix3d own =
        ProjectedOf(*covariance, to_point, rows) + inverse * inverse.transpose();
    Append(added, own, *covariance);
  }
  points_.push_back(point);
  points_.back().row = before;
  points_.back().bearing_and_inverse_depth =
      MovedPoint(point.bearing_and_inverse_depth, inverse * residual);
}

void FilterState::ChangePoint(StatePoint& point, std::int64_t anchor, const Eigen::Vector3d& value,
                              const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows) {
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_}) {
    const Eigen::MatrixXd cross = jacobian * ColumnsOf(*covariance, rows).transpose();
    const Eigen::Matrix3d own = ProjectedOf(*covariance, jacobian, rows);
    covariance->middleRows<kPointSize>(point.row) = cross;
    covariance->middleCols<kPointSize>(point.row) = cross.transpose();
    covariance->block<kPointSize, kPointSize>(point.row, point.row) = (own + own.transpose()) / 2;
  }
  point.anchor = anchor;
  point.bearing_and_inverse_depth = value;
}

void FilterState::RemoveRows(RowRange rows) {
  const int head = rows.begin, end = rows.begin + rows.size, rest = size() - end,
            left = size() - rows.size;
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_}) {
    Eigen::MatrixXd kept(left, left);
    kept.topLeftCorner(head, head) = covariance->topLeftCorner(head, head);
    kept.topRightCorner(head, rest) = covariance->topRightCorner(head, rest);
    kept.bottomLeftCorner(rest, head) = covariance->bottomLeftCorner(rest, head);
    kept.bottomRightCorner(rest, rest) = covariance->bottomRightCorner(rest, rest);
    covariance->swap(kept);
  }
  for (PoseClone& clone : clones_) clone.row -= clone.row >= end ? rows.size : 0;
  for (StatePoint& point : points_) point.row -= point.row >= end ? rows.size : 0;
}

void FilterState::RemoveClone(std::int64_t id) {
  const auto found = std::find_if(clones_.begin(), clones_.end(),
                                  [&](const PoseClone& clone) { return clone.id == id; });
  PLB_CHECK(found != clones_.end());
  const RowRange rows{found->row, kPoseSize};
  clones_.erase(found);
  RemoveRows(rows);
}

void FilterState::RemovePoint(std::int64_t track) {
  const auto found = std::find_if(points_.begin(), points_.end(),
                                  [&](const StatePoint& point) { return point.track == track; });
  PLB_CHECK(found != points_.end());
  const RowRange rows{found->row, kPointSize};
  points_.erase(found);
  RemoveRows(rows);
}

CalibratedMatrix FilterState::InflatedCovariance(double inflation) const {
  return covariance_.topLeftCorner<kCalibratedSize, kCalibratedSize>() +
         (inflation - 1) * by_images_.topLeftCorner<kCalibratedSize, kCalibratedSize>();
}

Eigen::Matrix<double, 6, 6> FilterState::PoseCovariance(double inflation) const {
  // p = p^ + xi_p + phi x p^ to first order.
  Eigen::Matrix<double, 6, kCalibratedSize> to_pose =
      Eigen::Matrix<double, 6, kCalibratedSize>::Zero();
  to_pose.block<3, 3>(0, kXiP).setIdentity();
  to_pose.block<3, 3>(0, kPhi) = -Hat(inertial_.position_in_world);
  to_pose.block<3, 3>(3, kPhi).setIdentity();
  return to_pose * InflatedCovariance(inflation) * to_pose.transpose();
}

void FilterState::Creep(RowRange rows, double variance) {
  for (Eigen::MatrixXd* covariance : {&covariance_, &by_images_})
    covariance->diagonal().segment(rows.begin, rows.size).array() += variance;
}

bool FilterState::finite() const {
  return inertial_.position_in_world.allFinite() && inertial_.velocity_in_world.allFinite() &&
         inertial_.world_from_body.allFinite() && covariance_.allFinite() &&
         (covariance_.diagonal().array() >= 0).all();
}

void FilterState::Retract(const Eigen::VectorXd& error) {
  const Eigen::Vector3d phi = error.segment<3>(kPhi);
  const Eigen::Matrix3d turn = RotationExp(phi), jacobian = LeftJacobian(phi);
  inertial_.world_from_body = Orthonormal(turn * inertial_.world_from_body);
  inertial_.velocity_in_world =
      turn * inertial_.velocity_in_world + jacobian * error.segment<3>(kXiV);
  inertial_.position_in_world =
      turn * inertial_.position_in_world + jacobian * error.segment<3>(kXiP);
  inertial_.gyro_bias += error.segment<3>(kGyroBias);
  inertial_.accel_bias += error.segment<3>(kAccelBias);
  body_from_cam_.linear() =
      Orthonormal(RotationExp(error.segment<3>(kCamRotation)) * body_from_cam_.linear());
  body_from_cam_.translation() += error.segment<3>(kCamTranslation);
  time_offset_s_ += error(kTimeOffset);
  lens_ += error.segment<kLensSize>(kLens);
  for (PoseClone& clone : clones_)
    clone.world_from_body = Moved(clone.world_from_body, error.segment<kPoseSize>(clone.row));
  for (StatePoint& point : points_) {
    point.bearing_and_inverse_depth =
        MovedPoint(point.bearing_and_inverse_depth, error.segment<kPointSize>(point.row));
  }
}

}  // namespace plumbline
