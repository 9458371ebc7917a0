// SPDX-License-Identifier: Apache-2.0
// What is told of the shape of a settled object (docs/algorithms/semantic_filter.md, "Which
// shape").
#include <cmath>
#include <utility>

#include "engine/mapping/mapper_impl.h"

namespace plumbline {
namespace {

/// Shapes that fall short by more, once tempered, are not told of [nats].
constexpr double kFaintShape = 6;

}  // namespace

void Mapper::Impl::CompareShapes(MapObject& object, const Population& population, Target posterior,
                                 int frame) const {
  object.shapes_in_place.clear();
  if (setup.database->OfCategory(object.category).size() < 2) return;
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  Population in_place;
  for (std::size_t i = 0; i < population.size(); ++i) {
    if (population.hypotheses[i].label != mean.label || !IsSamePose(population.hypotheses[i], mean))
      continue;
    in_place.hypotheses.push_back(population.hypotheses[i]);
    in_place.judged.push_back(population.judged[i]);
  }
  PoseSampler sampler(map, options(), std::move(posterior),
                      Key(setup.seed, frame, object.id, Draw::kShapes));
  const double temperature = options().shape_temperature;
  double sum = 1;
  object.shapes_in_place.push_back({mean.label, 1});
  for (const ShapeRival& rival : sampler.RivalShapes(in_place, kFaintShape * temperature)) {
    const double odds = std::exp(std::min(0.0, rival.log_ratio) / temperature);
    object.shapes_in_place.push_back({rival.label, odds});
    sum += odds;
  }
  for (LabelProbability& shape : object.shapes_in_place) shape.probability /= sum;
  object.Summarize(map);
}

}  // namespace plumbline
