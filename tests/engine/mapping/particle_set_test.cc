// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/particle_set.h"
#include "engine/geometry/random_vector.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "engine/geometry/angles.h"
#include "tests/support/furniture_models.h"
#include "tests/support/random_pose.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

MapFrame ZUpFrame() {
  return {UprightFrame({0, 0, -1}), Eigen::Vector4d(0, 0, 1, 0), MakeFurnitureDatabase()};
}

/// A camera at (0, -3, 1.5) looking along +y and 20 degrees down.
Eigen::Isometry3d WatchingCamera() {
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() =
      Eigen::AngleAxisd(-110 * kRadPerDeg, Eigen::Vector3d::UnitX()).toRotationMatrix();
  world_from_cam.translation() = Eigen::Vector3d(0, -3, 1.5);
  return world_from_cam;
}

ModelId Label(const MapFrame& map, const char* name) { return map.database->Find(name).value(); }

PoseHypothesis Standing(const MapFrame& map, const char* name, double x, double y, double azimuth,
                        double height = 0) {
  const ModelId label = Label(map, name);
  return {label, azimuth, {x, y, height + map.database->model(label).center().z()}};
}

std::vector<Particle> Many(const PoseHypothesis& hypothesis, int count) {
  Particle particle = ToParticle(hypothesis, WatchingCamera());
  particle.log_weight = -std::log(static_cast<float>(count));
  return std::vector<Particle>(static_cast<std::size_t>(count), particle);
}

struct Spread {
  double mean = 0, std = 0;
};
template <typename Value>
Spread SpreadOf(const std::vector<Particle>& particles, Value value) {
  double sum = 0, squares = 0;
  for (const Particle& particle : particles) {
    const double v = value(particle);
    sum += v;
    squares += v * v;
  }
  const double n = static_cast<double>(particles.size());
  return {sum / n, std::sqrt(squares / n - sum * sum / n / n)};
}

double HeightOf(const Particle& particle, const MapFrame& map) {
  return map.BaseHeight(ToHypothesis(particle, WatchingCamera()));
}

TEST(ParticleSet, ParticlesAndHypothesesAreInverse) {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    Random random({.seed = 1, .particle = i});
    const Eigen::Isometry3d world_from_cam = RandomPose(random);
    const PoseHypothesis hypothesis{
        ModelId{static_cast<std::int32_t>(random.Index(5))},
        random.Uniform(-std::numbers::pi, std::numbers::pi),
        world_from_cam *
            Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Uniform(0.3, 8))};
    const PoseHypothesis back =
        ToHypothesis(ToParticle(hypothesis, world_from_cam), world_from_cam);
    EXPECT_EQ(back.label, hypothesis.label);
    EXPECT_NEAR(WrapAngle(back.azimuth_rad - hypothesis.azimuth_rad), 0, 1e-6);
    // Single precision of bearing and log-depth at up to 8 m.
    EXPECT_LT((back.center_in_world - hypothesis.center_in_world).norm(), 1e-5);
  }
}

TEST(ParticleSet, WhatIsLargerThanItsModelGrowsFromItsBase) {
  const MapFrame map = ZUpFrame();
  for (const double scale : {0.95, 1.0, 1.07}) {
    PoseHypothesis chair = Standing(map, "chair", 0.4, -0.2, 0.7);
    const CadModel& model = map.database->model(chair.label);
    chair.log_scale = std::log(scale);
    chair.center_in_world.z() *= scale;
    EXPECT_NEAR(map.BaseHeight(chair), 0, 1e-12);
    EXPECT_NEAR(map.BaseInUpright(chair).z(), 0, 1e-12);
    // The same place for the middle of the base, whatever its scale.
    const Eigen::Isometry3d world_from_object = map.WorldFromObject(chair);
    EXPECT_NEAR(world_from_object.translation().z(), 0, 1e-12);
    EXPECT_LT((world_from_object * (scale * model.center()) - chair.center_in_world).norm(), 1e-12);
    const PoseHypothesis back = ToHypothesis(ToParticle(chair, WatchingCamera()), WatchingCamera());
    EXPECT_NEAR(back.scale(), scale, 1e-6);
  }
}

