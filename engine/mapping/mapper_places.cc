// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "engine/mapping/mapper_impl.h"

namespace plumbline {

std::vector<SupportSurface> Mapper::Impl::FindSupports() const {
  std::vector<SupportSurface> supports;
  for (const MapObject& object : objects) {
    if (object.state != ObjectState::kConfirmed) continue;
    const ModelId label = object.mean().label;
    const std::optional<double> height = support_heights[static_cast<std::size_t>(label.value)];
    if (!height || setup.database->model(label).support != Support::kFloor) continue;
    // The spread of its top, as place and size have it. What views share is left out: what stands
    // on it is seen by the same views, and errs with it.
    double weight = 0, sum = 0, squares = 0;
    for (const Particle& particle : object.particles) {
      if (particle.label != label.value) continue;
      const PoseHypothesis hypothesis = ToHypothesis(particle, object.world_from_reference_cam);
      const double top = map.BaseInUpright(hypothesis).z() + hypothesis.scale() * *height;
      const double w = std::exp(static_cast<double>(particle.log_weight));
      weight += w;
      sum += w * top;
      squares += w * top * top;
    }
    if (weight <= 0) continue;
    const double variance = std::max(0.0, squares / weight - sum * sum / (weight * weight));
    supports.push_back(MakeSupportSurface(
        setup.database->model(label), *height, object.mean().world_from_object, object.mean().scale,
        map.upright, std::hypot(std::sqrt(variance), options().contact_std_m)));
    supports.back().object = object.id;
  }
  return supports;
}

std::vector<TakenPlace> Mapper::Impl::TakenPlaces(const MapObject& object) const {
  std::vector<TakenPlace> taken;
  for (const MapObject& other : objects) {
    if (other.category != object.category || other.id == object.id) continue;
    // A chair of which a rail shows above a table is known long before it is confirmed, and would
    // draw its neighbours' hypotheses until then.
    const bool has_it =
        other.state == ObjectState::kConfirmed ||
        (other.state == ObjectState::kTentative && object.state == ObjectState::kTentative &&
         other.log_evidence > object.log_evidence && IsPlaced(other));
    if (!has_it) continue;
    const TakenPlace place = PlaceOf(setup.database->model(other.mean().label),
                                     other.mean().world_from_object, other.mean().scale);
    // Of two settled ones in one place both have a claim: they compete, and one is merged.
    if (object.state == ObjectState::kConfirmed &&
        place.Holds(ToHypothesis(object.mean(), map).center_in_world))
      continue;
    taken.push_back(place);
  }
  return taken;
}

std::vector<SupportSurface> Mapper::Impl::TopsOfOthers(const MapObject& object) const {
  std::vector<SupportSurface> tops;
  if (!options().floor_prior) return tops;
  std::copy_if(map.supports.begin(), map.supports.end(), std::back_inserter(tops),
               [&](const SupportSurface& top) {
                 return std::any_of(objects.begin(), objects.end(), [&](const MapObject& other) {
                   return other.id == top.object && other.category != object.category;
                 });
               });
  return tops;
}

Target Mapper::Impl::Beside(const MapObject& object, Target target) const {
  // Of equal things in a row the one that shows best draws all; what is settled keeps its own.
  return Outside(TakenPlaces(object),
                 ClearOf(TopsOfOthers(object), sections, map, std::move(target)));
}

}  // namespace plumbline
