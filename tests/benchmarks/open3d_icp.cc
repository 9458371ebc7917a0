// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmarks/open3d_icp.h"

#include <cmath>
#include <numbers>

#include <open3d/geometry/KDTreeSearchParam.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/CorrespondenceChecker.h>
#include <open3d/pipelines/registration/Feature.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/utility/Random.h>

namespace plumbline {
namespace {

namespace registration = open3d::pipelines::registration;

open3d::geometry::PointCloud Cloud(const OrientedPoints& points, std::size_t step) {
  open3d::geometry::PointCloud cloud;
  for (std::size_t i = 0; i < points.points.size(); i += step) {
    cloud.points_.push_back(points.points[i].cast<double>());
    cloud.normals_.push_back(points.normals[i].cast<double>());
  }
  return cloud;
}

/// The rigid step to planes, of which only four degrees of freedom are kept.
class ProjectedToPlanes : public registration::TransformationEstimationPointToPlane {
 public:
  explicit ProjectedToPlanes(const Eigen::Vector3d& up) : up_(up) {}

  Eigen::Matrix4d ComputeTransformation(
      const open3d::geometry::PointCloud& source, const open3d::geometry::PointCloud& target,
      const registration::CorrespondenceSet& pairs) const override {
    Eigen::Isometry3d step;
    step.matrix() =
        TransformationEstimationPointToPlane::ComputeTransformation(source, target, pairs);
    if (pairs.empty()) return step.matrix();
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector2i& pair : pairs)
      middle += source.points_[static_cast<std::size_t>(pair[0])];
    middle /= static_cast<double>(pairs.size());
    // Of swing and twist about up, the twist.
    const Eigen::Quaterniond turn(step.linear());
    const double angle = 2 * std::atan2(turn.vec().dot(up_), turn.w());
    Eigen::Isometry3d kept = Eigen::Isometry3d::Identity();
    kept.linear() = Eigen::AngleAxisd(angle, up_).toRotationMatrix();
    kept.translation() = step * middle - kept.linear() * middle;
    return kept.matrix();
  }

 private:
  Eigen::Vector3d up_;
};

}  // namespace

Eigen::Isometry3d AlignWithOpen3d(const AlignmentCrop& crop, const ModelSurface& surface,
                                  const Eigen::Isometry3d& start, const Eigen::Vector3d& up,
                                  int starts, Open3dSteps steps) {
  const registration::TransformationEstimationPointToPlane rigid;
  const ProjectedToPlanes projected(up);
  const registration::TransformationEstimation& estimation =
      steps == Open3dSteps::kRigid
          ? static_cast<const registration::TransformationEstimation&>(rigid)
          : projected;
  const auto source = Cloud(surface.samples(), 3), target = Cloud(crop.fine, 1);
  Eigen::Isometry3d best = start;
  double most = -1, least = 1e30;
  for (int i = 0; i < starts; ++i) {
    Eigen::Isometry3d turned = start;
    turned.linear() = Eigen::AngleAxisd(2 * std::numbers::pi * i / starts, up) * start.linear();
    Eigen::Matrix4d pose = turned.matrix();
    for (const double reach : {0.3, 0.1, 0.03}) {
      pose = registration::RegistrationICP(source, target, reach, pose, estimation,
                                           registration::ICPConvergenceCriteria(1e-6, 1e-6, 30))
                 .transformation_;
    }
    const auto judged = registration::EvaluateRegistration(source, target, 0.02, pose);
    if (judged.fitness_ > most || (judged.fitness_ == most && judged.inlier_rmse_ < least)) {
      most = judged.fitness_;
      least = judged.inlier_rmse_;
      best.matrix() = pose;
    }
  }
  return best;
}

Eigen::Isometry3d AlignByFeatures(const AlignmentCrop& crop, const ModelSurface& surface) {
  constexpr double kVoxel_m = 0.03;
  open3d::utility::random::Seed(0);
  const auto source = Cloud(surface.samples(), 1).VoxelDownSample(kVoxel_m);
  const auto target = Cloud(crop.fine, 1).VoxelDownSample(kVoxel_m);
  const open3d::geometry::KDTreeSearchParamHybrid near(5 * kVoxel_m, 100);
  const auto source_features = registration::ComputeFPFHFeature(*source, near);
  const auto target_features = registration::ComputeFPFHFeature(*target, near);
  const registration::CorrespondenceCheckerBasedOnEdgeLength edges(0.9);
  const registration::CorrespondenceCheckerBasedOnDistance distance(1.5 * kVoxel_m);
  Eigen::Matrix4d pose =
      registration::RegistrationRANSACBasedOnFeatureMatching(
          *source, *target, *source_features, *target_features, true, 1.5 * kVoxel_m,
          registration::TransformationEstimationPointToPoint(false), 3, {edges, distance},
          registration::RANSACConvergenceCriteria(100'000, 0.999))
          .transformation_;
  const auto full_source = Cloud(surface.samples(), 3), full_target = Cloud(crop.fine, 1);
  for (const double reach : {0.06, 0.03}) {
    pose = registration::RegistrationICP(full_source, full_target, reach, pose,
                                         registration::TransformationEstimationPointToPlane(),
                                         registration::ICPConvergenceCriteria(1e-6, 1e-6, 30))
               .transformation_;
  }
  Eigen::Isometry3d found;
  found.matrix() = pose;
  return found;
}

}  // namespace plumbline