TEST(ParticleSet, ThePlaceOfASmallThingHasToBeKnownToHalfOfIt) {
  MapFrame map = ZUpFrame();
  std::vector<CadModel> models = map.database->models();
  CadModel& cup = models[static_cast<std::size_t>(Label(map, "vase").value)];  // .24 x .24 x .4 m
  for (Eigen::Vector3f& vertex : cup.mesh.vertices) vertex *= 0.2F;
  map.database = ModelDatabase::FromModels(std::move(models));
  MapperOptions options;
  EXPECT_NEAR(map.LeastKnown(Label(map, "vase"), options), 0.04, 1e-6);
  EXPECT_NEAR(map.LeastKnown(Label(map, "chair"), options), 0.1, 1e-6);
  options.confirm_position_std_m = 0.02;
  EXPECT_NEAR(map.LeastKnown(Label(map, "vase"), options), 0.02, 1e-6);
}

TEST(ParticleSet, ParametersAreThePapers) {
  const Eigen::Isometry3d world_from_cam = WatchingCamera();
  Particle particle;
  particle.x_c = 0.25f;
  particle.y_c = -0.125f;
  particle.rho = std::log(2.0f);
  const PoseHypothesis hypothesis = ToHypothesis(particle, world_from_cam);
  EXPECT_LT((world_from_cam.inverse() * hypothesis.center_in_world - Eigen::Vector3d(0.5, -0.25, 2))
                .norm(),
            1e-6);
}

