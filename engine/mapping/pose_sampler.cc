// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/pose_sampler.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "engine/geometry/angles.h"
#include "engine/geometry/random_vector.h"

namespace plumbline {
namespace {

/// Lengths of searches and modes are times LengthScale.
constexpr double kModeReach_m = 0.20, kModeReach_rad = 40 * kRadPerDeg;
constexpr std::size_t kMostModes = 8;
constexpr double kFaintMode = 12;  ///< Modes below the best by so much are not proposed [nats].
constexpr double kLeastModeWeight = 0.03;  ///< Of a proposal; the mode's mass is only estimated.
constexpr double kMeanTemperature = 3;     ///< At which members of a search count in its modes.
constexpr double kTailFreedom = 5;         ///< Degrees of freedom of Student's t.
constexpr double kLeastSpread_m = 0.001, kLeastSpread_rad = 0.1 * kRadPerDeg;
/// A mode of few members is taken to have this many times the variance of the others, as if that
/// had been seen so often.
constexpr double kUsualFactor = 4, kUsualCount = 5;
constexpr std::size_t kPolished = 48;  ///< Members of a mode that is brought to its peak,
constexpr int kMostPolished = 3;       ///< for the best of those found.
constexpr double kLeastWalk_m = 0.0005, kLeastWalk_rad = 0.05 * kRadPerDeg;
/// Of log-scale, in deviations of its prior.
constexpr double kLeastSpread_scale = 0.1, kUsualSpread_scale = 1, kLeastWalk_scale = 0.05;
/// A step so far in position goes one deviation of its prior in scale.
constexpr double kStepOfScale_m = 0.05;

constexpr std::size_t kRivalStarts = 27;  ///< Of another shape in the place of a population,
constexpr double kRivalWarmth = 8;        ///< and the temperature that its peak is sought from.

/// Shares of turns about the front or back of a model, and about its middle.
constexpr double kTurnedAboutSide = 0.4, kTurnedAboutMiddle = 0.3;

/// One round of a search: how many go on, how sharply they are chosen, how far they step.
struct Round {
  std::size_t count;
  double temperature;
  double position_m, azimuth_rad;
};
constexpr Round kSearch[] = {{100, 3.0, 0.05, 6 * kRadPerDeg},
                             {60, 2.0, 0.025, 3 * kRadPerDeg},
                             {60, 1.5, 0.012, 1.5 * kRadPerDeg},
                             {60, 1.0, 0.008, 1.0 * kRadPerDeg}};

/// Weighted mean and covariance of differences from a pose and a log-scale.
struct Moments {
  double weight = 0;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  double scale_sum = 0, scale_squares = 0;
  Eigen::Vector4d scale_times_pose = Eigen::Vector4d::Zero();

  void Add(double w, const Eigen::Vector4d& difference, double growth) {
    weight += w;
    sum += w * difference;
    squares += w * difference * difference.transpose();
    scale_sum += w * growth;
    scale_squares += w * growth * growth;
    scale_times_pose += w * growth * difference;
  }
  Eigen::Vector4d mean() const { return sum / weight; }
  Eigen::Matrix4d covariance() const { return squares / weight - mean() * mean().transpose(); }
  double scale_mean() const { return scale_sum / weight; }
  double scale_variance() const { return scale_squares / weight - scale_mean() * scale_mean(); }
  Eigen::Vector4d scale_covariance() const {
    return scale_times_pose / weight - scale_mean() * mean();
  }
};

/// @param root  Of the pose's covariance.
ScaleRow RowOf(const Eigen::Matrix4d& root, const Eigen::Vector4d& covariance, double variance) {
  ScaleRow row;
  row.with_pose = root.triangularView<Eigen::Lower>().solve(covariance);
  row.own = std::sqrt(std::max(variance - row.with_pose.squaredNorm(), 1e-12));
  return row;
}

double HighestOf(const Population& population) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Judgement& judged : population.judged) highest = std::max(highest, judged.log_target);
  return highest;
}

