// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/scale_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <Eigen/Cholesky>

#include "engine/registration/icp.h"

namespace plumbline {
namespace {

constexpr double kFirstReach_m = 0.06, kLeastReach_m = 2e-3, kCropSearch_m = 0.1;
constexpr double kPatchSize_m = 0.15, kTukey = 4.685, kLeastCosine = 0.5;
constexpr int kApproach = 12, kMostSteps = 60;
constexpr std::size_t kFewestMatches = 30;

/// Of (free moves of the pose, scale) by one point: how its distance changes with each.
struct Match {
  Eigen::Vector3d in_scan, normal;
  Eigen::VectorXd gradient;
  double distance_m = 0, weight = 0;
};

class ScaleFitter {
 public:
  ScaleFitter(const AlignmentCrop& crop, const ModelSurface& model, double scale,
              const Eigen::Isometry3d& pose, const Eigen::Vector3d& up, FreeMotion motion,
              const ScalePrior& prior)
      : crop_(crop),
        model_(model),
        scale_(scale),
        pose_(pose),
        prior_(prior),
        free_(FreeMoves(up, motion)) {}

  /// False if there is nothing to fit to.
  bool Run(const WorkContext& context, ScaleFit& fit) {
    for (int step = 0; step < kMostSteps && !fit.converged; ++step) {
      if (context.stop.stop_requested()) return true;
      const double share = std::min(1.0, static_cast<double>(step) / kApproach);
      FindMatches(kFirstReach_m * std::pow(0.5, share));
      if (matches_.size() < kFewestMatches) return false;
      Weigh(step <= kApproach + 10);
      fit.converged = Step() < 1e-6 && step > kApproach;
    }
    // With what its parts contradict each other by counted in, the prior may say more.
    widening_ = Widening();
    fit.converged = false;
    for (int step = 0; step < kMostSteps && !fit.converged; ++step) {
      if (context.stop.stop_requested()) return true;
      FindMatches(kFirstReach_m / 2);
      if (matches_.size() < kFewestMatches) return false;
      Weigh(false);
      fit.converged = Step() < 1e-6;
    }
    fit.scale = scale_;
    fit.scale_std = std::sqrt(Covariance()(last(), last()));
    fit.scan_from_model = pose_;
    fit.points = static_cast<int>(matches_.size());
    return true;
  }

 private:
  /// Columns: (translation, rotation vector on the left) of each free move.
  static Eigen::MatrixXd FreeMoves(const Eigen::Vector3d& up, FreeMotion motion) {
    Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(6, DegreesOfFreedom(motion));
    const Eigen::Vector3d across = up.unitOrthogonal();
    if (motion == FreeMotion::kRigid) return Eigen::MatrixXd::Identity(6, 6);
    moves.col(0).tail<3>() = up;
    if (motion == FreeMotion::kAzimuth) return moves;
    moves.col(1).head<3>() = across;
    moves.col(2).head<3>() = up.cross(across);
    if (motion == FreeMotion::kAzimuthAndTranslation) moves.col(3).head<3>() = up;
    return moves;
  }

  Eigen::Index last() const { return free_.cols(); }

  void FindMatches(double reach_m) {
    matches_.clear();
    const Eigen::Isometry3d model_from_scan = pose_.inverse();
    for (std::size_t i = 0; i < crop_.fine.points.size(); ++i) {
      const Eigen::Vector3d in_scan = crop_.fine.points[i].cast<double>();
      const auto closest =
          model_.triangles().FindWithin(model_from_scan * in_scan / scale_, reach_m / scale_);
      if (!closest) continue;
      const ModelSurface::Face face = model_.face(closest->triangle);
      const Eigen::Vector3d normal = pose_.linear() * face.normal;
      const double cosine = normal.dot(crop_.fine.normals[i].cast<double>());
      const bool any_sign = !crop_.normals_face_out || face.two_sided;
      if ((any_sign ? std::abs(cosine) : cosine) < kLeastCosine) continue;
      const Eigen::Vector3d grown = pose_.linear() * closest->point;  // from the origin, unscaled
      const Eigen::Vector3d offset = scale_ * grown;
      Match match{in_scan, normal, Eigen::VectorXd(last() + 1)};
      match.gradient.head(last()) = free_.topRows<3>().transpose() * normal +
                                    free_.bottomRows<3>().transpose() * offset.cross(normal);
      match.gradient(last()) = normal.dot(grown);
      match.distance_m = normal.dot(pose_.translation() + offset - in_scan);
      matches_.push_back(std::move(match));
    }
  }

  void Weigh(bool adapt) {
    if (adapt) {
      std::vector<double> sizes;
      for (const Match& match : matches_) sizes.push_back(std::abs(match.distance_m));
      const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
      std::nth_element(sizes.begin(), middle, sizes.end());
      sigma_m_ = std::max(1.4826 * *middle, kLeastReach_m / kTukey);
    }
    for (Match& match : matches_) {
      const double share = match.distance_m / (kTukey * sigma_m_);
      match.weight = std::abs(share) < 1 ? std::pow(1 - share * share, 2) : 0;
    }
  }

  Eigen::MatrixXd Information() const {
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(last() + 1, last() + 1);
    for (const Match& match : matches_)
      information += match.weight * match.gradient * match.gradient.transpose();
    return information;
  }

