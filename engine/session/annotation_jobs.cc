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
#include "engine/models/scan_file.h"
#include "engine/registration/model_refinement.h"
#include "engine/render/small_picture.h"

namespace plumbline {
namespace {

constexpr std::size_t kFineVertices = 400'000, kCoarseVertices = 140'000;
constexpr int kPictureWidth = 208, kPictureHeight = 156;
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

PlacementCandidate CandidateOf(const AlignCandidate& found, const Eigen::Vector3d& up) {
  PlacementCandidate candidate;
  candidate.scan_from_object = found.scan_from_model;
  candidate.fitness = found.fitness;
  candidate.rmse_m = found.rmse_m;
  candidate.azimuth_rad = UprightFrame(-up).Azimuth(found.scan_from_model.linear());
  const PoseDeviations deviations = DeviationsOf(found.covariance, up);
  candidate.position_std_m = deviations.position_m;
  candidate.azimuth_std_rad = deviations.azimuth_rad;
  candidate.same_by_symmetry = found.same_by_symmetry;
  return candidate;
}

std::vector<double> AgreementsOf(const PlacementView& placement) {
  std::vector<double> agreements;
  for (const PlacementCandidate& candidate : placement.candidates) {
    agreements.push_back(candidate.agreement.value_or(0));
  }
  return agreements;
}

/// The candidate that the images clearly prefer comes first; the others stay in their order.
void PutBestFirst(PlacementView& placement) {
  const std::size_t best = PreferredByImages(AgreementsOf(placement));
  if (best == 0) return;
  const auto first = placement.candidates.begin();
  std::rotate(first, first + static_cast<std::ptrdiff_t>(best),
              first + static_cast<std::ptrdiff_t>(best) + 1);
  placement.by_images = true;
}

void Show(const PlacementTask& task, const ModelRefinement& now, RefinementView& view) {
  view.iteration = now.iterations;
  view.converged = now.converged;
  view.scan_from_object = now.scan_from_model;
  view.fitness = now.fit.fitness;
  view.rmse_m = now.fit.rmse_m;
  view.fitness_before = now.before.fitness;
  view.rmse_before_m = now.before.rmse_m;
  const PoseChange change =
      ChangeBetween(task.scan_from_object, now.scan_from_model, task.up_in_scan);
  view.azimuth_rad = change.azimuth_rad;
  view.horizontal_m = change.horizontal_m;
  view.height_m = change.height_m;
  view.tilt_rad = change.tilt_rad;
  view.residuals_m = std::make_shared<const std::vector<float>>(
      DistancesToScan(*task.target, task.mesh->vertices, now.scan_from_model, kResidualReach_m));
}

}  // namespace

Result<AnnotationScan> ReadAnnotationScan(const std::filesystem::path& file) {
  auto read = ReadScan(file);
  if (!read) return read.error();
  AnnotationScan scan;
  scan.num_left_out = read->num_left_out;
  scan.doubted_size_m = TooLargeForMetres(read->mesh);
  scan.full = std::make_shared<const TriangleMesh>(std::move(read->mesh));
  scan.fine = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan.full, kFineVertices));
  scan.coarse = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan.fine, kCoarseVertices));
  return scan;
}

Result<std::filesystem::path> WriteScanInMetres(const TriangleMesh& scan, double factor,
                                                const std::filesystem::path& file,
                                                const std::filesystem::path& fallback) {
  const TriangleMesh metric = Scaled(scan, factor);
  Status written;
  for (const std::filesystem::path& folder : {file.parent_path(), fallback}) {
    const std::string stem = file.stem().string() + "-metres";
    std::filesystem::path copy = folder / (stem + ".ply");
    std::error_code ignored;
    for (int i = 2; std::filesystem::exists(copy, ignored); ++i)
      copy = folder / (stem + "-" + std::to_string(i) + ".ply");
    written = WritePly(copy, metric);
    if (written.ok()) return copy;
  }
  return written.error();
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
    for (const AlignCandidate& candidate : found->candidates) {
      placement.candidates.push_back(CandidateOf(candidate, task.up_in_scan));
      placement.candidates.back().id = static_cast<int>(placement.candidates.size()) - 1;
    }
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

void ComparePlacements(const PlacementQuestion& question, const Eigen::Isometry3d& start,
                       const WorkContext& work,
                       const std::function<void(const PlacementView&)>& changed,
                       PlacementView& placement) {
  if (placement.candidates.empty()) return;
  const auto images = PlacementImages::Choose(question, start, work);
  if (!images) return;
  for (PlacementCandidate& candidate : placement.candidates) {
    if (work.stop.stop_requested()) return;
    candidate.agreement = images->Agreement(candidate.scan_from_object);
  }
  placement.images = images->size();
  PutBestFirst(placement);
  if (AnyAgrees(AgreementsOf(placement))) return;
  placement.searching = true;
  changed(placement);
  const auto found = images->Search(start, work);
  placement.searching = false;
  if (!found || !Convinces(found->agreement, AgreementsOf(placement))) return;
  PlacementCandidate candidate;
  candidate.scan_from_object = found->scan_from_object;
  candidate.azimuth_rad =
      UprightFrame(-question.up_in_scan).Azimuth(found->scan_from_object.linear());
  candidate.agreement = found->agreement;
  candidate.from_images = true;
  candidate.id = static_cast<int>(placement.candidates.size());
  placement.candidates.push_back(std::move(candidate));
  PutBestFirst(placement);
}

void SetDeviations(const PoseCovariance& covariance, const Eigen::Vector3d& up_in_scan,
                   RefinementView& refinement) {
  const PoseDeviations deviations = DeviationsOf(covariance, up_in_scan);
  refinement.height_std_m = deviations.height_m;
  refinement.horizontal_std_m = deviations.horizontal_m;
  refinement.azimuth_std_rad = deviations.azimuth_rad;
}

void Refine(const PlacementTask& task, const WorkContext& work, int pace_ms,
            const std::function<void(const RefinementView&)>& step, RefinementView& refinement) {
  const auto told = [&](const ModelRefinement& now) {
    Show(task, now, refinement);
    step(refinement);
    std::this_thread::sleep_for(std::chrono::milliseconds(pace_ms));
  };
  const FreeMotion motion = task.may_tilt        ? FreeMotion::kRigid
                            : task.floor_in_scan ? FreeMotion::kAzimuthAndHorizontal
                                                 : FreeMotion::kAzimuthAndTranslation;
  const auto refined = RefineModel(*task.target, *task.surface, task.scan_from_object,
                                   task.up_in_scan, motion, told, work);
  if (!refined && refined.error().code == ErrorCode::kCancelled) return;
  refinement.running = false;
  if (!refined) {
    refinement.problem = "There is no scan around this object to align it to.";
    ModelRefinement none;
    none.scan_from_model = task.scan_from_object;
    return Show(task, none, refinement);
  }
  SetDeviations(refined->covariance, task.up_in_scan, refinement);
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
