// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/scene_refiner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/geometry/angles.h"
#include "engine/smoothing/covariance.h"

namespace plumbline {
namespace {

constexpr int kRefinedViews = 16;
constexpr double kReach = 3;  ///< Of the refinement, in standard deviations of what was sampled.
constexpr double kLeastReach_m = 0.04, kMostReach_m = 0.15;
constexpr double kLeastReach_deg = 3, kMostReach_deg = 12;

/// The refinement looks as far as the sampled belief reaches.
ImageRefinementOptions RefinementOptions(const Eigen::Matrix4d& sampled) {
  const double position = std::sqrt(sampled.topLeftCorner<3, 3>().trace());
  const double azimuth = std::sqrt(sampled(3, 3)) / kRadPerDeg;
  ImageRefinementOptions options;
  options.max_shift_m = std::clamp(kReach * position, kLeastReach_m, kMostReach_m);
  options.max_turn_deg = std::clamp(kReach * azimuth, kLeastReach_deg, kMostReach_deg);
  options.starts = 6;
  options.coarse_samples = 600;
  return options;
}

}  // namespace

std::shared_ptr<const SolidModel> SceneRefiner::Solid(const PoseHypothesis& pose) {
  const std::pair key(pose.label.value, pose.log_scale);
  const auto found = solids_.find(key);
  if (found != solids_.end()) return found->second;
  const CadModel& model = setup_.database->model(pose.label);
  Result<SolidModel> solid =
      SolidModel::Prepare(pose.log_scale == 0 ? model : Scaled(model, pose.scale()));
  auto prepared = solid.ok() ? std::make_shared<const SolidModel>(std::move(solid).value())
                             : std::shared_ptr<const SolidModel>();
  return solids_.emplace(key, std::move(prepared)).first->second;
}

Occluders SceneRefiner::OccludersOf(std::span<const ObjectWork> items, const ObjectWork& item) {
  Occluders occluders;
  for (const ObjectWork& other : items) {
    if (!other.kept || other.object.id == item.object.id) continue;
    if (const auto solid = Solid(other.pose))
      occluders.models.push_back({solid->outline, map_.WorldFromObject(other.pose)});
  }
  return occluders;
}

void SceneRefiner::Claim(std::span<const ObjectWork> items) {
  std::vector<std::pair<int, const MapperInput*>> frames;
  for (const auto& [frame, input] : inputs_) frames.emplace_back(frame, &input);
  claims_.clear();
  for (const ObjectWork& item : items) {
    if (!item.kept) continue;
    const auto solid = Solid(item.pose);
    if (solid == nullptr) continue;
    const Occluders occluders = OccludersOf(items, item);
    std::vector<std::vector<EdgeClaim>> claims(frames.size());
    tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t k) {
      const MapperInput& input = *frames[k].second;
      const AnnotationImage image{frames[k].first, {}, input.edges, input.world_from_cam};
      claims[k] = ClaimsOf(CheckImage(image, setup_.camera, *solid->outline,
                                      map_.WorldFromObject(item.pose), occluders),
                           input.edges.probability.size());
    });
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (!claims[k].empty()) claims_[frames[k].first][item.object.id.value] = std::move(claims[k]);
    }
  }
}

EdgeMap SceneRefiner::EdgesFor(const ObjectWork& item, int frame) const {
  const EdgeMap& edges = inputs_.at(frame).edges;
  const auto claims = claims_.find(frame);
  if (claims == claims_.end()) return edges;
  std::vector<const std::vector<EdgeClaim>*> others;
  std::span<const EdgeClaim> own;
  for (const auto& [id, of] : claims->second) {
    if (id == item.object.id.value) {
      own = of;
    } else {
      others.push_back(&of);
    }
  }
  return ShareOf(edges, own, others);
}

Status SceneRefiner::Refine(ObjectWork& item, const Occluders& occluders,
                            const std::stop_token& stop) {
  const auto solid = Solid(item.pose);
  if (solid == nullptr) return {};
  std::vector<AnnotationImage> images;
  for (const std::size_t view : item.views) {
    const int frame = item.sights[view].frame;
    if (static_cast<int>(images.size()) == kRefinedViews || !inputs_.contains(frame)) continue;
    images.push_back({frame, {}, EdgesFor(item, frame), inputs_.at(frame).world_from_cam});
  }
  if (images.empty()) return {};
  WorkContext quiet;
  quiet.stop = stop;
  Result<ImageRefinement> refined =
      RefineByImages(*AnnotationImages::FromImages(setup_.camera, std::move(images)),
                     *solid->outline, map_.WorldFromObject(item.pose), map_.upright.up_in_world(),
                     occluders, RefinementOptions(item.covariance), quiet);
  if (!refined.ok()) {
    // Images that do not show enough leave the sampled pose.
    return refined.error().code == ErrorCode::kCancelled ? Status(refined.error()) : Status();
  }
  const CadModel& model = setup_.database->model(item.pose.label);
  const Eigen::Isometry3d& pose = refined->scan_from_object;
  const Eigen::Vector3d center = item.pose.scale() * model.center();
  item.pose.center_in_world = pose * center;
  item.pose.azimuth_rad = map_.upright.Azimuth(pose.linear());
  item.covariance =
      HotellingFactor(refined->images) *
      CentreCovariance(refined->covariance, pose.linear(), center, map_.upright.up_in_world());
  item.refined = std::move(refined).value();
  return {};
}

}  // namespace plumbline
