// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/model_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/registration/placement_grid.h"

namespace plumbline {
namespace {

constexpr std::size_t kFewestPoints = 30;
constexpr std::size_t kMostCandidates = 8;
constexpr double kSameTranslation_m = 0.02;
constexpr double kSameTurn_rad = 5 * std::numbers::pi / 180;
constexpr double kCoarseReach_m = 0.1;
constexpr double kSymmetryTolerance_m = 0.01;

double AngleBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle();
}

/// Whether two poses put the surface at the same place: compared at the model's middle, where a
/// turn alone moves nothing.
bool Same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& middle) {
  return (a * middle - b * middle).norm() < kSameTranslation_m &&
         AngleBetween(a, b) < kSameTurn_rad;
}

/// The pose with the model turned within itself about its axis of symmetry.
Eigen::Isometry3d TurnedWithin(const Eigen::Isometry3d& scan_from_model, double angle_rad,
                               const Eigen::Vector3d& middle) {
  return scan_from_model * Eigen::Translation3d(middle) *
         Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-middle);
}

bool SameBySymmetry(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, int order,
                    const Eigen::Vector3d& middle) {
  if (order == 0) {
    const double tilt = std::acos(std::clamp(a.linear().col(2).dot(b.linear().col(2)), -1.0, 1.0));
    return (a * middle - b * middle).norm() < kSameTranslation_m && tilt < kSameTurn_rad;
  }
  for (int i = 1; i < order; ++i) {
    if (Same(TurnedWithin(a, 2 * std::numbers::pi * i / order, middle), b, middle)) return true;
  }
  return false;
}

/// Sorted by falling score; of those that are the same the best stays.
void KeepDistinct(const Eigen::Vector3d& middle, std::size_t most,
                  std::vector<AlignCandidate>& poses) {
  std::stable_sort(
      poses.begin(), poses.end(),
      [](const AlignCandidate& a, const AlignCandidate& b) { return a.score > b.score; });
  std::vector<AlignCandidate> distinct;
  for (const AlignCandidate& pose : poses) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const auto& other) {
      return Same(pose.scan_from_model, other.scan_from_model, middle);
    });
    if (!known && distinct.size() < most) distinct.push_back(pose);
  }
  poses = std::move(distinct);
}

/// What is left of a score if the model floats above the support, or is sunk into it.
double Discount(const AlignmentCrop& crop, Standing standing, bool stands) {
  if (stands || !crop.support_m) return 1;
  return standing == Standing::kOnSupport ? 0.4 : 0.8;
}

bool Stands(const AlignmentCrop& crop, const Eigen::Isometry3d& scan_from_model,
            const Eigen::Vector3d& up_in_scan) {
  return crop.support_m && std::abs(crop.Gap(scan_from_model, up_in_scan)) < kStandsWithin_m;
}

/// Fills in how well a pose explains the scan.
void Judge(const AlignmentCrop& crop, const ModelSurface& model, const Eigen::Vector3d& up_in_scan,
           Standing standing, double within_m, AlignCandidate& candidate) {
  const AlignmentFit fit = Measure(crop, model, candidate.scan_from_model, within_m);
  candidate.fitness = fit.fitness;
  candidate.rmse_m = fit.rmse_m;
  candidate.stands = Stands(crop, candidate.scan_from_model, up_in_scan);
  candidate.score = fit.score * Discount(crop, standing, candidate.stands);
}

void Refine(const AlignmentCrop& crop, const ModelSurface& model, const Eigen::Vector3d& up_in_scan,
            const AlignOptions& options, int max_iterations, AlignCandidate& candidate) {
  ConstrainedPose pose(candidate.scan_from_model, up_in_scan, options.motion);
  const FineAlignment fine =
      AlignFinely(crop, model, IcpResidual::kPointToPlane, max_iterations, pose);
  candidate.scan_from_model = pose.scan_from_model();
  Judge(crop, model, up_in_scan, options.standing, options.within_m, candidate);
  candidate.sigma_m = fine.sigma_m;
  candidate.covariance = fine.covariance;
  candidate.iterations += fine.iterations;
  candidate.converged = fine.converged;
}

