// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/particle_set.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "engine/vision/category_names.h"

namespace plumbline {
namespace {

constexpr double kModeRadius_m = 0.20, kModeCell_m = 0.15;  ///< Times LengthScale.
constexpr double kModeAngle_rad = 40.0 * std::numbers::pi / 180.0;
/// Lengths were measured on chairs, of a quarter of `room_thing_m`, and serve all furniture; on
/// cars those serve that are as large beside the car as they are beside a stool and a sofa
/// together.
constexpr double kLengthGrowth = 3;
constexpr double kMinModeWeight = 0.05;
constexpr int kMaxModes = 4;
constexpr double kNearestDepth_m = 0.05;

/// A particle as a point of its mode.
struct Sample {
  Eigen::Vector3d center;
  double azimuth;
  double weight;
  std::uint16_t label;
  double log_scale;
};

std::vector<Sample> ToSamples(std::span<const Particle> particles,
                              const Eigen::Isometry3d& world_from_reference_cam) {
  std::vector<Sample> samples;
  samples.reserve(particles.size());
  for (const Particle& particle : particles) {
    const PoseHypothesis hypothesis = ToHypothesis(particle, world_from_reference_cam);
    samples.push_back({hypothesis.center_in_world, hypothesis.azimuth_rad,
                       std::exp(particle.log_weight), particle.label, hypothesis.log_scale});
  }
  return samples;
}

/// By how much a sample of the mode is turned; nothing for one that is not of it.
std::optional<double> TurnInMode(const Sample& sample, const CadModel& model, double radius_m,
                                 const Eigen::Vector3d& center, double azimuth) {
  if (sample.label != model.id.value || !((sample.center - center).norm() < radius_m)) return {};
  const double turn = AzimuthDifference(model, sample.azimuth, azimuth);
  return std::abs(turn) < kModeAngle_rad ? std::optional(turn) : std::nullopt;
}

/// Cell of a grid over label, position and azimuth.
using CellKey = std::array<int, 5>;

CellKey CellOf(const Sample& sample, const MapFrame& map) {
  const CadModel& model = map.database->model(ModelId{sample.label});
  const double side = kModeCell_m * map.LengthScale(model.id);
  return {sample.label, static_cast<int>(std::floor(sample.center.x() / side)),
          static_cast<int>(std::floor(sample.center.y() / side)),
          static_cast<int>(std::floor(sample.center.z() / side)),
          static_cast<int>(std::floor(AzimuthDifference(model, sample.azimuth, 0.0) / 0.5))};
}

/// The first sample of the fullest cell; of cells that are equally full, of that of the least key.
std::size_t InFullestCell(std::span<const Sample> samples, std::span<const CellKey> keys) {
  struct Cell {
    std::size_t any, first;  ///< Samples of it; `first` is the first one that weighs anything.
    double weight;
  };
  std::vector<Cell> cells;
  // Every frame asks for it, for all objects: a table with open addressing, of indices of cells.
  std::vector<int> table(std::bit_ceil(2 * samples.size()), -1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::size_t hash = 0;
    for (const int part : keys[i])
      hash = (hash ^ static_cast<std::uint32_t>(part)) * 0x9e3779b97f4a7c15ull;
    std::size_t slot = (hash >> 32) & (table.size() - 1);
    while (table[slot] >= 0 && keys[cells[static_cast<std::size_t>(table[slot])].any] != keys[i])
      slot = (slot + 1) & (table.size() - 1);
    if (table[slot] < 0) {
      table[slot] = static_cast<int>(cells.size());
      cells.push_back({i, i, 0});
    }
    Cell& cell = cells[static_cast<std::size_t>(table[slot])];
    if (cell.weight == 0) cell.first = i;
    cell.weight += samples[i].weight;
  }
  const auto fullest =
      std::max_element(cells.begin(), cells.end(), [&](const Cell& a, const Cell& b) {
        return a.weight != b.weight ? a.weight < b.weight : keys[a.any] > keys[b.any];
      });
  return fullest->first;
}

}  // namespace

double LengthScale(std::string_view category, const Eigen::AlignedBox3f& bounds,
                   double room_thing_m) {
  const double diagonal_m = bounds.sizes().head<2>().norm();
  // The lengths first: this is asked for every particle.
  if (diagonal_m <= room_thing_m || !MovesByItself(category)) return 1;
  return 1 + kLengthGrowth * (diagonal_m / room_thing_m - 1);
}

double MapFrame::LengthScale(ModelId label) const {
  const CadModel& model = database->model(label);
  return plumbline::LengthScale(model.category, model.bounds, room_thing_m);
}

double MapFrame::BaseHeight(const PoseHypothesis& hypothesis) const {
  const Eigen::Vector3d base =
      hypothesis.center_in_world -
      hypothesis.scale() * database->model(hypothesis.label).center().z() * upright.up_in_world();
  return floor_in_world->head<3>().dot(base) + (*floor_in_world)[3];
}

std::vector<MapFrame::Standing> MapFrame::StandingsAt(const Eigen::Vector3d& point) const {
  std::vector<Standing> held;
  for (const FloorLevel& level : levels) {
    if (!level.outline_in_world.empty() && Holds(level, point, upright))
      held.push_back({level.height_m, level.std_m});
  }
  if (!held.empty()) return held;
  held.push_back({});
  for (const FloorLevel& level : levels) {
    if (level.outline_in_world.empty()) held.push_back({level.height_m, level.std_m});
  }
  return held;
}

MapFrame::Standing MapFrame::StandingOf(const PoseHypothesis& hypothesis) const {
  const double height = BaseHeight(hypothesis);
  const std::vector<Standing> standings = StandingsAt(hypothesis.center_in_world);
  return *std::min_element(standings.begin(), standings.end(),
                           [&](const Standing& a, const Standing& b) {
                             return std::abs(height - a.height_m) < std::abs(height - b.height_m);
                           });
}

bool MapFrame::StandsOnFloor(ModelId label) const {
  return floor_in_world.has_value() && database->model(label).support == Support::kFloor;
}

Eigen::Vector3d MapFrame::BaseInUpright(const PoseHypothesis& hypothesis) const {
  Eigen::Vector3d base = upright.upright_rotation().transpose() * hypothesis.center_in_world;
  base.z() -= hypothesis.scale() * database->model(hypothesis.label).center().z();
  return base;
}

double MapFrame::LeastKnown(ModelId label, const MapperOptions& options) const {
  const double half_m = 0.5 * database->model(label).bounds.sizes().maxCoeff();
  return std::min(half_m, options.confirm_position_std_m * LengthScale(label));
}

StandingThing MapFrame::StandingThingOf(const PoseHypothesis& hypothesis) const {
  const CadModel& model = database->model(hypothesis.label);
  StandingThing thing{BaseInUpright(hypothesis), hypothesis.scale() * model.bounds.sizes().z()};
  thing.foot.fill(thing.base.head<2>());
  if (feet.empty()) return thing;
  const Eigen::AlignedBox2d& foot = feet[static_cast<std::size_t>(hypothesis.label.value)];
  const Eigen::Matrix2d turn = (upright.upright_rotation().transpose() *
                                upright.WorldFromObjectRotation(hypothesis.azimuth_rad))
                                   .topLeftCorner<2, 2>();
  for (std::size_t i = 0; i < thing.foot.size(); ++i) {
    const Eigen::Vector2d corner = foot.corner(static_cast<Eigen::AlignedBox2d::CornerType>(i));
    thing.foot[i] += hypothesis.scale() * (turn * (corner - model.center().head<2>()));
  }
  return thing;
}

Eigen::Isometry3d MapFrame::WorldFromObject(const PoseHypothesis& hypothesis) const {
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  world_from_object.linear() = upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
  world_from_object.translation() =
      hypothesis.center_in_world -
      world_from_object.linear() *
          (hypothesis.scale() * database->model(hypothesis.label).center());
  return world_from_object;
}

PoseHypothesis ToHypothesis(const Particle& particle,
                            const Eigen::Isometry3d& world_from_reference_cam) {
  const double depth = std::exp(static_cast<double>(particle.rho));
  return {
      ModelId{particle.label}, particle.azimuth,
      world_from_reference_cam * Eigen::Vector3d(depth * particle.x_c, depth * particle.y_c, depth),
      particle.log_scale};
}

Particle ToParticle(const PoseHypothesis& hypothesis,
                    const Eigen::Isometry3d& world_from_reference_cam) {
  const Eigen::Vector3d center = world_from_reference_cam.inverse() * hypothesis.center_in_world;
  const double depth = std::max(center.z(), kNearestDepth_m);
  Particle particle;
  particle.x_c = static_cast<float>(center.x() / depth);
  particle.y_c = static_cast<float>(center.y() / depth);
  particle.rho = static_cast<float>(std::log(depth));
  particle.azimuth = static_cast<float>(WrapAngle(hypothesis.azimuth_rad));
  particle.label = static_cast<std::uint16_t>(hypothesis.label.value);
  particle.log_scale = static_cast<float>(hypothesis.log_scale);
  return particle;
}

double AzimuthDifference(const CadModel& model, double azimuth_rad, double from_rad) {
  const int order = model.symmetry.order;
  if (order == 0) return 0.0;
  return WrapAngle((azimuth_rad - from_rad) * order) / order;
}

void Diffuse(std::vector<Particle>& particles, const Eigen::Isometry3d& world_from_reference_cam,
             const MapFrame& map, double dt_s, const MapperOptions& options, RandomKey key) {
  const double root = std::sqrt(dt_s);
  const double jump = 1.0 - std::exp(-options.jump_rate * dt_s);
  const double keep = std::exp(-dt_s);  // the height forgets within about a second
  const auto& models = map.database->models();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    key.particle = static_cast<std::uint32_t>(i);
    Random random(key);
    Particle& particle = particles[i];
    const PoseHypothesis before = ToHypothesis(particle, world_from_reference_cam);
    if (random.Uniform() < jump) {
      const std::vector<ModelId> same = map.database->OfCategory(models[particle.label].category);
      const std::uint32_t count = static_cast<std::uint32_t>(
          options.jump_scope == JumpScope::kAll ? models.size() : same.size());
      const std::uint32_t pick = random.Index(count);
      particle.label = options.jump_scope == JumpScope::kAll
                           ? static_cast<std::uint16_t>(pick)
                           : static_cast<std::uint16_t>(same[pick].value);
    }
    particle.x_c += static_cast<float>(options.bearing_noise * root * random.Gaussian());
    particle.y_c += static_cast<float>(options.bearing_noise * root * random.Gaussian());
    particle.rho += static_cast<float>(options.log_depth_noise * root * random.Gaussian());
    particle.azimuth = static_cast<float>(
        WrapAngle(particle.azimuth +
                  options.azimuth_noise_deg * std::numbers::pi / 180.0 * root * random.Gaussian()));
    if (!options.floor_prior || !map.StandsOnFloor(ModelId{particle.label})) continue;
    // A jump to another shape keeps the base where it was; the centre moves with it.
    const double height = map.StandsOnFloor(before.label)
                              ? map.BaseHeight(before) - map.StandingOf(before).height_m
                              : 0.0;
    const double wanted =
        keep * height + std::sqrt(1.0 - keep * keep) * map.BaseStd(options) * random.Gaussian();
    PoseHypothesis after = ToHypothesis(particle, world_from_reference_cam);
    after.center_in_world += (wanted + map.StandingOf(after).height_m - map.BaseHeight(after)) *
                             map.upright.up_in_world();
    Particle moved = ToParticle(after, world_from_reference_cam);
    particle.x_c = moved.x_c;
    particle.y_c = moved.y_c;
    particle.rho = moved.rho;
  }
}

