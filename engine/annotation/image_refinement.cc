// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/image_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/annotation/outline_equations.h"
#include "engine/geometry/angles.h"
#include "engine/vision/oriented_table.h"

namespace plumbline {
namespace {

/// Length of line that counts as one independent measurement [px of an image 640 wide]: an edge's
/// place errs together over about a tenth of an image.
constexpr double kIndependent_px = 100;
constexpr double kSmallestSigma_px = 0.5;
/// By how much the edges of an object may all lie outside of its contour, or inside.
constexpr double kOutwardSigma_px = 0.5;
/// By how much more a farther start must agree with the images to be preferred.
constexpr double kBetter = 0.002;

/// How far edges are looked for, from wide to narrow, and how often the outline is drawn anew.
struct Level {
  double search_px, sigma_px;
  int outlines, steps;
};
constexpr std::array<Level, 2> kApproach = {{{18, 7, 2, 3}, {10, 3.5, 2, 3}}};
constexpr Level kFinish = {6, 2, 8, 2};

struct Refined {
  PoseMove move = PoseMove::Zero();
  bool converged = false, inside = true;
  int iterations = 0;
};

class Refiner {
 public:
  Refiner(const AnnotationImages& images, const OutlineModel& model,
          const Eigen::Isometry3d& scan_from_object, const Eigen::Vector3d& up,
          const Occluders& occluders, const ImageRefinementOptions& options,
          const WorkContext& work)
      : images_(images),
        model_(model),
        motion_(scan_from_object, up, model.center().cast<double>()),
        occluders_(occluders),
        options_(options),
        work_(work),
        free_(motion_.Free(options.motion)),
        max_turn_rad_(options.max_turn_deg * std::numbers::pi / 180) {
    prior_.diagonal() << Eigen::Vector3d::Constant(4 / std::pow(options.max_shift_m, 2)),
        4 / std::pow(max_turn_rad_, 2);
  }

  Result<ImageRefinement> Run() {
    ImageRefinement result;
    const auto before = Check(PoseMove::Zero());
    double visible_px = 0;
    for (const ImageCheck& check : before) visible_px += check.visible_px;
    if (visible_px < options_.min_visible_px) {
      return Error{ErrorCode::kDegenerate,
                   "the images do not show the object: choose frames that do, or place it better"};
    }
    const std::vector<PoseMove> starts = Starts();
    Refined best;
    double best_agreement = -1;
    std::vector<PoseMove> reached;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Refined refined = Approach(starts[i]);
      // Where another start ended there is nothing new to find.
      const bool known = std::any_of(reached.begin(), reached.end(), [&](const PoseMove& other) {
        return Near(refined.move, other, 0.08);
      });
      if (!known) {
        reached.push_back(refined.move);
        Finish(refined);
      }
      if (work_.stop.stop_requested()) {
        return Error{ErrorCode::kCancelled, "the refinement was cancelled"};
      }
      work_.report({"refining", static_cast<int>(i + 1), static_cast<int>(starts.size())});
      result.iterations += refined.iterations;
      if (known || !refined.inside) continue;
      const double agreement = MeanAgreement(Check(refined.move));
      if (agreement < best_agreement + kBetter) continue;
      best_agreement = agreement;
      best = refined;
      result.start = static_cast<int>(i);
    }
    result.stop = best.converged ? RefinementStop::kConverged : RefinementStop::kMoving;
    if (best_agreement < MeanAgreement(before)) {
      best = {};
      result.start = 0;
      result.stop = RefinementStop::kNoBetter;
    }
    Describe(before, best.move, result);
    return result;
  }

 private:
  std::vector<ImageCheck> Check(const PoseMove& move) const {
    return CheckImages(images_, model_, motion_.At(move), occluders_);
  }