AlignCandidate AlignFrom(const AlignmentCrop& crop, const ModelSurface& model,
                         const Eigen::Isometry3d& start, FreeMotion motion,
                         const Eigen::Vector3d& up_in_scan, const AlignOptions& options) {
  ConstrainedPose pose(start, up_in_scan, motion);
  AlignCandidate candidate;
  candidate.iterations = AlignCoarsely(crop, model, kCoarseReach_m, pose);
  candidate.scan_from_model = pose.scan_from_model();
  Judge(crop, model, up_in_scan, options.standing, 2 * options.within_m, candidate);
  return candidate;
}

/// From the best placement at one azimuth; where that floats, also from the best that stands.
AlignCandidate BestOfTurn(const AlignmentCrop& crop, const ModelSurface& model,
                          const PlacementGrid& grid, double turn_rad,
                          const Eigen::Isometry3d& scan_from_model,
                          const Eigen::Vector3d& up_in_scan, const AlignOptions& options) {
  AlignCandidate best =
      AlignFrom(crop, model, grid.BestPlacement(turn_rad), options.motion, up_in_scan, options);
  if (best.stands || !crop.support_m || options.motion != FreeMotion::kAzimuthAndTranslation) {
    return best;
  }
  const double gap_m = crop.Gap(scan_from_model, up_in_scan);
  AlignCandidate standing = AlignFrom(crop, model, grid.BestPlacement(turn_rad, -gap_m),
                                      FreeMotion::kAzimuthAndHorizontal, up_in_scan, options);
  standing.iterations += best.iterations;
  return standing.score > best.score ? standing : best;
}

/// Onto the floor exactly, and along it to where it fits best there: floors are flat, and scans of
/// them less so. Only what stands on it already.
void SetOnFloor(const AlignmentCrop& crop, const ModelSurface& model,
                const Eigen::Vector3d& up_in_scan, const Eigen::Vector4d& floor_in_scan,
                double within_m, AlignCandidate& candidate) {
  constexpr int kMaxIterations = 20;
  const Eigen::Vector3d normal = floor_in_scan.head<3>();
  const double height_m = (normal.dot(candidate.scan_from_model.translation()) + floor_in_scan[3]) /
                          normal.dot(up_in_scan);
  if (!candidate.stands || !(std::abs(height_m) <= kStandsWithin_m)) return;
  candidate.scan_from_model.translation() -= height_m * up_in_scan;
  ConstrainedPose pose(candidate.scan_from_model, up_in_scan, FreeMotion::kAzimuthAndHorizontal);
  const FineAlignment fine =
      AlignFinely(crop, model, IcpResidual::kPointToPlane, kMaxIterations, pose);
  candidate.scan_from_model = pose.scan_from_model();
  candidate.sigma_m = fine.sigma_m;
  candidate.covariance = fine.covariance;
  candidate.iterations += fine.iterations;
  candidate.converged = fine.converged;
  const AlignmentFit fit = Measure(crop, model, candidate.scan_from_model, within_m);
  candidate.fitness = fit.fitness;
  candidate.rmse_m = fit.rmse_m;
}

/// What drifted out of the search radius is no answer to what was asked. Errors: kDegenerate if
/// nothing is left.
Status KeepWithin(const Eigen::Vector3d& start, double search_m,
                  std::vector<AlignCandidate>& candidates) {
  std::erase_if(candidates, [&](const AlignCandidate& candidate) {
    return (candidate.scan_from_model.translation() - start).norm() > search_m;
  });
  if (!candidates.empty()) return {};
  char text[160];
  std::snprintf(text, sizeof(text),
                "the scan fits the model nowhere within %g m of the start; start nearer to the "
                "object, or search further",
                search_m);
  return Error{ErrorCode::kDegenerate, text};
}