double NormalizeLogWeights(std::vector<Particle>& particles) {
  float highest = -std::numeric_limits<float>::infinity();
  for (const Particle& particle : particles) {
    if (particle.log_weight > highest) highest = particle.log_weight;
  }
  double sum = 0;
  for (const Particle& particle : particles) {
    if (std::isfinite(particle.log_weight))
      sum += std::exp(static_cast<double>(particle.log_weight) - highest);
  }
  if (!(sum > 0) || !std::isfinite(highest)) {
    const float uniform = -std::log(static_cast<float>(particles.size()));
    for (Particle& particle : particles) particle.log_weight = uniform;
    return -std::numeric_limits<double>::infinity();
  }
  const double log_sum = highest + std::log(sum);
  for (Particle& particle : particles) {
    if (std::isnan(particle.log_weight))
      particle.log_weight = -std::numeric_limits<float>::infinity();
    particle.log_weight = static_cast<float>(particle.log_weight - log_sum);
  }
  return log_sum;
}

double EffectiveSampleSize(std::span<const Particle> particles) {
  double squares = 0;
  for (const Particle& particle : particles) squares += std::exp(2.0 * particle.log_weight);
  return squares > 0 ? 1.0 / squares : 0.0;
}

std::vector<Particle> SystematicResample(std::span<const Particle> particles, int count,
                                         RandomKey key) {
  Random random(key);
  std::vector<Particle> result;
  result.reserve(static_cast<std::size_t>(count));
  double total = 0;
  for (const Particle& particle : particles)
    total += std::exp(static_cast<double>(particle.log_weight));
  const double step = total / count;
  double next = step * random.Uniform();
  double sum = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    sum += std::exp(static_cast<double>(particles[i].log_weight));
    while (static_cast<int>(result.size()) < count && (next < sum || i + 1 == particles.size())) {
      result.push_back(particles[i]);
      result.back().ancestor = static_cast<std::uint16_t>(i);
      result.back().log_weight = -std::log(static_cast<float>(count));
      next += step;
    }
  }
  return result;
}