TEST(ParticleSet, ACentreBehindTheReferenceCameraIsMovedBeforeIt) {
  const Particle particle = ToParticle({ModelId{0}, 0, {0, 0, -1}}, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(std::isfinite(particle.rho));
  EXPECT_NEAR(std::exp(particle.rho), 0.05, 1e-6);
}

TEST(ParticleSet, PosesAreUprightForAnyGravity) {
  for (std::uint32_t i = 0; i < 200; ++i) {
    Random random({.seed = 2, .particle = i});
    const Eigen::Vector3d gravity = GaussianVector<3>(random).normalized();
    MapFrame map{UprightFrame(gravity), std::nullopt, MakeFurnitureDatabase()};
    Eigen::Vector4d floor;
    floor << -gravity, random.Gaussian();
    map.floor_in_world = floor;
    const PoseHypothesis hypothesis{ModelId{0},
                                    random.Uniform(-3, 3),
                                    {random.Gaussian(), random.Gaussian(), random.Gaussian()}};
    const Eigen::Isometry3d world_from_object = map.WorldFromObject(hypothesis);
    EXPECT_LT((world_from_object.linear() * Eigen::Vector3d::UnitZ() + gravity).norm(), 1e-9);
    EXPECT_LT((world_from_object * map.database->models()[0].center() - hypothesis.center_in_world)
                  .norm(),
              1e-9);
    const Eigen::Vector3d base = world_from_object.translation();
    EXPECT_NEAR(map.BaseHeight(hypothesis), floor.head<3>().dot(base) + floor[3], 1e-9);
  }
}

TEST(Diffuse, KeepsTheFloorPriorAsItIs) {
  const MapFrame map = ZUpFrame();
  MapperOptions options;
  options.floor_std_m = 0.02;
  options.jump_rate = 0;
  for (const double dt_s : {1.0 / 60, 1.0 / 30, 0.2}) {
    std::vector<Particle> particles = Many(Standing(map, "chair", 0, 0, 0.3), 4000);
    // From certainty about the floor the prior comes back within seconds, and then stays.
    const int steps = static_cast<int>(std::lround(4.0 / dt_s));
    for (int step = 0; step < 3 * steps; ++step) {
      Diffuse(particles, WatchingCamera(), map, dt_s, options,
              {.seed = 1, .frame = static_cast<std::uint32_t>(step)});
      if (step < steps || step % 20 != 0) continue;
      const Spread height =
          SpreadOf(particles, [&](const Particle& p) { return HeightOf(p, map); });
      // The standard deviation of 4000 samples is known to 1.1 %, the mean to 0.3 mm.
      EXPECT_NEAR(height.std, options.floor_std_m, 0.05 * options.floor_std_m) << dt_s;
      EXPECT_NEAR(height.mean, 0, 0.0015) << dt_s;
    }
  }
}

TEST(Diffuse, PullsAFloatingObjectDownWithinSeconds) {
  const MapFrame map = ZUpFrame();
  std::vector<Particle> particles = Many(Standing(map, "chair", 0, 0, 0.3, 0.3), 500);
  for (std::uint32_t step = 0; step < 90; ++step)
    Diffuse(particles, WatchingCamera(), map, 1.0 / 30, {}, {.frame = step});
  const Spread height = SpreadOf(particles, [&](const Particle& p) { return HeightOf(p, map); });
  EXPECT_NEAR(height.mean, 0.3 * std::exp(-3.0), 0.004);
}

TEST(Diffuse, NoiseGrowsWithTheRootOfTimeWhateverTheFrameRate) {
  const MapFrame map = ZUpFrame();
  MapperOptions options;
  options.jump_rate = 0;
  options.floor_prior = false;
  for (const int rate_hz : {5, 30, 60}) {
    std::vector<Particle> particles = Many(Standing(map, "crate", 0, 0, 0.3), 4000);
    const Particle start = particles.front();
    for (int step = 0; step < 4 * rate_hz; ++step)
      Diffuse(particles, WatchingCamera(), map, 1.0 / rate_hz, options,
              {.seed = 4, .frame = static_cast<std::uint32_t>(step)});
    const auto expect = [&](auto value, double sigma) {
      const Spread spread = SpreadOf(particles, value);
      EXPECT_NEAR(spread.std, 2 * sigma, 0.1 * sigma) << rate_hz;  // after four seconds
      EXPECT_NEAR(spread.mean, 0, 0.1 * sigma) << rate_hz;
    };
    expect([&](const Particle& p) { return p.x_c - start.x_c; }, options.bearing_noise);
    expect([&](const Particle& p) { return p.y_c - start.y_c; }, options.bearing_noise);
    expect([&](const Particle& p) { return p.rho - start.rho; }, options.log_depth_noise);
    expect([&](const Particle& p) { return WrapAngle(p.azimuth - start.azimuth); },
           options.azimuth_noise_deg * kRadPerDeg);
  }
}

TEST(Diffuse, JumpsStayInTheCategoryAndKeepTheBase) {
  const MapFrame map = ZUpFrame();
  MapperOptions options;
  options.jump_rate = 2;
  std::vector<Particle> particles = Many(Standing(map, "chair", 0.2, 0.1, 0.3), 4000);
  Diffuse(particles, WatchingCamera(), map, 0.5, options, {.seed = 6});
  int armchairs = 0;
  for (const Particle& particle : particles) {
    EXPECT_EQ(map.database->models()[particle.label].category, "chair");
    armchairs += ModelId{particle.label} == Label(map, "armchair") ? 1 : 0;
  }
  // A jump happens with probability 1 - exp(-1) and picks either label alike; 4 standard
  // deviations.
  EXPECT_NEAR(armchairs, 4000 * 0.5 * (1 - std::exp(-1.0)), 4 * std::sqrt(4000 * 0.32 * 0.68));
  const Spread height = SpreadOf(particles, [&](const Particle& p) { return HeightOf(p, map); });
  EXPECT_NEAR(height.mean, 0, 0.002);
  EXPECT_LE(height.std, 1.1 * options.floor_std_m);

  options.jump_scope = JumpScope::kAll;
  Diffuse(particles, WatchingCamera(), map, 5, options, {.seed = 6});
  std::vector<int> counts(map.database->models().size(), 0);
  for (const Particle& particle : particles) ++counts[particle.label];
  for (const int count : counts) EXPECT_NEAR(count, 800, 120);
}

TEST(Diffuse, RepeatsForTheSameKeyOnly) {
  const MapFrame map = ZUpFrame();
  std::vector<Particle> a = Many(Standing(map, "chair", 0, 0, 0), 100), b = a, c = a;
  Diffuse(a, WatchingCamera(), map, 0.1, {}, {.seed = 1, .frame = 5, .object = 2});
  Diffuse(b, WatchingCamera(), map, 0.1, {}, {.seed = 1, .frame = 5, .object = 2});
  Diffuse(c, WatchingCamera(), map, 0.1, {}, {.seed = 1, .frame = 6, .object = 2});
  int differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].x_c, b[i].x_c);
    EXPECT_EQ(a[i].azimuth, b[i].azimuth);
    differ += a[i].x_c != c[i].x_c ? 1 : 0;
  }
  EXPECT_GT(differ, 95);
}

