// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/geometry/gravity.h"
#include "engine/registration/sequence_frames.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kMiddleSigma_m = 0.02;
constexpr double kPartners_m = 0.5;

/// Which annotated object each mapped one meets, nearest first, each once; -1: none.
std::vector<int> Partners(const std::vector<PosedObject>& mapped,
                          const std::vector<PosedObject>& annotated, const Isometry3d& pose) {
  struct Offer {
    double distance;
    std::size_t mapped, annotated;
  };
  std::vector<Offer> offers;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    for (std::size_t j = 0; j < annotated.size(); ++j) {
      if (mapped[i].kind != annotated[j].kind) continue;
      const double distance =
          (pose * mapped[i].pose.translation() - annotated[j].pose.translation()).norm();
      if (distance < kPartners_m) offers.push_back({distance, i, j});
    }
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const Offer& a, const Offer& b) { return a.distance < b.distance; });
  std::vector<int> partners(mapped.size(), -1);
  std::vector<char> taken(annotated.size(), 0);
  for (const Offer& offer : offers) {
    if (partners[offer.mapped] >= 0 || taken[offer.annotated]) continue;
    partners[offer.mapped] = static_cast<int>(offer.annotated);
    taken[offer.annotated] = 1;
  }
  return partners;
}

std::vector<PointPair> PairsOf(const std::vector<PosedObject>& mapped,
                               const std::vector<PosedObject>& annotated,
                               const std::vector<int>& partners) {
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    if (partners[i] < 0) continue;
    PointPair pair;
    pair.in_model = mapped[i].pose.translation();
    pair.in_scan = annotated[static_cast<std::size_t>(partners[i])].pose.translation();
    pairs.push_back(pair);
  }
  return pairs;
}

/// Every place at which one object lies on one of its kind the way that it is turned, or two lie on
/// two: the latter needs no turn, which symmetric objects do not have.
std::vector<Isometry3d> PlacesOf(const std::vector<PosedObject>& mapped,
                                 const std::vector<PosedObject>& annotated,
                                 const GravityPair& gravity) {
  std::vector<Isometry3d> places;
  const UprightFrame upright(gravity.in_scan);
  std::vector<PointPair> single;
  for (const PosedObject& a : mapped) {
    for (const PosedObject& b : annotated) {
      if (a.kind != b.kind) continue;
      PointPair pair;
      pair.in_model = a.pose.translation();
      pair.in_scan = b.pose.translation();
      single.push_back(pair);
      Isometry3d place = UprightPlace(gravity, 0, Vector3d::Zero());
      place = UprightPlace(
          gravity,
          upright.Azimuth(b.pose.linear()) - upright.Azimuth(place.linear() * a.pose.linear()),
          Vector3d::Zero());
      place.translation() = pair.in_scan - place.linear() * pair.in_model;
      places.push_back(place);
    }
  }
  for (std::size_t i = 0; i < single.size(); ++i) {
    for (std::size_t j = i + 1; j < single.size(); ++j) {
      const double apart = (single[i].in_model - single[j].in_model).norm();
      const double apart_in_scan = (single[i].in_scan - single[j].in_scan).norm();
      if (apart < kPartners_m || std::abs(apart - apart_in_scan) > kPartners_m) continue;
      ConstrainedPose pose(UprightPlace(gravity, 0, Vector3d::Zero()), -gravity.in_scan,
                           FreeMotion::kAzimuthAndTranslation);
      const PointPair two[] = {single[i], single[j]};
      if (pose.FitPoints(two).ok()) places.push_back(pose.scan_from_model());
    }
  }
  return places;
}

double Squares(const std::vector<PointPair>& pairs, const Isometry3d& pose) {
  double squares = 0;
  for (const PointPair& pair : pairs)
    squares += (pose * pair.in_model - pair.in_scan).squaredNorm();
  return squares;
}

/// Of the middle, if the distances are independent.
void SetDeviations(const std::vector<PointPair>& pairs, const GravityPair& gravity,
                   SequenceAlignment& alignment) {
  const auto count = static_cast<double>(pairs.size());
  Vector3d middle = Vector3d::Zero();
  for (const PointPair& pair : pairs) middle += pair.in_scan / count;
  double spread = 0;
  for (const PointPair& pair : pairs) {
    spread += (pair.in_scan - middle).cross(gravity.in_scan).squaredNorm();
  }
  const double equations = std::max(1.0, 3 * count - 4);
  const double sigma =
      std::max(kMiddleSigma_m, std::sqrt(Squares(pairs, alignment.scan_from_world) / equations));
  alignment.position_std_m.setConstant(sigma / std::sqrt(count));
  alignment.azimuth_std_rad = sigma / std::sqrt(std::max(spread, 1e-6));
}

}  // namespace

Result<SequenceAlignment> AlignByObjects(const std::vector<PosedObject>& mapped_in_world,
                                         const std::vector<PosedObject>& annotated_in_scan,
                                         const GravityPair& gravity) {
  if (const Status status = CheckGravity(gravity); !status.ok()) return status.error();
  Isometry3d best = Isometry3d::Identity();
  std::size_t most = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const Isometry3d& place : PlacesOf(mapped_in_world, annotated_in_scan, gravity)) {
    const auto pairs = PairsOf(mapped_in_world, annotated_in_scan,
                               Partners(mapped_in_world, annotated_in_scan, place));
    const double squares = Squares(pairs, place);
    if (pairs.size() < most || (pairs.size() == most && squares >= least)) continue;
    most = pairs.size();
    least = squares;
    best = place;
  }
  if (most < 2) {
    return Error{ErrorCode::kDegenerate,
                 "fewer than two mapped objects meet annotated ones of their kind; annotate more "
                 "of them, or pick pairs"};
  }
  ConstrainedPose pose(best, -gravity.in_scan, FreeMotion::kAzimuthAndTranslation);
  std::vector<int> partners;
  for (int i = 0; i < 5; ++i) {
    partners = Partners(mapped_in_world, annotated_in_scan, pose.scan_from_model());
    const auto pairs = PairsOf(mapped_in_world, annotated_in_scan, partners);
    if (const Status fitted = pose.FitPoints(pairs); !fitted.ok()) break;  // above one another
  }
  SequenceAlignment alignment;
  alignment.scan_from_world = pose.scan_from_model();
  const auto pairs = PairsOf(mapped_in_world, annotated_in_scan, partners);
  SetDeviations(pairs, gravity, alignment);
  const auto count = static_cast<double>(pairs.size());
  alignment.share = count / static_cast<double>(mapped_in_world.size());
  alignment.rmse_m = std::sqrt(Squares(pairs, alignment.scan_from_world) / count);
  for (std::size_t i = 0; i < mapped_in_world.size(); ++i) {
    alignment.residuals.push_back(-1);
    if (partners[i] < 0) continue;
    const auto j = static_cast<std::size_t>(partners[i]);
    alignment.residuals.back() =
        (alignment.scan_from_world * mapped_in_world[i].pose.translation() -
         annotated_in_scan[j].pose.translation())
            .norm();
  }
  return alignment;
}

}  // namespace plumbline