Status CheckInput(const Eigen::Vector3d& up_in_scan, const AlignOptions& options) {
  const auto bad = [](const char* what) { return Error{ErrorCode::kInvalidInput, what}; };
  if (options.starts < 1) return bad("an alignment needs at least one start");
  if (!(options.search_m > 0)) return bad("the search radius of an alignment must be positive");
  if (!(options.within_m > 0)) return bad("the distance that counts must be positive");
  if (!(std::abs(up_in_scan.norm() - 1) < 1e-6)) return bad("up must be a unit vector");
  return {};
}

}  // namespace

Result<ModelAlignment> AlignModel(const ScanTarget& scan, const ModelSurface& model,
                                  const Eigen::Isometry3d& scan_from_model,
                                  const Eigen::Vector3d& up_in_scan, const AlignOptions& options,
                                  const WorkContext& context) {
  if (const Status fine = CheckInput(up_in_scan, options); !fine.ok()) return fine.error();
  AlignmentCrop crop = CropScan(scan, model, scan_from_model, up_in_scan, options.search_m);
  if (crop.fine.points.size() < kFewestPoints) {
    return Error{ErrorCode::kDegenerate,
                 "there are only " + std::to_string(crop.fine.points.size()) +
                     " points of the scan where the model is to go; start nearer to the object"};
  }
  if (!crop.support_m && options.floor_in_scan) {
    crop.support_m = -(*options.floor_in_scan)[3];
    if (std::abs(crop.Gap(scan_from_model, up_in_scan)) > options.search_m) crop.support_m.reset();
  }
  const PlacementGrid grid(crop, model, scan_from_model, up_in_scan, options.search_m,
                           options.motion);
  ModelAlignment result;
  std::vector<AlignCandidate>& candidates = result.candidates;
  candidates.resize(static_cast<std::size_t>(options.starts));
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    if (context.stop.stop_requested()) return;
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / options.starts;
    candidates[i] = BestOfTurn(crop, model, grid, turn, scan_from_model, up_in_scan, options);
  });
  // Few are worth the exact search, and fewer its end.
  for (const auto& [share, most] : {std::pair{0.5, 8}, std::pair{0.7, 40}}) {
    const int iterations = most;  // clang 14 captures no structured binding
    if (context.stop.stop_requested()) {
      return Error{ErrorCode::kCancelled, "the alignment was stopped"};
    }
    if (Status near = KeepWithin(scan_from_model.translation(), options.search_m, candidates);
        !near.ok())
      return near.error();
    for (const AlignCandidate& candidate : candidates) result.iterations += candidate.iterations;
    KeepDistinct(model.middle(), kMostCandidates, candidates);
    for (const AlignCandidate& candidate : candidates) result.iterations -= candidate.iterations;
    const double least = share * candidates.front().score;
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
      const int own_iterations = candidates[i].score < least ? 1 : iterations;
      Refine(crop, model, up_in_scan, options, own_iterations, candidates[i]);
    });
  }
  if (options.standing == Standing::kOnSupport && options.floor_in_scan &&
      options.motion == FreeMotion::kAzimuthAndTranslation) {
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
      SetOnFloor(crop, model, up_in_scan, *options.floor_in_scan, options.within_m, candidates[i]);
    });
  }
  for (const AlignCandidate& candidate : candidates) result.iterations += candidate.iterations;
  if (Status near = KeepWithin(scan_from_model.translation(), options.search_m, candidates);
      !near.ok())
    return near.error();
  KeepDistinct(model.middle(), kMostCandidates, candidates);
  result.symmetry_order = model.SymmetryOrder(kSymmetryTolerance_m);
  const Eigen::Isometry3d best = result.candidates.front().scan_from_model;
  for (std::size_t i = 1; i < result.candidates.size(); ++i) {
    AlignCandidate& candidate = result.candidates[i];
    candidate.same_by_symmetry =
        SameBySymmetry(best, candidate.scan_from_model, result.symmetry_order, model.middle());
  }
  return result;
}

}  // namespace plumbline