std::vector<PoseMode> FindModes(std::span<const Particle> particles,
                                const Eigen::Isometry3d& world_from_reference_cam,
                                const MapFrame& map) {
  std::vector<Sample> rest = ToSamples(particles, world_from_reference_cam);
  std::vector<CellKey> keys;
  keys.reserve(rest.size());
  for (const Sample& sample : rest) keys.push_back(CellOf(sample, map));
  std::vector<PoseMode> modes;
  while (!rest.empty() && static_cast<int>(modes.size()) < kMaxModes) {
    const std::size_t start = InFullestCell(rest, keys);
    const Sample& seed = rest[start];
    const CadModel& model = map.database->model(ModelId{seed.label});
    const double radius_m = kModeRadius_m * map.LengthScale(model.id);
    Eigen::Vector3d center = seed.center;
    double azimuth = seed.azimuth, log_scale = 0;
    PoseMode mode;
    mode.label = model.id;
    for (int iteration = 0; iteration < 6; ++iteration) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double turn = 0, weight = 0, squares = 0, turn_squares = 0;
      double growth = 0, growth_squares = 0;
      for (const Sample& s : rest) {
        const std::optional<double> within = TurnInMode(s, model, radius_m, center, azimuth);
        if (!within) continue;
        const double difference = *within;
        weight += s.weight;
        sum += s.weight * s.center;
        squares += s.weight * (s.center - center).squaredNorm();
        turn += s.weight * difference;
        turn_squares += s.weight * difference * difference;
        growth += s.weight * s.log_scale;
        growth_squares += s.weight * s.log_scale * s.log_scale;
      }
      if (weight <= 0) break;
      const Eigen::Vector3d shift = sum / weight - center;
      const double turned = turn / weight;
      center += shift;
      azimuth = WrapAngle(azimuth + turned);
      mode.weight = weight;
      mode.position_std_m = std::sqrt(std::max(0.0, squares / weight - shift.squaredNorm()));
      mode.azimuth_std_rad = std::sqrt(std::max(0.0, turn_squares / weight - turned * turned));
      log_scale = growth / weight;
      mode.scale_std = std::sqrt(std::max(0.0, growth_squares / weight - log_scale * log_scale));
    }
    mode.world_from_object = map.WorldFromObject({mode.label, azimuth, center, log_scale});
    mode.scale = std::exp(log_scale);
    if (modes.empty() || mode.weight >= kMinModeWeight) modes.push_back(mode);
    const std::size_t before = rest.size();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < before; ++i) {
      if (TurnInMode(rest[i], model, radius_m, center, azimuth)) continue;
      rest[kept] = rest[i];
      keys[kept++] = keys[i];
    }
    rest.resize(kept);
    keys.resize(kept);
    if (kept == before) {
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(start));
      keys.erase(keys.begin() + static_cast<std::ptrdiff_t>(start));
    }
    double left = 0;
    for (const Sample& s : rest) left += s.weight;
    if (left < kMinModeWeight) break;
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const PoseMode& a, const PoseMode& b) { return a.weight > b.weight; });
  return modes;
}

