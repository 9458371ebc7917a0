// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/birth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/mapping/sparse_points.h"

namespace plumbline {
namespace {

constexpr int kCandidatesPerParticle = 8;
constexpr double kOnSomething = 0.5;       ///< Of what need not stand on the floor.
constexpr double kShortestSight_m = 0.15;  ///< Nearer than this nothing is seen.
/// Boxes exceed what they hold by up to this factor, before an object would be too far away.
constexpr double kBoxTooLarge = 1.5;
constexpr double kOffPoints = 0.1;  ///< Weight of what is before or behind all that the box shows.
/// What the best candidate must reach: one side of the proposal may be missed by a third of its
/// size.
constexpr double kLeastExplained = 0.01;

/// Of a new hypothesis.
double DrawLogScale(const MapperOptions& options, Random& random) {
  return options.scale_std > 0 ? options.scale_std * random.Gaussian() : 0.0;
}

/// How well a box of the whole object explains a proposal that may show only a part of it.
/// Detectors box what they see, so the whole may reach beyond the proposal, at the bottom above
/// all; it must not fall short of it.
double Explains(const Box2& whole, const Box2& proposal, const PinholeCamera& camera) {
  const Box2 image{0, 0, static_cast<float>(camera.width - 1),
                   static_cast<float>(camera.height - 1)};
  const Box2 clipped = Intersection(whole, image);
  if (clipped.empty()) return 0;
  const double sx = 0.12 * proposal.width(), sy = 0.12 * proposal.height();
  // Positive: the object reaches beyond the proposal.
  const double left = (proposal.x0 - clipped.x0) / sx, right = (clipped.x1 - proposal.x1) / sx;
  const double top = (proposal.y0 - clipped.y0) / sy, bottom = (clipped.y1 - proposal.y1) / sy;
  const auto side = [](double beyond, double hidden_share) {
    const double fit = std::exp(-0.5 * beyond * beyond);
    return beyond > 0 ? (1 - hidden_share) * fit + hidden_share : fit + 1e-3;
  };
  return side(left, 0.1) * side(right, 0.1) * side(top, 0.03) * side(bottom, 0.4);
}

PoseHypothesis PaperCandidate(const Detection& proposal, const PinholeCamera& camera,
                              const Eigen::Isometry3d& world_from_cam, ModelId label,
                              const MapperOptions& options, Random& random) {
  const double u = proposal.box.center_x() +
                   options.bearing_std_boxes * proposal.box.width() * random.Gaussian();
  const double v = proposal.box.center_y() +
                   options.bearing_std_boxes * proposal.box.height() * random.Gaussian();
  const double depth =
      std::exp(std::log(options.nominal_depth_m) + options.nominal_depth_std * random.Gaussian());
  const Eigen::Vector2d bearing = camera.Bearing({u, v});
  const double azimuth = random.Uniform(-std::numbers::pi, std::numbers::pi);
  return {label, azimuth,
          world_from_cam * Eigen::Vector3d(depth * bearing.x(), depth * bearing.y(), depth),
          DrawLogScale(options, random)};
}

/// How far from the camera the centre of a shape may be whose box, in whole or in part, is this.
DepthSpan DepthsOf(const CadModel& model, const Box2& box, const PinholeCamera& camera) {
  const Eigen::Vector3d size = model.bounds.sizes().cast<double>();
  const double nearest = kShortestSight_m + 0.5 * size.minCoeff();
  const double seen = std::max(box.width() / camera.fx, box.height() / camera.fy);
  return {nearest, std::max(2 * nearest, kBoxTooLarge * size.norm() / seen)};
}

PoseHypothesis InformedCandidate(const Detection& proposal, const PinholeCamera& camera,
                                 const Eigen::Isometry3d& world_from_cam, const MapFrame& map,
                                 ModelId label, const MapperOptions& options, Random& random) {
  const Box2& box = proposal.box;
  const double u = random.Uniform(box.x0 - 0.25 * box.width(), box.x1 + 0.25 * box.width());
  const double v = random.Uniform(box.y0 - 0.25 * box.height(), box.y1 + 0.75 * box.height());
  const auto [nearest, farthest] = DepthsOf(map.database->model(label), box, camera);
  const double depth = std::exp(random.Uniform(std::log(nearest), std::log(farthest)));
  const Eigen::Vector2d bearing = camera.Bearing({u, v});
  const double azimuth = random.Uniform(-std::numbers::pi, std::numbers::pi);
  PoseHypothesis hypothesis{
      label, azimuth,
      world_from_cam * Eigen::Vector3d(depth * bearing.x(), depth * bearing.y(), depth),
      DrawLogScale(options, random)};
  if (options.floor_prior && map.StandsOnFloor(label)) {
    const std::vector<MapFrame::Standing> places = map.StandingsAt(hypothesis.center_in_world);
    const MapFrame::Standing place =
        places.size() == 1 ? places.front()
                           : places[random.Index(static_cast<std::uint32_t>(places.size()))];
    hypothesis.center_in_world +=
        (place.height_m + std::hypot(map.BaseStd(options), place.std_m) * random.Gaussian() -
         map.BaseHeight(hypothesis)) *
        map.upright.up_in_world();
  } else if (options.floor_prior && !map.supports.empty() &&
             map.database->model(label).support != Support::kFloor &&
             random.Uniform() < kOnSomething) {
    const auto& surface =
        map.supports[random.Index(static_cast<std::uint32_t>(map.supports.size()))];
    hypothesis.center_in_world =
        map.upright.upright_rotation() *
        (surface.Draw(random) +
         Eigen::Vector3d(0, 0, hypothesis.scale() * map.database->model(label).center().z()));
  }
  return hypothesis;
}

}  // namespace

std::optional<Box2> ProjectedBounds(const CadModel& model, const PoseHypothesis& hypothesis,
                                    const MapFrame& map, const PinholeCamera& camera,
                                    const Eigen::Isometry3d& cam_from_world) {
  const Eigen::Isometry3d cam_from_object = cam_from_world * map.WorldFromObject(hypothesis);
  const Eigen::AlignedBox3d bounds = Scaled(model.bounds, hypothesis.scale());
  Box2 box{1e9f, 1e9f, -1e9f, -1e9f};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point =
        cam_from_object * bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if (point.z() < 0.1) return std::nullopt;
    const Eigen::Vector2f pixel = camera.Project(point).cast<float>();
    box = {std::min(box.x0, pixel.x()), std::min(box.y0, pixel.y()), std::max(box.x1, pixel.x()),
           std::max(box.y1, pixel.y())};
  }
  return box;
}