double Squared(double value) { return value * value; }

Eigen::Matrix4d Diagonal(double position_m, double azimuth_rad) {
  return Eigen::Vector4d(position_m * position_m, position_m * position_m, position_m * position_m,
                         azimuth_rad * azimuth_rad)
      .asDiagonal();
}

}  // namespace

void Population::Add(const Population& other) {
  hypotheses.insert(hypotheses.end(), other.hypotheses.begin(), other.hypotheses.end());
  judged.insert(judged.end(), other.judged.begin(), other.judged.end());
}

Eigen::Vector4d PoseSampler::Difference(const PoseHypothesis& a, const PoseHypothesis& from) const {
  Eigen::Vector4d difference;
  difference.head<3>() =
      map_.upright.upright_rotation().transpose() * (a.center_in_world - from.center_in_world);
  difference[3] =
      AzimuthDifference(map_.database->model(from.label), a.azimuth_rad, from.azimuth_rad);
  return difference;
}

PoseHypothesis PoseSampler::Step(PoseHypothesis hypothesis, double room_step_m,
                                 double azimuth_rad) {
  Random random = Next();
  const double lengths = map_.LengthScale(hypothesis.label);
  const double position_m = lengths * room_step_m;
  const double reach = random.Uniform() < 0.125 ? 3.0 : 1.0;
  const bool on_floor = options_.floor_prior && map_.StandsOnFloor(hypothesis.label);
  const double across_m = reach * position_m,
               up_m = on_floor ? std::min(position_m, map_.BaseStd(options_)) : across_m;
  const Eigen::Vector3d step =
      GaussianVector<3>(random).cwiseProduct(Eigen::Vector3d(across_m, across_m, up_m));
  hypothesis.center_in_world += map_.upright.upright_rotation() * step;
  hypothesis.azimuth_rad =
      WrapAngle(hypothesis.azimuth_rad + reach * azimuth_rad * random.Gaussian());
  if (options_.scale_std <= 0) return hypothesis;
  const double before = hypothesis.scale();
  hypothesis.log_scale += reach * options_.scale_std *
                          std::min(1.0, position_m / (lengths * kStepOfScale_m)) *
                          random.Gaussian();
  if (on_floor) {  // it grows from its base
    hypothesis.center_in_world += (hypothesis.scale() - before) *
                                  map_.database->model(hypothesis.label).center().z() *
                                  map_.upright.up_in_world();
  }
  return hypothesis;
}

PoseHypothesis PoseSampler::Turned(PoseHypothesis hypothesis) {
  Random random = Next();
  const Eigen::Vector3d size =
      hypothesis.scale() * map_.database->model(hypothesis.label).bounds.sizes().cast<double>();
  const double pivot_y = random.Uniform(-0.5, 0.5) * size.y(),
               pivot_x = random.Uniform(-0.5, 0.5) * size.x();
  Eigen::Vector3d pivot(pivot_x, pivot_y, 0);
  const double about = random.Uniform();
  if (about < kTurnedAboutMiddle) {  // A screen's twin has the same outline.
    pivot.setZero();
  } else if (about < kTurnedAboutMiddle + kTurnedAboutSide) {
    // What shows of a chair at a table is its back: the twin has it in the same place.
    const double side = random.Uniform() < 0.5 ? 0.5 : -0.5;
    pivot = {(side + random.Uniform(-0.1, 0.1)) * size.x(), 0.1 * pivot.y(), 0};
  }
  const double pick = random.Uniform();
  const double turn = pick < 0.4   ? std::numbers::pi
                      : pick < 0.7 ? (pick < 0.55 ? 0.5 : -0.5) * std::numbers::pi
                                   : Next().Uniform(-std::numbers::pi, std::numbers::pi);
  const Eigen::Matrix3d before = map_.upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
  const Eigen::Matrix3d after = map_.upright.WorldFromObjectRotation(hypothesis.azimuth_rad + turn);
  hypothesis.center_in_world += before * pivot - after * pivot;
  hypothesis.azimuth_rad = WrapAngle(hypothesis.azimuth_rad + turn);
  return hypothesis;
}

