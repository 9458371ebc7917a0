// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmarks/open3d_icp.h"

#include <numbers>

#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/Registration.h>

namespace plumbline {
namespace {

open3d::geometry::PointCloud Cloud(const OrientedPoints& points, std::size_t step) {
  open3d::geometry::PointCloud cloud;
  for (std::size_t i = 0; i < points.points.size(); i += step) {
    cloud.points_.push_back(points.points[i].cast<double>());
    cloud.normals_.push_back(points.normals[i].cast<double>());
  }
  return cloud;
}

}  // namespace

Eigen::Isometry3d AlignWithOpen3d(const AlignmentCrop& crop, const ModelSurface& surface,
                                  const Eigen::Isometry3d& start, const Eigen::Vector3d& up,
                                  int starts) {
  namespace registration = open3d::pipelines::registration;
  const auto source = Cloud(surface.samples(), 3), target = Cloud(crop.fine, 1);
  Eigen::Isometry3d best = start;
  double most = -1, least = 1e30;
  for (int i = 0; i < starts; ++i) {
    Eigen::Isometry3d turned = start;
    turned.linear() = Eigen::AngleAxisd(2 * std::numbers::pi * i / starts, up) * start.linear();
    Eigen::Matrix4d pose = turned.matrix();
    for (const double reach : {0.3, 0.1, 0.03}) {
      pose = registration::RegistrationICP(source, target, reach, pose,
                                           registration::TransformationEstimationPointToPlane(),
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

}  // namespace plumbline
