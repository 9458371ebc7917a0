// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/outline_equations.h"

#include <utility>

#include <tbb/parallel_for.h>

namespace plumbline {
namespace {

/// What moves the pixel of a point in the scan along `normal`.
PoseMove Row(const AnnotationImage& image, const PinholeCamera& camera, const UprightMotion& motion,
             const Eigen::Vector3d& in_scan, const Eigen::Vector2d& normal, const PoseMove& move) {
  const Eigen::Matrix3d cam_from_scan = image.scan_from_cam.linear().transpose();
  const Eigen::Vector3d in_cam = cam_from_scan * (in_scan - image.scan_from_cam.translation());
  const double inverse = 1 / in_cam.z();
  const Eigen::Vector3d in_cam_row(
      normal.x() * camera.fx * inverse, normal.y() * camera.fy * inverse,
      -(normal.x() * camera.fx * in_cam.x() + normal.y() * camera.fy * in_cam.y()) * inverse *
          inverse);
  const Eigen::Vector3d in_scan_row = cam_from_scan.transpose() * in_cam_row;
  PoseMove row;
  row << in_scan_row, in_scan_row.dot(motion.up().cross(in_scan - motion.MiddleAt(move)));
  return row;
}

}  // namespace

Eigen::Isometry3d UprightMotion::At(const PoseMove& move) const {
  Eigen::Isometry3d pose;
  pose.linear() = Eigen::AngleAxisd(move[3], up_).toRotationMatrix() * start_.linear();
  pose.translation() = middle_in_scan_ + move.head<3>() - pose.linear() * middle_;
  pose.makeAffine();
  return pose;
}

Subspace UprightMotion::Free(FreeMotion motion) const {
  Eigen::MatrixXd free = Eigen::MatrixXd::Zero(4, DegreesOfFreedom(motion));
  if (motion == FreeMotion::kAzimuth) {  // About the origin: the middle swings.
    free.col(0) << up_.cross(start_.linear() * middle_), 1.0;
  } else if (motion == FreeMotion::kAzimuthAndTranslation) {
    free.setIdentity();
  } else {
    const Eigen::Vector3d side = up_.unitOrthogonal();
    free.col(0).head<3>() = side;
    free.col(1).head<3>() = up_.cross(side);
    free(3, 2) = 1;
  }
  return Subspace(std::move(free));
}

std::optional<Eigen::Vector2d> ProjectInto(const AnnotationImage& image,
                                           const PinholeCamera& camera,
                                           const Eigen::Vector3d& in_scan) {
  const Eigen::Vector3d in_cam = image.scan_from_cam.inverse() * in_scan;
  if (in_cam.z() < 0.05) return std::nullopt;
  return camera.Project(in_cam);
}

std::vector<EquationsByPart> CollectEquations(const AnnotationImages& images,
                                              const UprightMotion& motion,
                                              const OutlineObservations& observations,
                                              const PoseMove& move,
                                              const EdgeAgreementOptions& edges) {
  const Eigen::Isometry3d pose = motion.At(move);
  std::vector<EquationsByPart> equations(observations.size());
  tbb::parallel_for(std::size_t{0}, observations.size(), [&](std::size_t i) {
    const AnnotationImage& image = images.images()[i];
    const EdgeSearch search(image.edges, edges);
    for (const OutlineObservation& observation : observations[i]) {
      const Eigen::Vector3d in_scan = pose * observation.in_object;
      const auto pixel = ProjectInto(image, images.camera(), in_scan);
      if (!pixel) continue;
      const EdgeHit hit = search.Find(pixel->cast<float>(), observation.normal.cast<float>());
      if (hit.strength == 0) continue;
      const PoseMove row = Row(image, images.camera(), motion, in_scan, observation.normal, move);
      const double weight = observation.length_px * hit.strength;
      OutlineEquations& sum = equations[i][static_cast<std::size_t>(observation.part)];
      sum.information += weight * row * row.transpose();
      sum.gradient += weight * hit.offset_px * row;
      if (observation.contour) sum.outward += weight * row;
      sum.weight += weight;
      sum.squares += weight * hit.offset_px * hit.offset_px;
      ++sum.samples;
    }
  });
  return equations;
}

OutlineEquations Sum(const std::vector<EquationsByPart>& equations) {
  OutlineEquations sum;
  for (const EquationsByPart& parts : equations) {
    for (const OutlineEquations& part : parts) sum += part;
  }
  return sum;
}

Eigen::MatrixXd Jackknife(const std::vector<OutlineEquations>& groups, double scale,
                          const Eigen::MatrixXd& information, const Subspace& free) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(information.rows(), information.cols());
  int used = 0;
  for (const OutlineEquations& group : groups) {
    if (group.samples == 0) continue;
    ++used;
    const Eigen::MatrixXd without = information - scale * free.RestrictForm(group.information);
    const Eigen::VectorXd moved =
        SolveSymmetric(without, free.RestrictGradient(scale * group.gradient));
    covariance += moved * moved.transpose();
  }
  if (used > 1) covariance *= (used - 1.0) / used;
  return covariance;
}

}  // namespace plumbline
