// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/annotator_agreement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/evaluation/pose_error.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr double kCopied_m = 1e-9, kCopied_rad = 1e-9;

std::vector<PlacedThing> ThingsOf(const GroundTruth& truth) {
  std::vector<PlacedThing> things;
  for (const GroundTruthInstance& instance : truth.instances) {
    const std::string& kind = instance.category.empty() ? instance.model : instance.category;
    things.push_back({kind, instance.world_from_object.translation()});
  }
  return things;
}

AgreedObject Compare(const GroundTruthInstance& first, const GroundTruthInstance& second,
                     const ModelDatabase* models, const UprightFrame& upright) {
  AgreedObject object{.first = first, .second = second};
  object.same_model = first.model == second.model;
  object.fine = first.fine && second.fine;
  const auto model =
      models != nullptr && object.same_model ? models->Find(first.model) : std::nullopt;
  const PoseError error =
      ComparePoses(first.world_from_object, second.world_from_object,
                   model ? models->model(*model).symmetry : Symmetry(), upright);
  object.difference_m =
      upright.upright_rotation().transpose() *
      (first.world_from_object.translation() - second.world_from_object.translation());
  object.azimuth_rad = error.azimuth_rad;
  object.tilt_rad = error.tilt_rad;
  object.position_std_m = error.translation_m / std::numbers::sqrt2;
  if (error.azimuth_rad)
    object.azimuth_std_rad = std::abs(*error.azimuth_rad) / std::numbers::sqrt2;
  object.copied = error.translation_m < kCopied_m && error.rotation_rad < kCopied_rad;
  return object;
}

/// Sums of squares until Mean is called.
class Pool {
 public:
  void Add(const AgreedObject& object) {
    if (object.copied || !object.same_model) return;
    ++pooled_.objects;
    horizontal_ += object.difference_m.head<2>().squaredNorm();
    height_ += object.difference_m.z() * object.difference_m.z();
    if (!object.azimuth_rad) return;
    ++pooled_.azimuths;
    azimuth_ += *object.azimuth_rad * *object.azimuth_rad;
  }
  PooledDeviation Mean() const {
    PooledDeviation mean = pooled_;
    if (mean.objects > 0) {
      const double n = mean.objects;
      mean.horizontal_m = std::sqrt(horizontal_ / (4 * n));
      mean.height_m = std::sqrt(height_ / (2 * n));
      mean.position_std_m = std::sqrt((horizontal_ + height_) / (2 * n));
    }
    if (mean.azimuths > 0) mean.azimuth_std_rad = std::sqrt(azimuth_ / (2.0 * mean.azimuths));
    return mean;
  }

 private:
  PooledDeviation pooled_;
  double horizontal_ = 0, height_ = 0, azimuth_ = 0;
};

}  // namespace

AnnotatorAgreement CompareAnnotators(const GroundTruth& first, const GroundTruth& second,
                                     const ModelDatabase* models, double reach_m) {
  const UprightFrame upright(first.gravity_in_world);
  const auto pairs = PairWithTruth(ThingsOf(first), ThingsOf(second), reach_m);
  AnnotatorAgreement agreement;
  std::vector<bool> taken(second.instances.size(), false);
  Pool fine, coarse, all;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i]) {
      agreement.only_first.push_back(first.instances[i]);
      continue;
    }
    const auto j = static_cast<std::size_t>(*pairs[i]);
    taken[j] = true;
    const AgreedObject& object = agreement.objects.emplace_back(
        Compare(first.instances[i], second.instances[j], models, upright));
    (object.fine ? fine : coarse).Add(object);
    all.Add(object);
  }
  for (std::size_t j = 0; j < taken.size(); ++j) {
    if (!taken[j]) agreement.only_second.push_back(second.instances[j]);
  }
  agreement.fine = fine.Mean();
  agreement.coarse = coarse.Mean();
  agreement.all = all.Mean();
  return agreement;
}

void SetDeviations(const AnnotatorAgreement& agreement, GroundTruth& first) {
  for (const AgreedObject& object : agreement.objects) {
    const PooledDeviation& pooled = object.fine ? agreement.fine : agreement.coarse;
    if (object.copied || !object.same_model || pooled.objects < kLeastPooled) continue;
    const auto instance =
        std::find_if(first.instances.begin(), first.instances.end(),
                     [&](const GroundTruthInstance& i) { return i.id == object.first.id; });
    if (instance == first.instances.end()) continue;
    instance->position_std_m = std::max(pooled.position_std_m, object.position_std_m);
    if (object.azimuth_std_rad && pooled.azimuths >= kLeastPooled)
      instance->azimuth_std_rad = std::max(pooled.azimuth_std_rad, *object.azimuth_std_rad);
  }
}

}  // namespace plumbline
