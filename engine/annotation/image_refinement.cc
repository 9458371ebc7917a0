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

#include <Eigen/Dense>

#include "engine/vision/oriented_table.h"

namespace plumbline {
namespace {

/// Shift of the model's middle in the scan [m], then the turn about up [rad], from the start.
using Move = Eigen::Vector4d;
using Information = Eigen::Matrix4d;

/// Length of line that counts as one independent measurement [px of an image 640 wide]: an edge's
/// place errs together over about a tenth of an image.
constexpr double kIndependent_px = 100;
constexpr double kSmallestSigma_px = 0.5;
/// By how much the edges of an object may all lie outside of its contour, or inside.
constexpr double kOutwardSigma_px = 0.5;
constexpr int kParts = 8;
/// By how much more a farther start must agree with the images to be preferred.
constexpr double kBetter = 0.002;

/// How far edges are looked for, from wide to narrow, and how often the outline is drawn anew.
struct Level {
  double search_px, sigma_px;
  int outlines, steps;
};
constexpr std::array<Level, 2> kApproach = {{{18, 7, 2, 3}, {10, 3.5, 2, 3}}};
constexpr Level kFinish = {6, 2, 8, 2};

/// A point of the outline in one image.
struct Observation {
  Eigen::Vector3d in_object;
  Eigen::Vector2d normal;
  double length_px;  ///< Creases count less.
  int part;          ///< Octant of the model.
  bool contour;      ///< The normal points out of the object.
};
using Observations = std::vector<std::vector<Observation>>;  ///< By image.

/// Poses that a move from the start reaches. The turn stays one angle, so the tilt stays exact.
class Motion {
 public:
  Motion(const Eigen::Isometry3d& start, const Eigen::Vector3d& up, const Eigen::Vector3d& middle)
      : start_(start), up_(up), middle_(middle), middle_in_scan_(start * middle) {}

  Eigen::Isometry3d At(const Move& move) const {
    Eigen::Isometry3d pose;
    pose.linear() = Eigen::AngleAxisd(move[3], up_).toRotationMatrix() * start_.linear();
    pose.translation() = middle_in_scan_ + move.head<3>() - pose.linear() * middle_;
    pose.makeAffine();
    return pose;
  }
  Eigen::Vector3d MiddleAt(const Move& move) const { return middle_in_scan_ + move.head<3>(); }
  const Eigen::Vector3d& up() const { return up_; }
  const Eigen::Vector3d& middle() const { return middle_; }

  /// Columns: the free moves.
  Eigen::Matrix<double, 4, Eigen::Dynamic> Free(FreeMotion motion) const {
    Eigen::Matrix<double, 4, Eigen::Dynamic> free =
        Eigen::Matrix<double, 4, Eigen::Dynamic>::Zero(4, DegreesOfFreedom(motion));
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
    return free;
  }

 private:
  Eigen::Isometry3d start_;
  Eigen::Vector3d up_, middle_, middle_in_scan_;
};

/// Of one image, or all: the normal equations of the distances to the edges.
struct Equations {
  Information information = Information::Zero();  ///< Sum of weight * J^T J.
  Move gradient = Move::Zero();                   ///< Sum of weight * J^T * distance.
  Move outward = Move::Zero();  ///< The gradient if all contours lay a pixel further out.
  double weight = 0, squares = 0;
  int samples = 0;