  /// How many times fewer measurements the points are, for the scale.
  double Effect(const Eigen::MatrixXd& inverse) const {
    std::map<std::tuple<int, int, int>, double> patches;
    double alone = 0;
    for (const Match& match : matches_) {
      const Eigen::Vector3i at =
          (match.in_scan / kPatchSize_m).array().floor().matrix().cast<int>();
      const double pull = match.weight * match.distance_m * inverse.row(last()).dot(match.gradient);
      patches[{at.x(), at.y(), at.z()}] += pull;
      alone += pull * pull;
    }
    double together = 0;
    for (const auto& [at, pull] : patches) together += pull * pull;
    return widening_ * (alone > 0 ? std::max(1.0, together / alone) : 1.0);
  }

  Eigen::MatrixXd Damped(const Eigen::MatrixXd& information) const {
    return information +
           1e-9 * information.trace() * Eigen::MatrixXd::Identity(last() + 1, last() + 1);
  }

  /// How many times larger the variance of the scale is by the jackknife over octants about the
  /// middle of the points, without the prior; at least 1.
  double Widening() const {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Match& match : matches_) middle += match.in_scan;
    middle /= static_cast<double>(matches_.size());
    const Eigen::MatrixXd all = Information();
    std::vector<Eigen::MatrixXd> without(8, all);
    std::vector<Eigen::VectorXd> pulls(8, Eigen::VectorXd::Zero(last() + 1));
    std::vector<bool> has_points(8, false);
    for (const Match& match : matches_) {
      const Eigen::Vector3d at = match.in_scan - middle;
      const auto octant =
          static_cast<std::size_t>((at.x() > 0) + 2 * (at.y() > 0) + 4 * (at.z() > 0));
      has_points[octant] = has_points[octant] || match.weight > 0;
      without[octant] -= match.weight * match.gradient * match.gradient.transpose();
      for (std::size_t i = 0; i < 8; ++i)
        if (i != octant) pulls[i] -= match.weight * match.distance_m * match.gradient;
    }
    std::vector<double> moved;
    for (std::size_t i = 0; i < 8; ++i) {
      if (has_points[i]) moved.push_back((Damped(without[i]).inverse() * pulls[i])(last()));
    }
    double mean = 0, squares = 0;
    for (const double each : moved) mean += each / static_cast<double>(moved.size());
    for (const double each : moved) squares += (each - mean) * (each - mean);
    const auto parts = static_cast<double>(moved.size());
    const Eigen::MatrixXd inverse = Damped(all).inverse();
    const double variance = inverse(last(), last()) * sigma_m_ * sigma_m_ * Effect(inverse);
    return std::max(1.0, (parts - 1) / parts * squares / variance);
  }

  /// What the pairs and the prior say together.
  Eigen::MatrixXd Covariance() const {
    Eigen::MatrixXd information = Information();
    const Eigen::MatrixXd damping =
        1e-9 * information.trace() * Eigen::MatrixXd::Identity(last() + 1, last() + 1);
    const Eigen::MatrixXd inverse = (information + damping).inverse();
    information /= sigma_m_ * sigma_m_ * Effect(inverse);
    information(last(), last()) += 1 / (prior_.std * prior_.std);
    return (information + damping).inverse();
  }

  /// Its size, in metres, radians and parts of the model's size, the largest.
  double Step() {
    const Eigen::MatrixXd covariance = Covariance();
    Eigen::VectorXd pull = Eigen::VectorXd::Zero(last() + 1);
    for (const Match& match : matches_) pull -= match.weight * match.distance_m * match.gradient;
    const Eigen::MatrixXd information = Information();
    const Eigen::MatrixXd inverse =
        (information +
         1e-9 * information.trace() * Eigen::MatrixXd::Identity(last() + 1, last() + 1))
            .inverse();
    pull /= sigma_m_ * sigma_m_ * Effect(inverse);
    pull(last()) += (prior_.mean - scale_) / (prior_.std * prior_.std);
    const Eigen::VectorXd step = covariance * pull;
    const Eigen::Matrix<double, 6, 1> move = free_ * step.head(last());
    const double turn = move.tail<3>().norm();
    if (turn > 0) pose_.linear() = Eigen::AngleAxisd(turn, move.tail<3>() / turn) * pose_.linear();
    pose_.translation() += move.head<3>();
    scale_ = std::clamp(scale_ + step(last()), 0.5, 2.0);
    return step.cwiseAbs().maxCoeff();
  }

  const AlignmentCrop& crop_;
  const ModelSurface& model_;
  double scale_;
  Eigen::Isometry3d pose_;
  ScalePrior prior_;
  Eigen::MatrixXd free_;
  double sigma_m_ = 0.01;
  double widening_ = 1;  ///< Of the variance of the points, as of Widening.
  std::vector<Match> matches_;
};

}  // namespace

Result<ScaleFit> FitScale(const ScanTarget& scan, const ModelSurface& model, double start_scale,
                          const Eigen::Isometry3d& scan_from_model,
                          const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                          const ScalePrior& prior, const WorkContext& context) {
  const AlignmentCrop crop = CropScan(scan, model, scan_from_model, up_in_scan, kCropSearch_m);
  ScaleFit fit;
  ScaleFitter fitter(crop, model, start_scale, scan_from_model, up_in_scan, motion, prior);
  if (!fitter.Run(context, fit)) {
    return Error{ErrorCode::kDegenerate,
                 "there is too little scan around this object to find its scale"};
  }
  if (context.stop.stop_requested())
    return Error{ErrorCode::kCancelled, "the alignment was stopped"};
  return fit;
}

}  // namespace plumbline