PoseHypothesis PoseSampler::WithShape(PoseHypothesis hypothesis, ModelId label, double in_depth,
                                      double in_width) const {
  const CadModel& before = map_.database->model(hypothesis.label);
  const CadModel& after = map_.database->model(label);
  const Eigen::Vector3d half_growth =
      0.5 * hypothesis.scale() * (after.bounds.sizes() - before.bounds.sizes()).cast<double>();
  hypothesis.center_in_world +=
      map_.upright.WorldFromObjectRotation(hypothesis.azimuth_rad) *
      Eigen::Vector3d(in_depth * half_growth.x(), in_width * half_growth.y(), 0);
  if (map_.StandsOnFloor(label) && map_.StandsOnFloor(hypothesis.label)) {
    hypothesis.center_in_world += hypothesis.scale() * (after.center().z() - before.center().z()) *
                                  map_.upright.up_in_world();
  }
  hypothesis.label = label;
  return hypothesis;
}

PoseHypothesis PoseSampler::Relabelled(const PoseHypothesis& hypothesis) {
  Random random = Next();
  std::vector<ModelId> others =
      map_.database->OfCategory(map_.database->model(hypothesis.label).category);
  std::erase(others, hypothesis.label);
  if (others.empty()) return hypothesis;
  const ModelId label = others[random.Index(static_cast<std::uint32_t>(others.size()))];
  // What showed of the wide sofa was an end of it: the small one that was taken for it has that end
  // in the same place, not the middle. So along each axis the middle stays, or one of the sides.
  const double in_depth = random.Index(3) - 1.0, in_width = random.Index(3) - 1.0;
  return WithShape(hypothesis, label, in_depth, in_width);
}

std::vector<PoseHypothesis> PoseSampler::Challengers(const std::vector<PoseHypothesis>& population,
                                                     std::size_t count) {
  std::vector<PoseHypothesis> challengers;
  const Random any = Next();
  Random random = any;
  for (std::size_t i = 0; i < count; ++i) {
    const PoseHypothesis& particle =
        population[random.Index(static_cast<std::uint32_t>(population.size()))];
    if (i % 8 == 1) {
      challengers.push_back(Relabelled(particle));  // shapes that differ a little fit as they stand
    } else if (i % 8 == 5) {
      challengers.push_back(Relabelled(Step(particle, 0.08, 8 * kRadPerDeg)));
    } else if (i % 4 == 3) {
      challengers.push_back(Step(particle, 0.08, 8 * kRadPerDeg));
    } else {
      challengers.push_back(Turned(particle));
    }
  }
  return challengers;
}

std::vector<std::size_t> PoseSampler::Choose(const Population& population, double temperature,
                                             std::size_t count) {
  const double highest = HighestOf(population);
  std::vector<double> sums;
  double sum = 0;
  for (const Judgement& judged : population.judged)
    sums.push_back(sum += std::exp((judged.log_target - highest) / temperature));
  const double start = Next().Uniform();
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    const auto found =
        std::upper_bound(sums.begin(), sums.end(),
                         (static_cast<double>(i) + start) * sum / static_cast<double>(count));
    chosen.push_back(std::min(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1));
  }
  return chosen;
}