std::vector<Particle> Weighted(std::initializer_list<float> log_weights) {
  std::vector<Particle> particles;
  for (const float log_weight : log_weights) {
    particles.emplace_back();
    particles.back().log_weight = log_weight;
  }
  return particles;
}

TEST(Weights, NormaliseInLogSpace) {
  std::vector<Particle> particles = Weighted({-2000, -2001, -2003, 1000});
  EXPECT_NEAR(NormalizeLogWeights(particles), 1000, 1e-3);
  EXPECT_NEAR(particles[3].log_weight, 0, 1e-6);
  particles = Weighted({-2000, -2001});
  EXPECT_NEAR(NormalizeLogWeights(particles), -2000 + std::log(1 + std::exp(-1)), 1e-3);
  EXPECT_NEAR(std::exp(particles[0].log_weight) + std::exp(particles[1].log_weight), 1, 1e-6);
}

TEST(Weights, BecomeUniformWhereNothingFits) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Particle> particles = Weighted({-infinity, -infinity});
  EXPECT_EQ(NormalizeLogWeights(particles), -std::numeric_limits<double>::infinity());
  EXPECT_NEAR(particles[1].log_weight, -std::log(2.0), 1e-6);
  particles = Weighted({nan, nan, nan, nan});
  NormalizeLogWeights(particles);
  EXPECT_NEAR(particles[1].log_weight, -std::log(4.0), 1e-6);
  particles = Weighted({nan, -3});
  NormalizeLogWeights(particles);
  EXPECT_EQ(particles[0].log_weight, -infinity);
  EXPECT_NEAR(particles[1].log_weight, 0, 1e-6);
}

TEST(Weights, EffectiveSampleSizeCountsEqualParticles) {
  EXPECT_NEAR(EffectiveSampleSize(
                  Weighted({std::log(0.25f), std::log(0.25f), std::log(0.25f), std::log(0.25f)})),
              4, 1e-5);
  EXPECT_NEAR(EffectiveSampleSize(Weighted({0, -1000, -1000})), 1, 1e-6);
}

TEST(SystematicResample, CopiesEachParticleWithinOneOfItsShare) {
  for (std::uint32_t run = 0; run < 200; ++run) {
    Random random({.seed = 11, .particle = run});
    std::vector<Particle> particles(1 + random.Index(300));
    for (Particle& particle : particles)
      particle.log_weight = static_cast<float>(4 * random.Gaussian());
    NormalizeLogWeights(particles);
    const int count = 1 + static_cast<int>(random.Index(800));
    const std::vector<Particle> drawn = SystematicResample(particles, count, {.frame = run});
    ASSERT_EQ(drawn.size(), static_cast<std::size_t>(count));
    std::vector<int> copies(particles.size(), 0);
    for (const Particle& particle : drawn) {
      ++copies[particle.ancestor];
      EXPECT_EQ(particle.log_weight, -std::log(static_cast<float>(count)));
    }
    for (std::size_t i = 0; i < particles.size(); ++i) {
      EXPECT_LE(std::abs(copies[i] - count * std::exp(double{particles[i].log_weight})), 1.0 + 1e-3)
          << "particle " << i << " of run " << run;
    }
  }
}

TEST(SystematicResample, NeverPicksAParticleWithoutWeight) {
  std::vector<Particle> particles = Weighted({0, 0, 0, 0});
  particles[0].log_weight = particles[3].log_weight = -std::numeric_limits<float>::infinity();
  NormalizeLogWeights(particles);
  for (std::uint32_t run = 0; run < 50; ++run) {
    for (const Particle& particle : SystematicResample(particles, 7, {.frame = run})) {
      EXPECT_TRUE(particle.ancestor == 1 || particle.ancestor == 2);
    }
  }
}

/// `count` particles around a hypothesis (3 cm, 4 degrees), of total weight `weight`.
void AddCloud(const PoseHypothesis& middle, int count, double weight,
              std::vector<Particle>& particles) {
  for (int i = 0; i < count; ++i) {
    Random random({.seed = 21, .particle = static_cast<std::uint32_t>(particles.size())});
    PoseHypothesis hypothesis = middle;
    hypothesis.center_in_world += 0.03 * GaussianVector<3>(random);
    hypothesis.azimuth_rad += 4 * kRadPerDeg * random.Gaussian();
    particles.push_back(ToParticle(hypothesis, WatchingCamera()));
    particles.back().log_weight = static_cast<float>(std::log(weight / count));
  }
}