  Equations& operator+=(const Equations& other) {
    information += other.information;
    gradient += other.gradient;
    outward += other.outward;
    weight += other.weight;
    squares += other.squares;
    samples += other.samples;
    return *this;
  }
};
/// Of one image.
using EquationsByPart = std::array<Equations, kParts>;

struct Refined {
  Move move = Move::Zero();
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
    const auto before = Check(Move::Zero());
    double visible_px = 0;
    for (const ImageCheck& check : before) visible_px += check.visible_px;
    if (visible_px < options_.min_visible_px) {
      return Error{ErrorCode::kDegenerate,
                   "the images do not show the object: choose frames that do, or place it better"};
    }
    const std::vector<Move> starts = Starts();
    Refined best;
    double best_agreement = -1;
    std::vector<Move> reached;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Refined refined = Approach(starts[i]);
      // Where another start ended there is nothing new to find.
      const bool known = std::any_of(reached.begin(), reached.end(), [&](const Move& other) {
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
  std::vector<ImageCheck> Check(const Move& move) const {
    return CheckImages(images_, model_, motion_.At(move), occluders_);
  }

  /// The visible outline at a place.
  Observations Outline(const Move& move, double own_scan_m) const {
    OutlineOptions outline;
    outline.own_scan_m = own_scan_m;
    const Eigen::Isometry3d pose = motion_.At(move);
    Observations observations(images_.images().size());
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

  /// Pixel of a point in the scan, and, if asked for, what moves it along `normal`.
  std::optional<Eigen::Vector2d> Project(const AnnotationImage& image,
                                         const Eigen::Vector3d& in_scan) const {
    const Eigen::Vector3d in_cam = image.scan_from_cam.inverse() * in_scan;
    if (in_cam.z() < 0.05) return std::nullopt;
    return images_.camera().Project(in_cam);
  }

  Move Row(const AnnotationImage& image, const Eigen::Vector3d& in_scan,
           const Eigen::Vector2d& normal, const Move& move) const {
    const PinholeCamera& camera = images_.camera();
    const Eigen::Matrix3d cam_from_scan = image.scan_from_cam.linear().transpose();
    const Eigen::Vector3d in_cam = cam_from_scan * (in_scan - image.scan_from_cam.translation());
    const double inverse = 1 / in_cam.z();
    const Eigen::Vector3d in_cam_row(
        normal.x() * camera.fx * inverse, normal.y() * camera.fy * inverse,
        -(normal.x() * camera.fx * in_cam.x() + normal.y() * camera.fy * in_cam.y()) * inverse *
            inverse);
    const Eigen::Vector3d in_scan_row = cam_from_scan.transpose() * in_cam_row;
    Move row;
    row << in_scan_row, in_scan_row.dot(motion_.up().cross(in_scan - motion_.MiddleAt(move)));
    return row;
  }

  std::vector<EquationsByPart> Collect(const Observations& observations, const Move& move,
                                       const Level& level) const {
    EdgeAgreementOptions edges;
    edges.search_px = level.search_px;
    edges.sigma_px = level.sigma_px;
    const Eigen::Isometry3d pose = motion_.At(move);
    std::vector<EquationsByPart> equations(observations.size());
    tbb::parallel_for(std::size_t{0}, observations.size(), [&](std::size_t i) {
      const AnnotationImage& image = images_.images()[i];
      const EdgeSearch search(image.edges, edges);
      for (const Observation& observation : observations[i]) {
        const Eigen::Vector3d in_scan = pose * observation.in_object;
        const auto pixel = Project(image, in_scan);
        if (!pixel) continue;
        const EdgeHit hit = search.Find(pixel->cast<float>(), observation.normal.cast<float>());
        if (hit.strength == 0) continue;
        const Move row = Row(image, in_scan, observation.normal, move);
        const double weight = observation.length_px * hit.strength;
        Equations& sum = equations[i][static_cast<std::size_t>(observation.part)];
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

  static Equations Sum(const std::vector<EquationsByPart>& equations) {
    Equations sum;
    for (const EquationsByPart& parts : equations) {
      for (const Equations& part : parts) sum += part;
    }
    return sum;
  }

  /// What turns sums over pixels of line into information.
  double Scale(const Equations& sum) const {
    const double width = images_.camera().width / 640.0;
    const double variance =
        std::max(sum.squares / std::max(sum.weight, 1e-9), std::pow(kSmallestSigma_px * width, 2));
    return 1 / (variance * kIndependent_px * width);
  }

  /// The start counts as a measurement with half the search as its standard deviation: what the
  /// images do not show stays put.
  Move Step(const Equations& sum, const Move& move) const {
    const double scale = Scale(sum);
    const Eigen::MatrixXd information =
        free_.transpose() * (scale * sum.information + Information(prior_)) * free_;
    const Eigen::VectorXd pull = free_.transpose() * (scale * sum.gradient - prior_ * move);
    return free_ * information.ldlt().solve(pull);
  }

  bool Inside(const Move& move, double factor) const {
    const double height = motion_.up().dot(move.head<3>());
    const double across = (move.head<3>() - height * motion_.up()).norm();
    return across <= factor * options_.max_shift_m &&
           std::abs(height) <= factor * options_.max_shift_m &&
           std::abs(move[3]) <= factor * max_turn_rad_;
  }

  /// From a start to where the finest search reaches the right edges.
  Refined Approach(const Move& start) const {
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
      const Move begin = refined.move;
      Iterate(kFinish, OutlineOptions{}.own_scan_m, refined);
      const Move change = refined.move - begin;
      refined.converged = change.head<3>().norm() < kStill_m && std::abs(change[3]) < kStill_rad;
    }
    refined.inside = refined.inside && Inside(refined.move, 1.0);
  }

  /// Draws the outline and brings it to the edges.
  void Iterate(const Level& level, double own_scan_m, Refined& refined) const {
    if (work_.stop.stop_requested()) return;
    const Observations observations = Outline(refined.move, own_scan_m);
    for (int k = 0; k < level.steps; ++k) {
      refined.move += Step(Sum(Collect(observations, refined.move, level)), refined.move);
      ++refined.iterations;
    }
    refined.inside = Inside(refined.move, 1.5);
  }

  bool Near(const Move& a, const Move& b, double share) const {
    return (a - b).head<3>().norm() / options_.max_shift_m + std::abs(a[3] - b[3]) / max_turn_rad_ <
           share;
  }

  std::vector<Move> Starts() const;
  void Describe(const std::vector<ImageCheck>& before, const Move& move,
                ImageRefinement& result) const;
  PoseCovariance Covariance(const std::vector<EquationsByPart>& equations, const Move& move) const;

  const AnnotationImages& images_;
  const OutlineModel& model_;
  Motion motion_;
  const Occluders& occluders_;
  const ImageRefinementOptions& options_;
  const WorkContext& work_;
  Eigen::Matrix<double, 4, Eigen::Dynamic> free_;
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

std::vector<Move> Refiner::Starts() const {
  std::vector<Move> starts = {Move::Zero()};
  if (options_.starts < 2 || options_.coarse_samples == 0) return starts;
  const Observations observations =
      Outline(Move::Zero(), OutlineOptions{}.own_scan_m + options_.max_shift_m);
  std::vector<std::unique_ptr<const OrientedTable>> tables;
  for (const AnnotationImage& image : images_.images()) {
    OrientedTableOptions table;
    table.power = 1;
    tables.push_back(std::make_unique<OrientedTable>(HalfSize(image.edges), table));
  }
  std::vector<Move> moves;
  for (int i = 1; i <= options_.coarse_samples; ++i) {
    constexpr int kBases[4] = {2, 3, 5, 7};
    Eigen::VectorXd by(free_.cols());
    for (Eigen::Index k = 0; k < by.size(); ++k) {
      const bool turn = k + 1 == by.size();
      by[k] = (turn ? max_turn_rad_ : options_.max_shift_m) * Halton(i, kBases[k]);
    }
    const Move move = free_ * by;
    if (Inside(move, 1.0)) moves.push_back(move);
  }
  std::vector<std::pair<double, int>> ranked(moves.size());
  tbb::parallel_for(std::size_t{0}, moves.size(), [&](std::size_t m) {
    double sum = 0;
    const Eigen::Isometry3d pose = motion_.At(moves[m]);
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const OrientedTable& table = *tables[i];
      for (const Observation& observation : observations[i]) {
        const auto pixel = Project(images_.images()[i], pose * observation.in_object);
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
    const Move& move = moves[static_cast<std::size_t>(m)];
    const bool known = std::any_of(starts.begin(), starts.end(),
                                   [&](const Move& other) { return Near(move, other, 0.35); });
    if (!known) starts.push_back(move);
  }
  return starts;
}

/// Covariance of the free parameters by leaving out one group of measurements at a time.
/// @param information  Of all, the prior included.
Eigen::MatrixXd Jackknife(const std::vector<Equations>& groups, double scale,
                          const Eigen::MatrixXd& information, const Eigen::MatrixXd& free) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(information.rows(), information.cols());
  int used = 0;
  for (const Equations& group : groups) {
    if (group.samples == 0) continue;
    ++used;
    const Eigen::MatrixXd without =
        information - scale * free.transpose() * group.information * free;
    const Eigen::VectorXd moved = without.ldlt().solve(scale * free.transpose() * group.gradient);
    covariance += moved * moved.transpose();
  }
  if (used > 1) covariance *= (used - 1.0) / used;
  return covariance;
}

PoseCovariance Refiner::Covariance(const std::vector<EquationsByPart>& equations,
                                   const Move& move) const {
  std::vector<Equations> by_image, by_part(kParts);
  for (const EquationsByPart& parts : equations) {
    Equations& image = by_image.emplace_back();
    for (std::size_t k = 0; k < kParts; ++k) {
      image += parts[k];
      by_part[k] += parts[k];
    }
  }
  const Equations sum = Sum(equations);
  const double scale = Scale(sum);
  const Eigen::MatrixXd information =
      free_.transpose() * (scale * sum.information + Information(prior_)) * free_;
  const Eigen::VectorXd outward = information.ldlt().solve(
      kOutwardSigma_px * images_.camera().width / 640.0 * scale * free_.transpose() * sum.outward);
  const Eigen::MatrixXd of_free = information.inverse() + outward * outward.transpose() +
                                  Jackknife(by_image, scale, information, free_) +
                                  Jackknife(by_part, scale, information, free_);
  const Eigen::Matrix4d of_move = free_ * of_free * free_.transpose();
  Eigen::Matrix<double, 6, 4> pose_from_move = Eigen::Matrix<double, 6, 4>::Zero();
  pose_from_move.topLeftCorner<3, 3>().setIdentity();
  pose_from_move.topRightCorner<3, 1>() =
      -motion_.up().cross(motion_.At(move).linear() * motion_.middle());
  pose_from_move.bottomRightCorner<3, 1>() = motion_.up();
  return pose_from_move * of_move * pose_from_move.transpose();
}

double MedianOffset(const std::vector<ImageCheck>& checks) {
  std::vector<double> offsets;
  for (const ImageCheck& check : checks) {
    if (check.visible_px > 0) offsets.push_back(check.median_offset_px);
  }
  if (offsets.empty()) return 0;
  std::sort(offsets.begin(), offsets.end());
  return offsets[offsets.size() / 2];
}

void Refiner::Describe(const std::vector<ImageCheck>& before, const Move& move,
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
    for (const Equations& part : parts) samples += part.samples;
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
