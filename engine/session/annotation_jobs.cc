// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_jobs.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/geometry/gravity.h"
#include "engine/geometry/vertex_clustering.h"
#include "engine/models/mesh_file.h"
#include "engine/render/small_picture.h"

namespace plumbline {
namespace {

constexpr std::size_t kFineVertices = 400'000, kCoarseVertices = 140'000;
constexpr int kPictureWidth = 208, kPictureHeight = 156;
constexpr double kFarShare = 0.6;  ///< Of the search radius.
constexpr double kResidualReach_m = 0.1;
constexpr std::size_t kShownFloorPoints = 12'000;

/// The vertices around a ball, with their colours.
TriangleMesh PartOf(const TriangleMesh& scan, const Eigen::Vector3d& center, double radius_m) {
  TriangleMesh part;
  const bool colored = scan.colors.size() == scan.vertices.size();
  const Eigen::Vector3f c = center.cast<float>();
  const auto reach2 = static_cast<float>(radius_m * radius_m);
  for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
    if ((scan.vertices[i] - c).squaredNorm() > reach2) continue;
    part.vertices.push_back(scan.vertices[i]);
    if (colored) part.colors.push_back(scan.colors[i]);
  }
  return part;
}

std::pair<double, double> Deviations(const PoseCovariance& covariance, const Eigen::Vector3d& up) {
  const Eigen::Matrix3d turn = covariance.bottomRightCorner<3, 3>();
  return {std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace())),
          std::sqrt(std::max(0.0, up.dot(turn * up)))};
}

PlacementCandidate CandidateOf(const AlignCandidate& found, const Eigen::Vector3d& up) {
  PlacementCandidate candidate;
  candidate.scan_from_object = found.scan_from_model;
  candidate.fitness = found.fitness;
  candidate.rmse_m = found.rmse_m;
  candidate.azimuth_rad = UprightFrame(-up).Azimuth(found.scan_from_model.linear());
  std::tie(candidate.position_std_m, candidate.azimuth_std_rad) = Deviations(found.covariance, up);
  candidate.same_by_symmetry = found.same_by_symmetry;
  return candidate;
}

/// Onto the floor exactly, and along it to where it fits best there: floors are flat, and scans of
/// them less so. Only what stands on it already, within 3 cm.
void SetOnFloor(const PlacementTask& task, const AlignmentCrop& crop, AlignCandidate& found) {
  constexpr double kWithin_m = 0.02;
  constexpr int kMaxIterations = 20;
  const Eigen::Vector3d up = task.floor_in_scan->head<3>();
  const double height_m = up.dot(found.scan_from_model.translation()) + (*task.floor_in_scan)[3];
  if (!found.stands || std::abs(height_m) > kStandsWithin_m) return;
  found.scan_from_model.translation() -= height_m * up;
  ConstrainedPose pose(found.scan_from_model, up, FreeMotion::kAzimuthAndHorizontal);
  const FineAlignment fine =
      AlignFinely(crop, *task.surface, IcpResidual::kPointToPlane, kMaxIterations, pose);
  found.scan_from_model = pose.scan_from_model();
  found.covariance = fine.covariance;
  const AlignmentFit fit = Measure(crop, *task.surface, found.scan_from_model, kWithin_m);
  found.fitness = fit.fitness;
  found.rmse_m = fit.rmse_m;
}

/// Of what came to the same place on the floor the first stays.
void DropSame(std::vector<PlacementCandidate>& candidates) {
  constexpr double kSame_m = 0.01, kSame_rad = 0.02;
  std::vector<PlacementCandidate> distinct;
  for (PlacementCandidate& candidate : candidates) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const auto& other) {
      const Eigen::Isometry3d moved = other.scan_from_object.inverse() * candidate.scan_from_object;
      return moved.translation().norm() < kSame_m &&
             Eigen::AngleAxisd(moved.linear()).angle() < kSame_rad;
    });
    if (!known) distinct.push_back(std::move(candidate));
  }
  candidates = std::move(distinct);
}

/// What changed, split as people think of it.
void Compare(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, const Eigen::Vector3d& up,
             RefinementView& refinement) {
  const UprightFrame frame(-up);
  const Eigen::Vector3d moved = to.translation() - from.translation();
  refinement.height_m = moved.dot(up);
  refinement.horizontal_m = (moved - refinement.height_m * up).norm();
  refinement.azimuth_rad = WrapAngle(frame.Azimuth(to.linear()) - frame.Azimuth(from.linear()));
  refinement.tilt_rad = frame.Tilt(to.linear()) - frame.Tilt(from.linear());
}