PoseHypothesis ToHypothesis(const PoseMode& mode, const MapFrame& map) {
  return {mode.label, map.upright.Azimuth(mode.world_from_object.linear()),
          mode.world_from_object * (mode.scale * map.database->model(mode.label).center()),
          std::log(mode.scale)};
}

Eigen::Matrix4d ModeCovariance(const PoseMode& mode, std::span<const Particle> particles,
                               const Eigen::Isometry3d& world_from_reference_cam,
                               const MapFrame& map) {
  const PoseHypothesis mean = ToHypothesis(mode, map);
  const CadModel& model = map.database->model(mode.label);
  const double radius_m = kModeRadius_m * map.LengthScale(mode.label);
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double weight = 0;
  for (const Sample& s : ToSamples(particles, world_from_reference_cam)) {
    if (!TurnInMode(s, model, radius_m, mean.center_in_world, mean.azimuth_rad)) continue;
    Eigen::Vector4d difference;
    difference << s.center - mean.center_in_world,
        AzimuthDifference(model, s.azimuth, mean.azimuth_rad);
    covariance += s.weight * difference * difference.transpose();
    weight += s.weight;
  }
  return weight > 0 ? Eigen::Matrix4d(covariance / weight) : covariance;
}

std::vector<LabelProbability> LabelPosterior(std::span<const Particle> particles) {
  std::map<std::uint16_t, double> sums;
  for (const Particle& particle : particles)
    sums[particle.label] += std::exp(static_cast<double>(particle.log_weight));
  std::vector<LabelProbability> posterior;
  for (const auto& [label, probability] : sums) posterior.push_back({ModelId{label}, probability});
  std::stable_sort(posterior.begin(), posterior.end(),
                   [](const LabelProbability& a, const LabelProbability& b) {
                     return a.probability > b.probability;
                   });
  return posterior;
}

}  // namespace plumbline
