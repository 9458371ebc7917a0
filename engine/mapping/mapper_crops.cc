// SPDX-License-Identifier: Apache-2.0
// What the crop of an object says of its shape and quarter turn (docs/algorithms/crops.md).
#include <algorithm>

#include "engine/mapping/mapper_impl.h"

namespace plumbline {
namespace {

/// Share of an object's contour that shows where its crop can be judged, and how far from where it
/// was looked at before another crop is taken, in key frames.
constexpr double kCropVisible = 0.45, kCropDistance = 2;

/// Quarter turns that look different.
std::size_t TurnsOf(const CadModel& model) {
  const int order = model.symmetry.order;
  if (order == 0 || order % 4 == 0) return 1;
  return order % 2 == 0 ? 2 : CropBelief::kTurns;
}

}  // namespace

void Mapper::Impl::LookAtCrop(MapObject& object, const MapperInput& input,
                              const ScoringView& view) const {
  if (setup.crops == nullptr || options().crop_sharpness <= 0 || input.image.empty() ||
      object.state != ObjectState::kConfirmed || object.log_evidence < kSettledLogOdds ||
      object.visible_fraction < kCropVisible || object.hidden > 0.5 ||
      object.crops.looked_from().size() >= CropBelief::kMostLooks)
    return;
  for (const Eigen::Isometry3d& seen_from : object.crops.looked_from())
    if (memory.Distance(seen_from, input.world_from_cam) < kCropDistance) return;
  const ModelDatabase& database = *setup.database;
  const std::vector<ModelId> labels = database.OfCategory(object.category);
  if (labels.size() == 1 && TurnsOf(database.model(labels.front())) == 1) return;
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  const auto above_base = [&](ModelId label) {
    return mean.scale() * database.model(label).center().z() * map.upright.up_in_world();
  };
  std::vector<PosedShape> shapes;
  std::vector<std::size_t> shape_of;  // of each candidate: those that look the same share one
  for (const CropBelief::Candidate& candidate : object.crops.Candidates(labels, mean.azimuth_rad)) {
    const std::size_t turns = TurnsOf(database.model(candidate.label));
    if (shape_of.size() % CropBelief::kTurns >= turns) {
      shape_of.push_back(shape_of[shape_of.size() - turns]);
      continue;
    }
    const PoseHypothesis pose{
        candidate.label, candidate.azimuth_rad,
        mean.center_in_world - above_base(mean.label) + above_base(candidate.label),
        mean.log_scale};
    shape_of.push_back(shapes.size());
    shapes.push_back({pose.label, view.cam_from_world * map.WorldFromObject(pose), pose.scale()});
  }
  const std::vector<std::optional<double>> of_shape = setup.crops->Compare(
      input.image, setup.camera, {view.occluder_depth, view.occlusion_margin_m}, shapes);
  std::vector<std::optional<double>> likeness;
  for (const std::size_t shape : shape_of) likeness.push_back(of_shape[shape]);
  object.crops.Add(input.world_from_cam, labels, mean.azimuth_rad, likeness);
}

}  // namespace plumbline
