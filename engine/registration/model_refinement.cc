// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/model_refinement.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

Result<ModelRefinement> RefineModel(const ScanTarget& scan, const ModelSurface& model,
                                    const Eigen::Isometry3d& scan_from_model,
                                    const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                                    const std::function<void(const ModelRefinement&)>& step,
                                    const WorkContext& context) {
  constexpr double kReach_m = 0.1, kShrink = 0.7, kWithin_m = 0.02, kConverged = 2e-5;
  constexpr int kMaxIterations = 40, kLastIterations = 20;
  constexpr std::size_t kFewestPoints = 30;
  const AlignmentCrop crop = CropScan(scan, model, scan_from_model, up_in_scan, kReach_m);
  if (crop.fine.points.size() < kFewestPoints) {
    return Error{ErrorCode::kDegenerate, "there is no scan around this object to align it to"};
  }
  ConstrainedPose pose(scan_from_model, up_in_scan, motion);
  ModelRefinement refinement;
  refinement.before = Measure(crop, model, scan_from_model, kWithin_m);
  const auto show = [&] {
    ++refinement.iterations;
    refinement.scan_from_model = pose.scan_from_model();
    refinement.fit = Measure(crop, model, pose.scan_from_model(), kWithin_m);
    step(refinement);
  };
  const Error stopped{ErrorCode::kCancelled, "the alignment was stopped"};
  for (double reach = kReach_m; reach > kLeastCoarseReach_m; reach *= kShrink) {
    if (context.stop.stop_requested()) return stopped;
    AlignCoarsely(crop, model, reach, pose, std::max(reach, kLeastCoarseReach_m));
    show();
  }
  for (int i = 0; i < kMaxIterations && !refinement.converged; ++i) {
    if (context.stop.stop_requested()) return stopped;
    const Eigen::Isometry3d last = pose.scan_from_model();
    AlignFinely(crop, model, IcpResidual::kPointToPlane, 1, pose);
    const double moved = (pose.scan_from_model().matrix() - last.matrix()).norm();
    refinement.converged = moved < kConverged;
    show();
  }
  const FineAlignment last =
      AlignFinely(crop, model, IcpResidual::kPointToPlane, kLastIterations, pose);
  refinement.converged = refinement.converged || last.converged;
  refinement.covariance = last.covariance;
  show();
  return refinement;
}

std::vector<float> DistancesToScan(const ScanTarget& scan,
                                   std::span<const Eigen::Vector3f> points_in_model,
                                   const Eigen::Isometry3d& scan_from_model, double reach_m) {
  std::vector<float> distances;
  distances.reserve(points_in_model.size());
  const Eigen::Isometry3f pose = scan_from_model.cast<float>();
  for (const Eigen::Vector3f& point : points_in_model) {
    const float distance = std::sqrt(scan.tree().Nearest(pose * point).squared_distance);
    distances.push_back(distance < reach_m ? distance : -1.0f);
  }
  return distances;
}

}  // namespace plumbline