void ExpectMode(const PoseMode& mode, const PoseHypothesis& middle, double weight,
                const MapFrame& map) {
  EXPECT_EQ(mode.label, middle.label);
  EXPECT_NEAR(mode.weight, weight, 0.02);
  const PoseHypothesis found = ToHypothesis(mode, map);
  EXPECT_LT((found.center_in_world - middle.center_in_world).norm(), 0.01);
  EXPECT_LT(std::abs(AzimuthDifference(map.database->model(middle.label), found.azimuth_rad,
                                       middle.azimuth_rad)),
            1.0 * kRadPerDeg);
  EXPECT_NEAR(mode.position_std_m, 0.03 * std::sqrt(3.0), 0.01);
  EXPECT_NEAR(mode.azimuth_std_rad, 4 * kRadPerDeg, 1 * kRadPerDeg);
  EXPECT_LT((mode.world_from_object.linear().col(2) - map.upright.up_in_world()).norm(), 1e-9);
}

TEST(FindModes, GivesMeanAndDeviationOfTheScale) {
  const MapFrame map = ZUpFrame();
  const PoseHypothesis here = Standing(map, "chair", 0, 0, 1);
  std::vector<Particle> particles;
  AddCloud(here, 2000, 1, particles);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    Random random({.seed = 22, .particle = static_cast<std::uint32_t>(i)});
    particles[i].log_scale = static_cast<float>(0.04 + 0.02 * random.Gaussian());
  }
  const std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
  ASSERT_EQ(modes.size(), 1u);
  // Four standard errors of 2000 draws.
  EXPECT_NEAR(std::log(modes[0].scale), 0.04, 4 * 0.02 / std::sqrt(2000.0));
  EXPECT_NEAR(modes[0].scale_std, 0.02, 4 * 0.02 / std::sqrt(4000.0));
  EXPECT_LT((ToHypothesis(modes[0], map).center_in_world - here.center_in_world).norm(), 0.01);
}

TEST(FindModes, KeepsTheTwoHalvesOfAHalfTurnApart) {
  const MapFrame map = ZUpFrame();
  // Across the wrap of the angle, too.
  for (const double azimuth : {0.4, std::numbers::pi - 0.02, -1.5, 0.0}) {
    const PoseHypothesis first = Standing(map, "chair", 0.1, 0.2, azimuth);
    PoseHypothesis second = first;
    second.azimuth_rad += std::numbers::pi;
    std::vector<Particle> particles;
    AddCloud(first, 300, 0.65, particles);
    AddCloud(second, 200, 0.35, particles);
    const std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
    ASSERT_EQ(modes.size(), 2u) << azimuth;
    ExpectMode(modes[0], first, 0.65, map);
    ExpectMode(modes[1], second, 0.35, map);
  }
}

TEST(FindModes, KeepsTwoPlacesAndTwoShapesApart) {
  const MapFrame map = ZUpFrame();
  const PoseHypothesis here = Standing(map, "chair", 0, 0, 1),
                       there = Standing(map, "chair", 0.45, 0.1, 1),
                       other = Standing(map, "armchair", 0, 0, 1);
  std::vector<Particle> particles;
  AddCloud(there, 200, 0.3, particles);
  AddCloud(here, 300, 0.5, particles);
  AddCloud(other, 200, 0.2, particles);
  const std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
  ASSERT_EQ(modes.size(), 3u);
  ExpectMode(modes[0], here, 0.5, map);
  ExpectMode(modes[1], there, 0.3, map);
  ExpectMode(modes[2], other, 0.2, map);
}

TEST(FindModes, SeesASymmetricShapeInOnePlaceOnce) {
  const MapFrame map = ZUpFrame();
  const PoseHypothesis table = Standing(map, "table", 0, 0.3, 3.0);
  PoseHypothesis turned = table;
  turned.azimuth_rad += std::numbers::pi;
  std::vector<Particle> particles;
  AddCloud(table, 300, 0.5, particles);
  AddCloud(turned, 300, 0.5, particles);
  std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
  ASSERT_EQ(modes.size(), 1u);
  ExpectMode(modes[0], table, 1.0, map);

  particles.clear();
  const PoseHypothesis vase = Standing(map, "vase", 0, 0.3, 0);
  for (int i = 0; i < 36; ++i) {
    PoseHypothesis any = vase;
    any.azimuth_rad = i * 10 * kRadPerDeg;
    AddCloud(any, 20, 1.0 / 36, particles);
  }
  modes = FindModes(particles, WatchingCamera(), map);
  ASSERT_EQ(modes.size(), 1u);
  EXPECT_NEAR(modes[0].weight, 1, 1e-4);
  EXPECT_LT((ToHypothesis(modes[0], map).center_in_world - vase.center_in_world).norm(), 0.01);
  EXPECT_EQ(modes[0].azimuth_std_rad, 0);
}