PoseSpread PoseSampler::SpreadWithin(const Population& population) const {
  Moments within;
  std::vector<bool> taken(population.size(), false);
  for (std::size_t seed = 0; seed < population.size(); ++seed) {
    if (taken[seed]) continue;
    Moments moments;
    const PoseHypothesis& from = population.hypotheses[seed];
    for (std::size_t i = seed; i < population.size(); ++i) {
      const PoseHypothesis& hypothesis = population.hypotheses[i];
      if (taken[i] || hypothesis.label != from.label) continue;
      const Eigen::Vector4d difference = Difference(hypothesis, from);
      if (difference.head<3>().norm() > kModeReach_m * map_.LengthScale(from.label) ||
          std::abs(difference[3]) > kModeReach_rad)
        continue;
      taken[i] = true;
      moments.Add(1, difference, hypothesis.log_scale - from.log_scale);
    }
    within.weight += moments.weight;
    within.squares += moments.weight * moments.covariance();
    within.scale_squares += moments.weight * moments.scale_variance();
    within.scale_times_pose += moments.weight * moments.scale_covariance();
  }
  return {within.squares / within.weight, within.scale_times_pose / within.weight,
          within.scale_squares / within.weight};
}

double PoseSampler::Walk(Population& population) { return WalkAt(population, 1.0); }

double PoseSampler::WalkAt(Population& population, double temperature) {
  // One spread for all steps: so they are symmetric.
  const PoseSpread spread = SpreadWithin(population);
  const Eigen::Matrix4d root =
      Eigen::LLT<Eigen::Matrix4d>(spread.pose + Diagonal(kLeastWalk_m, kLeastWalk_rad)).matrixL();
  const bool grows = options_.scale_std > 0;
  const ScaleRow row =
      RowOf(root, spread.scale_with_pose,
            spread.scale_variance + Squared(kLeastWalk_scale * options_.scale_std));
  std::vector<PoseHypothesis> proposed;
  proposed.reserve(population.size());
  for (const PoseHypothesis& hypothesis : population.hypotheses) {
    Random random = Next();
    // Small steps are accepted, large ones go far: both, in turn.
    const double scale = random.Uniform() < 0.5 ? 0.5 : 1.3;
    const Eigen::Vector4d normal = GaussianVector<4>(random);
    const Eigen::Vector4d step = scale * root * normal;
    PoseHypothesis moved = hypothesis;
    moved.center_in_world += map_.upright.upright_rotation() * step.head<3>();
    moved.azimuth_rad = WrapAngle(moved.azimuth_rad + step[3]);
    if (grows) moved.log_scale += scale * (row.with_pose.dot(normal) + row.own * random.Gaussian());
    proposed.push_back(moved);
  }
  const std::vector<Judgement> judged = target_(proposed);
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < proposed.size(); ++i) {
    const double gain = (judged[i].log_target - population.judged[i].log_target) / temperature;
    if (std::log(1.0 - Next().Uniform()) >= gain) continue;
    population.hypotheses[i] = proposed[i];
    population.judged[i] = judged[i];
    ++accepted;
  }
  return static_cast<double>(accepted) /
         static_cast<double>(std::max<std::size_t>(1, proposed.size()));
}