double InsideFraction(const CadModel& model, const PoseHypothesis& hypothesis, const MapFrame& map,
                      const PinholeCamera& camera, const Eigen::Isometry3d& cam_from_world) {
  const std::optional<Box2> whole = ProjectedBounds(model, hypothesis, map, camera, cam_from_world);
  if (!whole) return 0;
  const Box2 image{0, 0, static_cast<float>(camera.width - 1),
                   static_cast<float>(camera.height - 1)};
  return Intersection(*whole, image).area() / std::max(1.0f, whole->area());
}

std::vector<PoseHypothesis> SampleBirth(const Detection& proposal, const PinholeCamera& camera,
                                        const Eigen::Isometry3d& world_from_cam,
                                        const MapFrame& map, const MapperOptions& options,
                                        int count, RandomKey key) {
  const std::vector<ModelId> labels = map.database->OfCategory(proposal.category);
  std::vector<PoseHypothesis> result;
  if (labels.empty() || proposal.box.empty()) return result;
  const Eigen::Isometry3d cam_from_world = world_from_cam.inverse();
  const bool informed = options.prior == SpawnPrior::kInformed;
  const int candidates = informed ? count * kCandidatesPerParticle : count;
  const std::optional<DepthSpan> shown =
      informed ? DepthsInside(proposal.box, map.points_in_world, camera, cam_from_world)
               : std::nullopt;
  std::vector<PoseHypothesis> drawn;
  std::vector<double> sums;
  double sum = 0, best = 0;
  for (int i = 0; i < candidates; ++i) {
    key.particle = static_cast<std::uint32_t>(i);
    Random random(key);
    const ModelId label = labels[random.Index(static_cast<std::uint32_t>(labels.size()))];
    if (!informed) {
      result.push_back(PaperCandidate(proposal, camera, world_from_cam, label, options, random));
      continue;
    }
    const PoseHypothesis hypothesis =
        InformedCandidate(proposal, camera, world_from_cam, map, label, options, random);
    const std::optional<Box2> whole =
        ProjectedBounds(map.database->model(label), hypothesis, map, camera, cam_from_world);
    if (!whole) continue;
    double weight = Explains(*whole, proposal.box, camera);
    if (weight <= 0) continue;
    best = std::max(best, weight);
    if (shown) {
      const double depth = (cam_from_world * hypothesis.center_in_world).z();
      const double radius = 0.5 * map.database->model(label).bounds.diagonal().norm();
      if (depth < shown->nearest_m - radius || depth > shown->farthest_m + radius)
        weight *= kOffPoints;
    }
    drawn.push_back(hypothesis);
    sums.push_back(sum += weight);
  }
  if (!informed || best < kLeastExplained) return result;
  key.particle = static_cast<std::uint32_t>(candidates);
  Random random(key);
  const double start = random.Uniform();
  for (int i = 0; i < count; ++i) {
    const auto found = std::lower_bound(sums.begin(), sums.end(), (i + start) * sum / count);
    result.push_back(drawn[static_cast<std::size_t>(
        std::min(found - sums.begin(), std::ptrdiff_t(drawn.size()) - 1))]);
  }
  return result;
}

}  // namespace plumbline