TEST(FindModes, LeavesOutStraysButAlwaysReturnsOne) {
  const MapFrame map = ZUpFrame();
  const PoseHypothesis here = Standing(map, "chair", 0, 0, 1);
  std::vector<Particle> particles;
  AddCloud(here, 500, 0.97, particles);
  AddCloud(Standing(map, "chair", 1.5, 0.5, 2), 10, 0.03, particles);
  const std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
  ASSERT_EQ(modes.size(), 1u);
  ExpectMode(modes[0], here, 0.97, map);

  // Spread so wide that no place has five percent.
  particles.clear();
  for (int i = 0; i < 200; ++i) {
    Random random({.seed = 5, .particle = static_cast<std::uint32_t>(i)});
    PoseHypothesis anywhere =
        Standing(map, "chair", random.Uniform(-4, 4), random.Uniform(0, 8), random.Uniform(-3, 3));
    particles.push_back(ToParticle(anywhere, WatchingCamera()));
    particles.back().log_weight = -std::log(200.0f);
  }
  EXPECT_GE(FindModes(particles, WatchingCamera(), map).size(), 1u);
  particles.resize(1);
  EXPECT_EQ(FindModes(particles, WatchingCamera(), map).size(), 1u);
}

TEST(ModeCovariance, MeasuresTheHeaviestModeOnly) {
  const MapFrame map = ZUpFrame();
  const PoseHypothesis here = Standing(map, "chair", 0, 0, 1);
  PoseHypothesis twin = here;
  twin.azimuth_rad += std::numbers::pi;
  std::vector<Particle> particles;
  AddCloud(here, 2000, 0.7, particles);
  AddCloud(twin, 1000, 0.3, particles);
  const std::vector<PoseMode> modes = FindModes(particles, WatchingCamera(), map);
  const Eigen::Matrix4d covariance = ModeCovariance(modes[0], particles, WatchingCamera(), map);
  EXPECT_LT((covariance - covariance.transpose()).norm(), 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::sqrt(covariance(k, k)), 0.03, 0.003);
  EXPECT_NEAR(std::sqrt(covariance(3, 3)), 4 * kRadPerDeg, 0.4 * kRadPerDeg);
}

TEST(LabelPosterior, SumsWeightsByLabel) {
  std::vector<Particle> particles =
      Weighted({std::log(0.2f), std::log(0.5f), std::log(0.2f), std::log(0.1f)});
  particles[1].label = 3;
  particles[3].label = 1;
  const std::vector<LabelProbability> posterior = LabelPosterior(particles);
  ASSERT_EQ(posterior.size(), 3u);
  EXPECT_EQ(posterior[0].label, ModelId{3});
  EXPECT_NEAR(posterior[0].probability, 0.5, 1e-6);
  EXPECT_NEAR(posterior[1].probability, 0.4, 1e-6);
  EXPECT_NEAR(posterior[2].probability, 0.1, 1e-6);
}

TEST(AzimuthDifference, FoldsSymmetricTurns) {
  CadModel model;
  model.symmetry.order = 1;
  EXPECT_NEAR(AzimuthDifference(model, 3.0, -3.0), 6.0 - 2 * std::numbers::pi, 1e-12);
  model.symmetry.order = 2;
  EXPECT_NEAR(AzimuthDifference(model, 0.1 + std::numbers::pi, 0), 0.1, 1e-12);
  model.symmetry.order = 4;
  EXPECT_NEAR(AzimuthDifference(model, 0.1 + std::numbers::pi / 2, 0), 0.1, 1e-12);
  model.symmetry.order = 0;
  EXPECT_EQ(AzimuthDifference(model, 2.5, 0), 0);
}

}  // namespace
}  // namespace plumbline