  /// The visible outline at a place.
  OutlineObservations Outline(const PoseMove& move, double own_scan_m) const {
    OutlineOptions outline;
    outline.own_scan_m = own_scan_m;
    const Eigen::Isometry3d pose = motion_.At(move);
    OutlineObservations observations(images_.images().size());
    tbb::parallel_for(std::size_t{0}, observations.size(), [&](std::size_t i) {
      const ModelOutline lines = ProjectOutline(model_, pose, images_.images()[i].scan_from_cam,
                                                images_.camera(), occluders_, outline);
      for (const OutlineSample& sample : lines.samples) {
        if (sample.hidden) continue;
        const double weight =
            sample.kind == OutlineKind::kCrease ? EdgeAgreementOptions{}.crease_weight : 1.0;
        const Eigen::Vector3d point = sample.in_object.cast<double>();
        const Eigen::Vector3d from_middle = point - motion_.middle();
        const int part =
            (from_middle.x() > 0) + 2 * (from_middle.y() > 0) + 4 * (from_middle.z() > 0);
        observations[i].push_back({point, sample.normal.cast<double>(), weight * sample.length_px,
                                   part, sample.kind == OutlineKind::kContour});
      }
    });
    return observations;
  }

  std::vector<EquationsByPart> Collect(const OutlineObservations& observations,
                                       const PoseMove& move, const Level& level) const {
    EdgeAgreementOptions edges;
    edges.search_px = level.search_px;
    edges.sigma_px = level.sigma_px;
    return CollectEquations(images_, motion_, observations, move, edges);
  }

  /// What turns sums over pixels of line into information.
  double Scale(const OutlineEquations& sum) const {
    const double width = images_.camera().width / 640.0;
    const double variance =
        std::max(sum.squares / std::max(sum.weight, 1e-9), std::pow(kSmallestSigma_px * width, 2));
    return 1 / (variance * kIndependent_px * width);
  }

  /// Of the free moves, the prior included.
  Eigen::MatrixXd FreeInformation(const OutlineEquations& sum) const {
    return free_.RestrictForm(Scale(sum) * sum.information + MoveInformation(prior_));
  }

  /// The start counts as a measurement with half the search as its standard deviation: what the
  /// images do not show stays put.
  PoseMove Step(const OutlineEquations& sum, const PoseMove& move) const {
    const double scale = Scale(sum);
    const Eigen::VectorXd pull = free_.RestrictGradient(scale * sum.gradient - prior_ * move);
    return free_.ExpandStep(SolveSymmetric(FreeInformation(sum), pull));
  }

  bool Inside(const PoseMove& move, double factor) const {
    const double height = motion_.up().dot(move.head<3>());
    const double across = (move.head<3>() - height * motion_.up()).norm();
    return across <= factor * options_.max_shift_m &&
           std::abs(height) <= factor * options_.max_shift_m &&
           std::abs(move[3]) <= factor * max_turn_rad_;
  }

  /// From a start to where the finest search reaches the right edges.
  Refined Approach(const PoseMove& start) const {
    // The object's own scan may be as far away as the search reaches.
    const double own_scan_m = OutlineOptions{}.own_scan_m + options_.max_shift_m;
    Refined refined;
    refined.move = start;
    for (const Level& level : kApproach) {
      for (int i = 0; i < level.outlines && refined.inside; ++i) {
        Iterate(level, own_scan_m, refined);
      }
    }
    return refined;
  }

  void Finish(Refined& refined) const {
    constexpr double kStill_m = 3e-4, kStill_rad = 5e-4;
    for (int i = 0; i < kFinish.outlines && refined.inside && !refined.converged; ++i) {
      const PoseMove begin = refined.move;
      Iterate(kFinish, OutlineOptions{}.own_scan_m, refined);
      const PoseMove change = refined.move - begin;
      refined.converged = change.head<3>().norm() < kStill_m && std::abs(change[3]) < kStill_rad;
    }
    refined.inside = refined.inside && Inside(refined.move, 1.0);
  }