std::vector<ProposalMode> PoseSampler::ModesOf(const Population& population, double sharpness,
                                               double reach, const PoseSpread& usual) const {
  std::vector<ProposalMode> modes;
  std::vector<bool> taken(population.size(), false);
  const double highest = HighestOf(population);
  while (modes.size() < kMostModes) {
    std::size_t seed = population.size();
    for (std::size_t i = 0; i < population.size(); ++i) {
      if (taken[i]) continue;
      if (seed == population.size() ||
          population.judged[i].log_target > population.judged[seed].log_target)
        seed = i;
    }
    if (seed == population.size()) return modes;
    const double best = population.judged[seed].log_target;
    if (best < highest - reach) return modes;
    const PoseHypothesis& from = population.hypotheses[seed];
    Moments moments;
    for (std::size_t i = 0; i < population.size(); ++i) {
      if (taken[i] || population.hypotheses[i].label != from.label) continue;
      const Eigen::Vector4d difference = Difference(population.hypotheses[i], from);
      if (difference.head<3>().norm() > kModeReach_m * map_.LengthScale(from.label) ||
          std::abs(difference[3]) > kModeReach_rad)
        continue;
      taken[i] = true;
      moments.Add(std::exp(sharpness * (population.judged[i].log_target - best)), difference,
                  population.hypotheses[i].log_scale - from.log_scale);
    }
    ProposalMode mode;
    mode.mean = mode.highest = from;
    mode.mean.center_in_world += map_.upright.upright_rotation() * moments.mean().head<3>();
    mode.mean.azimuth_rad = WrapAngle(mode.mean.azimuth_rad + moments.mean()[3]);
    // A handful of hypotheses says little about the spread.
    const double unknown = kUsualCount / (moments.weight + kUsualCount);
    const Eigen::Matrix4d scale = (1 - unknown) * moments.covariance() +
                                  unknown * kUsualFactor * usual.pose +
                                  Diagonal(kLeastSpread_m, kLeastSpread_rad);
    const Eigen::LLT<Eigen::Matrix4d> cholesky(scale);
    mode.root = cholesky.matrixL();
    mode.log_determinant = 2 * mode.root.diagonal().array().log().sum();
    if (options_.scale_std > 0) {
      mode.mean.log_scale += moments.scale_mean();
      mode.scale = RowOf(mode.root, (1 - unknown) * moments.scale_covariance(),
                         (1 - unknown) * moments.scale_variance() +
                             unknown * Squared(kUsualSpread_scale * options_.scale_std) +
                             Squared(kLeastSpread_scale * options_.scale_std));
      mode.log_determinant += 2 * std::log(mode.scale.own);
    }
    mode.weight = best + 0.5 * mode.log_determinant;  // log of its mass but for a constant
    modes.push_back(mode);
  }
  return modes;
}

bool PoseSampler::Knows(const std::vector<ProposalMode>& modes, const ProposalMode& mode) const {
  return std::any_of(modes.begin(), modes.end(), [&](const ProposalMode& other) {
    if (other.mean.label != mode.mean.label) return false;
    const Eigen::Vector4d difference = Difference(mode.mean, other.mean);
    return difference.head<3>().norm() < kModeReach_m * map_.LengthScale(mode.mean.label) / 4 &&
           std::abs(difference[3]) < kModeReach_rad / 4;
  });
}

ProposalMode PoseSampler::Polished(const ProposalMode& found, double temperature,
                                   const PoseSpread& usual) {
  Population members;
  members.hypotheses.push_back(found.mean);
  while (members.size() < kPolished) members.hypotheses.push_back(Draw({found}));
  members.judged = target_(members.hypotheses);
  for (bool cold = false; !cold; temperature /= 2) {
    cold = temperature <= 1;
    if (cold) temperature = 1;
    Population chosen;
    for (const std::size_t index : Choose(members, temperature, kPolished)) {
      chosen.hypotheses.push_back(members.hypotheses[index]);
      chosen.judged.push_back(members.judged[index]);
    }
    members = std::move(chosen);
    WalkAt(members, temperature);
  }
  return ModesOf(members, 0, std::numeric_limits<double>::infinity(), usual).front();
}

