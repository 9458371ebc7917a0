// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/constrained_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/SVD>

#include "engine/base/check.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr double kUnseenInformation = 1;  // Of a direction that the pairs do not show.

struct WeightedMeans {
  Eigen::Vector3d model = Eigen::Vector3d::Zero(), scan = Eigen::Vector3d::Zero();
  double weight = 0;
};

WeightedMeans Means(std::span<const PointPair> pairs) {
  WeightedMeans means;
  for (const PointPair& pair : pairs) {
    means.model += pair.weight * pair.in_model;
    means.scan += pair.weight * pair.in_scan;
    means.weight += pair.weight;
  }
  if (means.weight > 0) {
    means.model /= means.weight;
    means.scan /= means.weight;
  }
  return means;
}

/// The rotation that brings `model` closest to `scan` about their means (Kabsch).
std::optional<Eigen::Matrix3d> FitRotation(std::span<const PointPair> pairs,
                                           const WeightedMeans& means) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    covariance +=
        pair.weight * (pair.in_scan - means.scan) * (pair.in_model - means.model).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // All on one line: the turn about it is free.
  if (!(svd.singularValues()[1] > 1e-9 * svd.singularValues()[0])) return std::nullopt;
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

Eigen::Matrix<double, 6, 1> Row(const PointPair& pair, const Eigen::Isometry3d& scan_from_model) {
  const Eigen::Vector3d lever = scan_from_model.linear() * pair.in_model;
  Eigen::Matrix<double, 6, 1> row;
  row << pair.normal_in_scan, lever.cross(pair.normal_in_scan);
  return row;
}

}  // namespace

FreeMotion MotionWith(int degrees_of_freedom) {
  switch (degrees_of_freedom) {
    case 1:
      return FreeMotion::kAzimuth;
    case 3:
      return FreeMotion::kAzimuthAndHorizontal;
    case 6:
      return FreeMotion::kRigid;
    default:
      return FreeMotion::kAzimuthAndTranslation;
  }
}

int DegreesOfFreedom(FreeMotion motion) {
  switch (motion) {
    case FreeMotion::kAzimuth:
      return 1;
    case FreeMotion::kAzimuthAndHorizontal:
      return 3;
    case FreeMotion::kAzimuthAndTranslation:
      return 4;
    case FreeMotion::kRigid:
      return 6;
  }
  return 0;
}

ConstrainedPose::ConstrainedPose(const Eigen::Isometry3d& start_scan_from_model,
                                 const Eigen::Vector3d& up_in_scan, FreeMotion motion)
    : scan_from_model_(start_scan_from_model),
      start_rotation_(start_scan_from_model.linear()),
      up_(up_in_scan),
      motion_(motion) {
  PLB_CHECK(std::abs(up_.norm() - 1) < 1e-6) << "up is no unit vector: " << up_.transpose();
  up_.normalize();
}

void ConstrainedPose::SetAngle(double angle_rad) {
  angle_rad_ = WrapAngle(angle_rad);
  scan_from_model_.linear() = Eigen::AngleAxisd(angle_rad_, up_) * start_rotation_;
}

Status ConstrainedPose::FitPoints(std::span<const PointPair> pairs) {
  const Error unseen{ErrorCode::kDegenerate,
                     "the pairs do not show how the model is turned; give pairs that are spread "
                     "out horizontally"};
  const WeightedMeans means = Means(pairs);
  if (!(means.weight > 0)) return unseen;
  if (motion_ == FreeMotion::kRigid) {
    const std::optional<Eigen::Matrix3d> rotation = FitRotation(pairs, means);
    if (!rotation) return unseen;
    scan_from_model_.linear() = *rotation;
    scan_from_model_.translation() = means.scan - *rotation * means.model;
    return {};
  }
  // With the azimuth alone the turn is about the model's origin, else about the means.
  const bool moves = motion_ != FreeMotion::kAzimuth;
  const Eigen::Vector3d center_in_model = moves ? means.model : Eigen::Vector3d::Zero();
  const Eigen::Vector3d center_in_scan = moves ? means.scan : scan_from_model_.translation();
  double sine = 0, cosine = 0, spread = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d p = start_rotation_ * (pair.in_model - center_in_model);
    const Eigen::Vector3d q = pair.in_scan - center_in_scan;
    sine += pair.weight * up_.dot(p.cross(q));
    cosine += pair.weight * (p.dot(q) - up_.dot(p) * up_.dot(q));
    spread += pair.weight * (p.squaredNorm() + q.squaredNorm());
  }
  if (!(std::hypot(sine, cosine) > 1e-12 * spread)) return unseen;
  SetAngle(std::atan2(sine, cosine));
  if (!moves) return {};
  const Eigen::Vector3d moved = means.scan - scan_from_model_.linear() * means.model;
  Eigen::Vector3d change = moved - scan_from_model_.translation();
  if (motion_ == FreeMotion::kAzimuthAndHorizontal) change -= up_.dot(change) * up_;
  scan_from_model_.translation() += change;
  return {};
}