  /// Draws the outline and brings it to the edges.
  void Iterate(const Level& level, double own_scan_m, Refined& refined) const {
    if (work_.stop.stop_requested()) return;
    const OutlineObservations observations = Outline(refined.move, own_scan_m);
    for (int k = 0; k < level.steps; ++k) {
      refined.move += Step(Sum(Collect(observations, refined.move, level)), refined.move);
      ++refined.iterations;
    }
    refined.inside = Inside(refined.move, 1.5);
  }

  bool Near(const PoseMove& a, const PoseMove& b, double share) const {
    return (a - b).head<3>().norm() / options_.max_shift_m + std::abs(a[3] - b[3]) / max_turn_rad_ <
           share;
  }

  std::vector<PoseMove> Starts() const;
  void Describe(const std::vector<ImageCheck>& before, const PoseMove& move,
                ImageRefinement& result) const;
  PoseCovariance Covariance(const std::vector<EquationsByPart>& equations,
                            const PoseMove& move) const;

  const AnnotationImages& images_;
  const OutlineModel& model_;
  UprightMotion motion_;
  const Occluders& occluders_;
  const ImageRefinementOptions& options_;
  const WorkContext& work_;
  Subspace free_;
  double max_turn_rad_;
  Eigen::DiagonalMatrix<double, 4> prior_;
};

/// Halton's sequence in [-1, 1]: spread evenly, the same every time.
double Halton(int index, int base) {
  double value = 0, share = 1;
  for (int i = index; i > 0; i /= base) {
    share /= base;
    value += share * (i % base);
  }
  return 2 * value - 1;
}

std::vector<PoseMove> Refiner::Starts() const {
  std::vector<PoseMove> starts = {PoseMove::Zero()};
  if (options_.starts < 2 || options_.coarse_samples == 0) return starts;
  const OutlineObservations observations =
      Outline(PoseMove::Zero(), OutlineOptions{}.own_scan_m + options_.max_shift_m);
  std::vector<std::unique_ptr<const OrientedTable>> tables;
  for (const AnnotationImage& image : images_.images()) {
    OrientedTableOptions table;
    table.power = 1;
    tables.push_back(std::make_unique<OrientedTable>(HalfSize(image.edges), table));
  }
  std::vector<PoseMove> moves;
  for (int i = 1; i <= options_.coarse_samples; ++i) {
    constexpr int kBases[4] = {2, 3, 5, 7};
    Eigen::VectorXd by(free_.size());
    for (Eigen::Index k = 0; k < by.size(); ++k) {
      const bool turn = k + 1 == by.size();
      by[k] = (turn ? max_turn_rad_ : options_.max_shift_m) * Halton(i, kBases[k]);
    }
    const PoseMove move = free_.ExpandStep(by);
    if (Inside(move, 1.0)) moves.push_back(move);
  }
  std::vector<std::pair<double, int>> ranked(moves.size());
  tbb::parallel_for(std::size_t{0}, moves.size(), [&](std::size_t m) {
    double sum = 0;
    const Eigen::Isometry3d pose = motion_.At(moves[m]);
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const OrientedTable& table = *tables[i];
      for (const OutlineObservation& observation : observations[i]) {
        const auto pixel =
            ProjectInto(images_.images()[i], images_.camera(), pose * observation.in_object);
        if (!pixel) continue;
        const int x = static_cast<int>(std::floor(pixel->x() / 2)),
                  y = static_cast<int>(std::floor(pixel->y() / 2));
        if (x < 0 || y < 0 || x >= table.width() || y >= table.height()) continue;
        const double angle = std::atan2(observation.normal.y(), observation.normal.x());
        const int bin =
            static_cast<int>(std::floor((angle / std::numbers::pi + 2) * OrientedTable::kBins)) %
            OrientedTable::kBins;
        sum += observation.length_px * (table.Hit(x, y, bin) / 255.0 - table.chance());
      }
    }
    ranked[m] = {-sum, static_cast<int>(m)};
  });
  std::sort(ranked.begin(), ranked.end());
  for (const auto& [score, m] : ranked) {
    if (static_cast<int>(starts.size()) >= options_.starts) break;
    const PoseMove& move = moves[static_cast<std::size_t>(m)];
    const bool known = std::any_of(starts.begin(), starts.end(),
                                   [&](const PoseMove& other) { return Near(move, other, 0.35); });
    if (!known) starts.push_back(move);
  }
  return starts;
}