std::shared_ptr<const std::vector<float>> Residuals(const PlacementTask& task,
                                                    const Eigen::Isometry3d& scan_from_object) {
  auto residuals = std::make_shared<std::vector<float>>();
  residuals->reserve(task.mesh->vertices.size());
  const Eigen::Isometry3f pose = scan_from_object.cast<float>();
  for (const Eigen::Vector3f& vertex : task.mesh->vertices) {
    const auto found = task.target->tree().Nearest(pose * vertex);
    const float distance = std::sqrt(found.squared_distance);
    residuals->push_back(distance < kResidualReach_m ? distance : -1.0f);
  }
  return residuals;
}

}  // namespace

Result<AnnotationScan> ReadAnnotationScan(const std::filesystem::path& file) {
  auto mesh = ReadMesh(file);
  if (!mesh) return mesh.error();
  AnnotationScan scan;
  scan.full = std::make_shared<const TriangleMesh>(std::move(*mesh));
  scan.fine = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan.full, kFineVertices));
  scan.coarse = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan.fine, kCoarseVertices));
  return scan;
}

void FindPlacements(const PlacementTask& task, const WorkContext& work, PlacementView& placement) {
  const auto start = std::chrono::steady_clock::now();
  AlignOptions options;
  if (task.stands) options.standing = Standing::kOnSupport;
  options.floor_in_scan = task.floor_in_scan;
  auto found = AlignModel(*task.target, *task.surface, task.scan_from_object, task.up_in_scan,
                          options, work);
  placement.running = false;
  if (work.stop.stop_requested()) return;
  if (found) {
    placement.symmetry_order = found->symmetry_order;
    if (task.stands && task.floor_in_scan) {
      const AlignmentCrop crop = CropScan(*task.target, *task.surface, task.scan_from_object,
                                          task.up_in_scan, options.search_m);
      tbb::parallel_for(std::size_t{0}, found->candidates.size(),
                        [&](std::size_t i) { SetOnFloor(task, crop, found->candidates[i]); });
    }
    for (const AlignCandidate& candidate : found->candidates) {
      placement.candidates.push_back(CandidateOf(candidate, task.up_in_scan));
    }
    DropSame(placement.candidates);
  } else {
    placement.problem = found.error().message;
    PlacementCandidate as_clicked;
    as_clicked.scan_from_object = task.scan_from_object;
    as_clicked.azimuth_rad = UprightFrame(-task.up_in_scan).Azimuth(task.scan_from_object.linear());
    placement.candidates.push_back(as_clicked);
  }
  AddPictures(task, placement);
  placement.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void AddPictures(const PlacementTask& task, PlacementView& placement) {
  const Eigen::AlignedBox3f box = BoundingBox(*task.mesh);
  PictureView view;
  view.up = task.up_in_scan;
  view.azimuth_rad = task.view_azimuth_rad;
  view.elevation_rad = 0.5;
  view.radius_m = std::max(0.1, 0.56 * static_cast<double>(box.diagonal().norm()));
  view.focus = placement.candidates.front().scan_from_object * box.center().cast<double>();
  const TriangleMesh part = PartOf(*task.scan, view.focus, 1.5 * view.radius_m);
  auto& candidates = placement.candidates;
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    if (!candidates[i].picture.empty()) return;
    candidates[i].picture = PlacementPicture(part, *task.mesh, candidates[i].scan_from_object, view,
                                             kPictureWidth, kPictureHeight);
  });
}

void SetDeviations(const PoseCovariance& covariance, const Eigen::Vector3d& up_in_scan,
                   RefinementView& refinement) {
  const Eigen::Matrix3d place = covariance.topLeftCorner<3, 3>();
  const double height = std::max(0.0, up_in_scan.dot(place * up_in_scan));
  constexpr double kRounding_m = 1e-9;
  refinement.height_std_m = std::sqrt(height) < kRounding_m ? 0 : std::sqrt(height);
  refinement.horizontal_std_m = std::sqrt(std::max(0.0, place.trace() - height));
  refinement.azimuth_std_rad = Deviations(covariance, up_in_scan).second;
}