Subspace ConstrainedPose::FreeDirections() const {
  const int count = DegreesOfFreedom(motion_);
  Eigen::MatrixXd free = Eigen::MatrixXd::Zero(6, count);
  switch (motion_) {
    case FreeMotion::kRigid:
      free.setIdentity();
      break;
    case FreeMotion::kAzimuthAndTranslation:
      free.topLeftCorner<3, 3>().setIdentity();
      break;
    case FreeMotion::kAzimuthAndHorizontal:
      free.col(0).head<3>() = up_.unitOrthogonal();
      free.col(1).head<3>() = up_.cross(Eigen::Vector3d(free.col(0).head<3>()));
      break;
    case FreeMotion::kAzimuth:
      break;
  }
  if (motion_ != FreeMotion::kRigid) free.col(count - 1).tail<3>() = up_;
  return Subspace(std::move(free));
}

double ConstrainedPose::StepPlanes(std::span<const PointPair> pairs) {
  Normal information = Normal::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Matrix<double, 6, 1> row = Row(pair, scan_from_model_);
    const double residual =
        pair.normal_in_scan.dot(scan_from_model_ * pair.in_model - pair.in_scan);
    information.noalias() += pair.weight * row * row.transpose();
    gradient += pair.weight * residual * row;
  }
  const Subspace free = FreeDirections();
  Eigen::MatrixXd reduced = free.RestrictForm(information);
  // What the surface does not show (sliding along a lone table top) stays put.
  reduced.diagonal().array() += 1e-9 * reduced.trace() + 1e-12;
  const Eigen::VectorXd step = -SolveSymmetric(reduced, free.RestrictGradient(gradient));
  const Eigen::VectorXd full = free.ExpandStep(step);
  scan_from_model_.translation() += full.head<3>();
  const Eigen::Vector3d turn = full.tail<3>();
  if (motion_ == FreeMotion::kRigid) {
    const double angle = turn.norm();
    if (angle > 0) {
      const Eigen::Quaterniond turned =
          Eigen::AngleAxisd(angle, turn / angle) * Eigen::Quaterniond(scan_from_model_.linear());
      scan_from_model_.linear() = turned.normalized().toRotationMatrix();
    }
  } else {
    SetAngle(angle_rad_ + step[step.size() - 1]);
  }
  return std::max(full.head<3>().norm(), turn.norm());
}

PoseCovariance ConstrainedPose::PlaneCovariance(std::span<const PointPair> pairs,
                                                double sigma_m) const {
  Normal information = Normal::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Matrix<double, 6, 1> row = Row(pair, scan_from_model_);
    information.noalias() += pair.weight * row * row.transpose();
  }
  const Subspace free = FreeDirections();
  // Exact data still has the resolution of its numbers.
  const double variance = std::max(sigma_m * sigma_m, 1e-14);
  const auto [values, vectors] = EigenOf(free.RestrictForm(information) / variance);
  const Eigen::VectorXd variances = values.cwiseMax(kUnseenInformation).cwiseInverse();
  return free.ExpandCovariance(Subspace(vectors).ExpandCovariance(variances.asDiagonal()));
}

double ConstrainedPose::DesignEffect(std::span<const PointPair> pairs, double patch_m) const {
  using Pull = Eigen::Matrix<double, 6, 1>;
  std::map<std::array<int, 3>, Pull> patches;
  Normal information = Normal::Zero(), apart = Normal::Zero(), together = Normal::Zero();
  for (const PointPair& pair : pairs) {
    const Pull row = Row(pair, scan_from_model_);
    const double distance =
        pair.normal_in_scan.dot(scan_from_model_ * pair.in_model - pair.in_scan);
    const Pull pull = pair.weight * distance * row;
    const Eigen::Array3i cell = (pair.in_model / patch_m).array().floor().cast<int>();
    patches.try_emplace({cell.x(), cell.y(), cell.z()}, Pull::Zero()).first->second += pull;
    information.noalias() += pair.weight * row * row.transpose();
    apart.noalias() += pull * pull.transpose();
  }
  for (const auto& [cell, pull] : patches) together.noalias() += pull * pull.transpose();
  const Subspace free = FreeDirections();
  const Eigen::MatrixXd inverse = InverseOfSymmetric(free.RestrictForm(information));
  const auto variance = [&](const Normal& scatter) {  // The trace of their product.
    return inverse.cwiseProduct(free.RestrictForm(scatter)).sum();
  };
  const double single = variance(apart);
  if (!(single > 0)) return 1;
  const double effect = variance(together) / single;
  return std::isfinite(effect) ? std::max(1.0, effect) : 1;
}