std::vector<ProposalMode> PoseSampler::FindModes(const Population& population,
                                                 const std::vector<PoseHypothesis>& challengers,
                                                 double sharpness) {
  const PoseSpread usual = SpreadWithin(population);
  std::vector<ProposalMode> modes =
      ModesOf(population, 0, std::numeric_limits<double>::infinity(), usual);
  double highest = -std::numeric_limits<double>::infinity();
  for (const ProposalMode& mode : modes) highest = std::max(highest, mode.weight);
  if (!challengers.empty()) {
    const double warmth = std::max(1.0, sharpness);
    Population search{challengers, target_(challengers)};
    for (const Round& round : kSearch) {
      Population next, steps;
      for (const std::size_t index : Choose(search, warmth * round.temperature, round.count)) {
        next.hypotheses.push_back(search.hypotheses[index]);
        next.judged.push_back(search.judged[index]);
        steps.hypotheses.push_back(
            Step(search.hypotheses[index], round.position_m, round.azimuth_rad));
      }
      steps.judged = target_(steps.hypotheses);
      next.Add(steps);
      search = std::move(next);
    }
    // Those of a search are drawn from the target already, or nearly.
    const std::size_t own = modes.size();
    int polished = 0;
    for (ProposalMode& found :
         ModesOf(search, 1 / (kMeanTemperature * warmth), warmth * kFaintMode, usual)) {
      // The mean of members far apart may be where nothing fits.
      const std::vector<Judgement> judged = target_(std::vector{found.mean, found.highest});
      if (judged[0].log_target < judged[1].log_target - kMeanTemperature * warmth)
        found.mean = found.highest;
      if (Knows(modes, found)) continue;
      if (polished++ == kMostPolished) break;
      const ProposalMode mode = Polished(found, warmth, usual);
      highest = std::max(highest, mode.weight);
      if (!Knows(modes, mode)) modes.push_back(mode);
    }
    // The population's own stay, however faint: what cannot be proposed again cannot be left.
    modes.erase(
        std::remove_if(modes.begin() + static_cast<std::ptrdiff_t>(own), modes.end(),
                       [&](const ProposalMode& m) { return m.weight < highest - kFaintMode; }),
        modes.end());
  }
  double sum = 0;
  for (ProposalMode& mode : modes)
    sum += mode.weight = std::max(std::exp(mode.weight - highest), kLeastModeWeight);
  for (ProposalMode& mode : modes) mode.weight /= sum;
  return modes;
}

std::vector<ShapeRival> PoseSampler::RivalShapes(const Population& population, double reach) {
  std::vector<ShapeRival> rivals;
  if (population.size() == 0) return rivals;
  const PoseSpread usual = SpreadWithin(population);
  const ProposalMode own =
      ModesOf(population, 0, std::numeric_limits<double>::infinity(), usual).front();
  const double best = HighestOf(population);
  for (const ModelId label :
       map_.database->OfCategory(map_.database->model(own.mean.label).category)) {
    if (label == own.mean.label) continue;
    Population starts;
    for (std::size_t i = 0; i < kRivalStarts; ++i) {
      const PoseHypothesis& from = population.hypotheses[i * population.size() / kRivalStarts];
      starts.hypotheses.push_back(WithShape(from, label, static_cast<double>(i % 3) - 1,
                                            static_cast<double>(i / 3 % 3) - 1));
    }
    starts.judged = target_(starts.hypotheses);
    const auto highest = std::max_element(
        starts.judged.begin(), starts.judged.end(),
        [](const Judgement& a, const Judgement& b) { return a.log_target < b.log_target; });
    if (highest->log_target < best - reach) continue;
    ProposalMode start = own;  // with the width of the own one
    start.mean = starts.hypotheses[static_cast<std::size_t>(highest - starts.judged.begin())];
    rivals.push_back({label, Polished(start, kRivalWarmth, usual).weight - own.weight});
  }
  return rivals;
}