PoseCovariance Refiner::Covariance(const std::vector<EquationsByPart>& equations,
                                   const PoseMove& move) const {
  std::vector<OutlineEquations> by_image, by_part(kModelParts);
  for (const EquationsByPart& parts : equations) {
    OutlineEquations& image = by_image.emplace_back();
    for (std::size_t k = 0; k < kModelParts; ++k) {
      image += parts[k];
      by_part[k] += parts[k];
    }
  }
  const OutlineEquations sum = Sum(equations);
  const double scale = Scale(sum);
  const Eigen::MatrixXd information = FreeInformation(sum);
  const double outward_scale = kOutwardSigma_px * images_.camera().width / 640.0 * scale;
  const Eigen::VectorXd outward =
      SolveSymmetric(information, free_.RestrictGradient(outward_scale * sum.outward));
  Eigen::MatrixXd of_free = InverseOfSymmetric(information);
  of_free += outward * outward.transpose();
  of_free += Jackknife(by_image, scale, information, free_);
  of_free += Jackknife(by_part, scale, information, free_);
  PoseMove cameras = PoseMove::Constant(std::pow(options_.camera_std_m, 2));
  cameras[3] = std::pow(options_.camera_turn_std_deg * kRadPerDeg, 2);
  of_free += free_.RestrictForm(cameras.asDiagonal());
  const Eigen::Matrix4d of_move = free_.ExpandCovariance(of_free);
  Eigen::Matrix<double, 6, 4> pose_from_move = Eigen::Matrix<double, 6, 4>::Zero();
  pose_from_move.topLeftCorner<3, 3>().setIdentity();
  pose_from_move.topRightCorner<3, 1>() =
      -motion_.up().cross(motion_.At(move).linear() * motion_.middle());
  pose_from_move.bottomRightCorner<3, 1>() = motion_.up();
  return pose_from_move * of_move * pose_from_move.transpose();
}

void Refiner::Describe(const std::vector<ImageCheck>& before, const PoseMove& move,
                       ImageRefinement& result) const {
  const std::vector<ImageCheck> after = Check(move);
  result.scan_from_object = motion_.At(move);
  result.agreement_before = MeanAgreement(before);
  result.agreement_after = MeanAgreement(after);
  result.offset_before_px = MedianOffset(before);
  result.offset_after_px = MedianOffset(after);
  const std::vector<EquationsByPart> equations =
      Collect(Outline(move, OutlineOptions{}.own_scan_m), move, kFinish);
  for (const EquationsByPart& parts : equations) {
    int samples = 0;
    for (const OutlineEquations& part : parts) samples += part.samples;
    result.images += samples > 0;
    result.samples += samples;
  }
  result.covariance = Covariance(equations, move);
  result.azimuth_rad = move[3];
  result.height_m = motion_.up().dot(move.head<3>());
  result.horizontal_m = (move.head<3>() - result.height_m * motion_.up()).norm();
}

}  // namespace

Result<ImageRefinement> RefineByImages(const AnnotationImages& images, const OutlineModel& model,
                                       const Eigen::Isometry3d& scan_from_object,
                                       const Eigen::Vector3d& up_in_scan,
                                       const Occluders& occluders,
                                       const ImageRefinementOptions& options,
                                       const WorkContext& work) {
  if (options.motion == FreeMotion::kRigid || !(options.max_shift_m > 0) ||
      !(options.max_turn_deg > 0) || options.starts < 1) {
    return Error{ErrorCode::kInvalidInput,
                 "a refinement by images needs a search wider than 0, a start, and no tilt"};
  }
  return Refiner(images, model, scan_from_object, up_in_scan, occluders, options, work).Run();
}

}  // namespace plumbline