PoseCovariance ConstrainedPose::WidenedByParts(std::span<const PointPair> pairs,
                                               const PoseCovariance& covariance) const {
  struct Part {
    Normal information = Normal::Zero();
    Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
    int pairs = 0;
  };
  std::array<Part, 8> parts;
  const Eigen::Vector3d middle = Means(pairs).model;
  Normal information = Normal::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d from_middle = pair.in_model - middle;
    Part& part = parts[static_cast<std::size_t>((from_middle.x() > 0) + 2 * (from_middle.y() > 0) +
                                                4 * (from_middle.z() > 0))];
    const Eigen::Matrix<double, 6, 1> row = Row(pair, scan_from_model_);
    const double distance =
        pair.normal_in_scan.dot(scan_from_model_ * pair.in_model - pair.in_scan);
    part.information.noalias() += pair.weight * row * row.transpose();
    part.pull += pair.weight * distance * row;
    ++part.pairs;
  }
  for (const Part& part : parts) information += part.information;
  const Subspace free = FreeDirections();
  const Eigen::MatrixXd all = free.RestrictForm(information);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(free.size(), free.size());
  int used = 0;
  for (const Part& part : parts) {
    if (part.pairs == 0) continue;
    ++used;
    Eigen::MatrixXd others = all - free.RestrictForm(part.information);
    others.diagonal().array() += 1e-6 * all.trace() + 1e-12;
    const Eigen::VectorXd moved = SolveSymmetric(others, free.RestrictGradient(part.pull));
    scatter += moved * moved.transpose();
  }
  if (used < 2) return covariance;
  scatter *= (used - 1.0) / used;
  // In the coordinates in which the covariance is one, the larger of both along each axis.
  const auto [values, vectors] = EigenOf(free.RestrictForm(covariance));
  const Eigen::VectorXd deviations = values.cwiseMax(1e-18).cwiseSqrt();
  const Subspace axes(vectors);
  Eigen::MatrixXd relative = axes.RestrictForm(scatter);
  relative = relative.cwiseQuotient(Eigen::MatrixXd(deviations * deviations.transpose()));
  const auto [ratios, directions] = EigenOf(relative);
  Eigen::MatrixXd widened =
      Subspace(directions).ExpandCovariance(ratios.cwiseMax(1.0).asDiagonal());
  widened = widened.cwiseProduct(Eigen::MatrixXd(deviations * deviations.transpose()));
  return free.ExpandCovariance(axes.ExpandCovariance(widened));
}

PoseDeviations DeviationsOf(const PoseCovariance& covariance, const Eigen::Vector3d& up_in_scan) {
  constexpr double kRounding_m = 1e-9;
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  const Eigen::Matrix3d place = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d turn = covariance.bottomRightCorner<3, 3>();
  const double height = std::max(0.0, up_in_scan.dot(place * up_in_scan));
  PoseDeviations deviations;
  deviations.azimuth_rad = root(up_in_scan.dot(turn * up_in_scan));
  deviations.height_m = std::sqrt(height) < kRounding_m ? 0 : std::sqrt(height);
  deviations.horizontal_m = root(place.trace() - height);
  deviations.position_m = root(place.trace());
  return deviations;
}

PoseChange ChangeBetween(const Eigen::Isometry3d& scan_from_model,
                         const Eigen::Isometry3d& changed_scan_from_model,
                         const Eigen::Vector3d& up_in_scan) {
  const UprightFrame frame(-up_in_scan);
  const Eigen::Matrix3d before = scan_from_model.linear(), after = changed_scan_from_model.linear();
  const Eigen::Vector3d moved =
      changed_scan_from_model.translation() - scan_from_model.translation();
  PoseChange change;
  change.height_m = moved.dot(up_in_scan);
  change.horizontal_m = (moved - change.height_m * up_in_scan).norm();
  change.azimuth_rad = WrapAngle(frame.Azimuth(after) - frame.Azimuth(before));
  change.tilt_rad = frame.Tilt(after) - frame.Tilt(before);
  return change;
}

}  // namespace plumbline
