// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/reliability.h"

#include <cmath>
#include <numbers>

#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

constexpr double kTruthStd_m = 0.003, kTruthStd_rad = 0.5 * std::numbers::pi / 180;

}  // namespace

Reliability ReliabilityOf(const RunHistory& history, ObjectId only) {
  Reliability result;
  for (const auto& frame : history.frames) {
    if (frame == nullptr) continue;
    for (const ObjectSample& object : frame->objects) {
      if (only.value > 0 && object.id != only) continue;
      if (object.state != ObjectState::kConfirmed || !object.updated || !object.error) continue;
      if (object.error->translation_m > kReliabilityReach_m) continue;
      ++result.poses;
      result.within_50 += object.error->credible_level <= 0.5f;
      result.within_95 += object.error->credible_level <= 0.95f;
      if (object.label_probability.empty()) continue;
      const double claimed = object.label_probability.front().probability;
      Reliability::Bin* bin = &result.bins.front();
      for (Reliability::Bin& candidate : result.bins) {
        if (claimed >= candidate.above) bin = &candidate;
      }
      ++bin->labels;
      bin->right += object.error->model_correct;
      bin->claimed += claimed;
    }
  }
  double sum = 0;
  for (const Reliability::Bin& bin : result.bins) {
    result.labels += bin.labels;
    result.right += bin.right;
    sum += bin.claimed;
  }
  if (result.labels > 0) result.claimed = sum / result.labels;
  return result;
}

double CredibleLevel(const Eigen::Vector4d& offset, const Eigen::Matrix4d& covariance, bool round) {
  Eigen::Matrix4d widened = covariance;
  widened.diagonal().head<3>().array() += kTruthStd_m * kTruthStd_m;
  widened(3, 3) += kTruthStd_rad * kTruthStd_rad;
  if (round) {
    const Eigen::Vector3d place = offset.head<3>();
    const Eigen::Matrix3d spread = widened.topLeftCorner<3, 3>();
    const double d2 = place.dot(SolveSymmetric(spread, place));
    // The distribution of chi squared with three degrees of freedom.
    return std::erf(std::sqrt(0.5 * d2)) -
           std::sqrt(2 * d2 / std::numbers::pi) * std::exp(-0.5 * d2);
  }
  const double d2 = offset.dot(SolveSymmetric(widened, offset));
  return 1 - std::exp(-0.5 * d2) * (1 + 0.5 * d2);  // with four
}

}  // namespace plumbline