void Refine(const PlacementTask& task, const WorkContext& work, int pace_ms,
            const std::function<void(const RefinementView&)>& step, RefinementView& refinement) {
  constexpr double kReach_m = 0.1, kShrink = 0.7, kWithin_m = 0.02, kConverged = 2e-5;
  constexpr int kMaxIterations = 40;
  const Eigen::Vector3d& up = task.up_in_scan;
  const AlignmentCrop crop =
      CropScan(*task.target, *task.surface, task.scan_from_object, up, kReach_m);
  ConstrainedPose pose(
      task.scan_from_object, up,
      task.floor_in_scan ? FreeMotion::kAzimuthAndHorizontal : FreeMotion::kAzimuthAndTranslation);
  const AlignmentFit before = Measure(crop, *task.surface, task.scan_from_object, kWithin_m);
  refinement.fitness_before = before.fitness;
  refinement.rmse_before_m = before.rmse_m;
  const auto show = [&] {
    ++refinement.iteration;
    refinement.scan_from_object = pose.scan_from_model();
    Compare(task.scan_from_object, pose.scan_from_model(), up, refinement);
    refinement.residuals_m = Residuals(task, pose.scan_from_model());
    const AlignmentFit fit = Measure(crop, *task.surface, pose.scan_from_model(), kWithin_m);
    refinement.fitness = fit.fitness;
    refinement.rmse_m = fit.rmse_m;
    step(refinement);
    std::this_thread::sleep_for(std::chrono::milliseconds(pace_ms));
  };
  if (crop.fine.points.size() < 30) {
    refinement.problem = "There is no scan around this object to align it to.";
    show();
    refinement.running = false;
    return;
  }
  for (double reach = kReach_m; reach > kLeastCoarseReach_m; reach *= kShrink) {
    if (work.stop.stop_requested()) return;
    AlignCoarsely(crop, *task.surface, reach, pose, std::max(reach, kLeastCoarseReach_m));
    show();
  }
  for (int i = 0; i < kMaxIterations && !refinement.converged; ++i) {
    if (work.stop.stop_requested()) return;
    const Eigen::Isometry3d last = pose.scan_from_model();
    AlignFinely(crop, *task.surface, IcpResidual::kPointToPlane, 1, pose);
    const double moved = (pose.scan_from_model().matrix() - last.matrix()).norm();
    refinement.converged = moved < kConverged;
    show();
  }
  const FineAlignment last = AlignFinely(crop, *task.surface, IcpResidual::kPointToPlane, 20, pose);
  refinement.converged = refinement.converged || last.converged;
  SetDeviations(last.covariance, up, refinement);
  refinement.running = false;
  show();
}

void ShowFloorPoints(const ScanTarget& target, FloorProposal& proposal) {
  constexpr double kThickness_m = 0.03, kClose_m = 0.10;
  auto inliers = std::make_shared<std::vector<Eigen::Vector3f>>();
  auto outliers = std::make_shared<std::vector<Eigen::Vector3f>>();
  const auto& points = target.points().points;
  if (proposal.offset_m) {
    const std::size_t stride = std::max<std::size_t>(1, points.size() / 80'000);
    const Eigen::Vector3f up = proposal.up_in_scan.cast<float>();
    for (std::size_t i = 0; i < points.size(); i += stride) {
      const double height = points[i].dot(up) + *proposal.offset_m;
      if (std::abs(height) < kThickness_m) {
        inliers->push_back(points[i]);
      } else if (std::abs(height) < kClose_m) {
        outliers->push_back(points[i]);
      }
    }
  }
  proposal.inliers = std::move(inliers);
  proposal.outliers = std::move(outliers);
}

Result<FloorProposal> ProposeFloor(const ScanTarget& target,
                                   const std::optional<Eigen::Vector3d>& seed_in_scan,
                                   const FloorHints& hints, const Eigen::Vector3d& up_now_in_scan) {
  const Result<FloorPlane> plane =
      seed_in_scan ? FitFloorFrom(target, *seed_in_scan, hints) : FindFloor(target, hints);
  if (!plane) return plane.error();
  FloorProposal proposal;
  proposal.source = seed_in_scan ? "picked" : "found";
  proposal.up_in_scan = plane->up_in_scan;
  proposal.offset_m = plane->offset_m;
  proposal.num_inliers = plane->inliers.size();
  proposal.rmse_m = plane->rmse_m;
  proposal.normal_std_rad = plane->normal_std_rad;
  proposal.turn_rad = std::acos(std::clamp(plane->up_in_scan.dot(up_now_in_scan), -1.0, 1.0));
  ShowFloorPoints(target, proposal);
  // The inliers are those of the fit: what is connected, not all that lies at this height.
  auto inliers = std::make_shared<std::vector<Eigen::Vector3f>>();
  const std::size_t stride = std::max<std::size_t>(1, plane->inliers.size() / kShownFloorPoints);
  for (std::size_t i = 0; i < plane->inliers.size(); i += stride) {
    inliers->push_back(target.points().points[static_cast<std::size_t>(plane->inliers[i])]);
  }
  proposal.inliers = std::move(inliers);
  return proposal;
}

}  // namespace plumbline