PoseHypothesis PoseSampler::Draw(const std::vector<ProposalMode>& modes) {
  Random random = Next();
  double pick = random.Uniform();
  std::size_t index = 0;
  while (index + 1 < modes.size() && pick >= modes[index].weight) pick -= modes[index++].weight;
  const ProposalMode& mode = modes[index];
  double chi_square = 0;
  for (int k = 0; k < static_cast<int>(kTailFreedom); ++k) {
    const double g = random.Gaussian();
    chi_square += g * g;
  }
  const double stretch = std::sqrt(kTailFreedom / chi_square);
  const Eigen::Vector4d normal = GaussianVector<4>(random);
  const Eigen::Vector4d step = stretch * (mode.root * normal);
  PoseHypothesis drawn = mode.mean;
  drawn.center_in_world += map_.upright.upright_rotation() * step.head<3>();
  const int order = map_.database->model(drawn.label).symmetry.order;
  const double copy =
      order == 0  ? random.Uniform(-std::numbers::pi, std::numbers::pi)
      : order > 1 ? 2 * std::numbers::pi * random.Index(static_cast<std::uint32_t>(order)) / order
                  : 0.0;
  drawn.azimuth_rad = WrapAngle(drawn.azimuth_rad + step[3] + copy);
  if (options_.scale_std > 0)
    drawn.log_scale +=
        stretch * (mode.scale.with_pose.dot(normal) + mode.scale.own * random.Gaussian());
  return drawn;
}

double PoseSampler::LogDensity(const std::vector<ProposalMode>& modes,
                               const PoseHypothesis& hypothesis) const {
  const bool grows = options_.scale_std > 0;
  const int dimensions = grows ? 5 : 4;
  double density = 0;
  for (const ProposalMode& mode : modes) {
    if (mode.mean.label != hypothesis.label) continue;
    Eigen::Vector4d difference = Difference(hypothesis, mode.mean);
    const Eigen::Vector4d whitened = mode.root.triangularView<Eigen::Lower>().solve(difference);
    double squares = whitened.squaredNorm();
    if (grows) {
      const double growth = hypothesis.log_scale - mode.mean.log_scale;
      squares += Squared((growth - mode.scale.with_pose.dot(whitened)) / mode.scale.own);
    }
    density += mode.weight *
               std::exp(-0.5 * mode.log_determinant -
                        0.5 * (kTailFreedom + dimensions) * std::log1p(squares / kTailFreedom));
  }
  return std::log(std::max(density, 1e-300));
}

double PoseSampler::Jump(Population& population, const std::vector<ProposalMode>& modes) {
  if (modes.empty()) return 0;
  std::vector<PoseHypothesis> proposed;
  proposed.reserve(population.size());
  for (std::size_t i = 0; i < population.size(); ++i) proposed.push_back(Draw(modes));
  const std::vector<Judgement> judged = target_(proposed);
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < proposed.size(); ++i) {
    const double gain = judged[i].log_target - population.judged[i].log_target +
                        LogDensity(modes, population.hypotheses[i]) -
                        LogDensity(modes, proposed[i]);
    if (std::log(1.0 - Next().Uniform()) >= gain) continue;
    population.hypotheses[i] = proposed[i];
    population.judged[i] = judged[i];
    ++accepted;
  }
  return static_cast<double>(accepted) /
         static_cast<double>(std::max<std::size_t>(1, population.size()));
}

Population PoseSampler::Temper(const std::vector<PoseHypothesis>& draws, std::size_t count) {
  Population population{draws, target_(draws)};
  double reached = 0;  // inverse temperature
  while (reached < 1) {
    const double highest = HighestOf(population);
    const auto effective_share = [&](double step) {
      double sum = 0, squares = 0;
      for (const Judgement& judged : population.judged) {
        const double weight = std::exp(step * (judged.log_target - highest));
        sum += weight;
        squares += weight * weight;
      }
      return sum * sum / squares / static_cast<double>(population.size());
    };
    double low = 0, high = 1 - reached;
    if (effective_share(high) < 0.5) {
      for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (effective_share(middle) < 0.5 ? high : low) = middle;
      }
    } else {
      low = high;
    }
    const double step = std::max(low, 1e-4);
    Population next;
    for (const std::size_t index : Choose(population, 1 / step, count)) {
      next.hypotheses.push_back(population.hypotheses[index]);
      next.judged.push_back(population.judged[index]);
    }
    population = std::move(next);
    reached += step;
    WalkAt(population, 1 / std::min(1.0, reached));
  }
  return population;
}

}  // namespace plumbline
