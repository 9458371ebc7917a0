// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/pose_sampler.h"
#include "engine/geometry/random_vector.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

/// Targets in closed form: what comes out must be what was asked for, whatever the number of
/// particles and wherever they start.
class PoseSamplerTest : public testing::TestWithParam<int> {
 protected:
  static constexpr double kScaleStd = 0.02;

  std::size_t count() const { return static_cast<std::size_t>(GetParam()); }

  PoseHypothesis At(const char* name, double x, double y, double azimuth_rad) const {
    return {map_.database->Find(name).value(), azimuth_rad, {x, y, 0.5}};
  }
  /// Gaussian about a pose, in (x, y, z) [m], azimuth [rad] and log-scale; -infinity for other
  /// shapes. Proper: a target that left the size alone would have no width to come out.
  static double LogGaussian(const PoseHypothesis& h, const PoseHypothesis& mean, double std_m,
                            double std_rad) {
    if (h.label != mean.label) return -1e30;
    const double turn = WrapAngle(h.azimuth_rad - mean.azimuth_rad) / std_rad;
    const double size = (h.log_scale - mean.log_scale) / kScaleStd;
    return -0.5 * ((h.center_in_world - mean.center_in_world).squaredNorm() / (std_m * std_m) +
                   turn * turn + size * size) -
           3 * std::log(std_m) - std::log(std_rad);
  }
  PoseSampler Sampler(std::function<double(const PoseHypothesis&)> log_density,
                      std::uint32_t frame = 1) const {
    return {map_,
            options_,
            [log_density](std::span<const PoseHypothesis> hypotheses) {
              std::vector<Judgement> judged(hypotheses.size());
              for (std::size_t i = 0; i < judged.size(); ++i)
                judged[i].log_target = log_density(hypotheses[i]);
              return judged;
            },
            {.seed = 3, .frame = frame}};
  }
  Population Around(const PoseHypothesis& mean, double std_m, double std_rad,
                    const PoseSampler& sampler) const {
    Population population;
    for (std::size_t i = 0; i < count(); ++i) {
      Random random({.seed = 8, .particle = static_cast<std::uint32_t>(i)});
      PoseHypothesis h = mean;
      h.center_in_world += std_m * GaussianVector<3>(random);
      h.azimuth_rad = WrapAngle(h.azimuth_rad + std_rad * random.Gaussian());
      population.hypotheses.push_back(h);
    }
    population.judged = sampler.Judge(population.hypotheses);
    return population;
  }
  /// As the mapper does it: search, jump, walk.
  void Sweep(PoseSampler& sampler, Population& population, int sweeps, bool search) const {
    for (int i = 0; i < sweeps; ++i) {
      const std::vector<PoseHypothesis> challengers =
          search ? sampler.Challengers(population.hypotheses, 200) : std::vector<PoseHypothesis>{};
      sampler.Jump(population, sampler.FindModes(population, challengers));
      sampler.Walk(population);
    }
  }
  template <typename Condition>
  double Share(const Population& population, Condition condition) const {
    double sum = 0;
    for (const PoseHypothesis& h : population.hypotheses) sum += condition(h) ? 1 : 0;
    return sum / static_cast<double>(population.size());
  }
  /// Four standard errors of a share.
  double Error(double share) const {
    return 4 * std::sqrt(share * (1 - share) / static_cast<double>(count()));
  }

  const MapFrame map_{UprightFrame({0, 0, -1}), std::nullopt, MakeFurnitureDatabase()};
  MapperOptions options_;
};

TEST_P(PoseSamplerTest, GaussiansKeepTheirWidthFromAnyStart) {
  for (const double std_m : {0.01, 0.02, 0.04, 0.08}) {
    for (const double start : {0.3, 1.0, 2.0}) {
      const double std_rad = 3 * kRadPerDeg;
      const PoseHypothesis mean = At("chair", 1, 2, 0.4);
      PoseSampler sampler =
          Sampler([&](const PoseHypothesis& h) { return LogGaussian(h, mean, std_m, std_rad); });
      Population population = Around(mean, start * std_m, start * std_rad, sampler);
      Sweep(sampler, population, 20, false);
      Eigen::Vector4d squares = Eigen::Vector4d::Zero();
      for (const PoseHypothesis& h : population.hypotheses) {
        const Eigen::Vector3d d = (h.center_in_world - mean.center_in_world) / std_m;
        const double turn = WrapAngle(h.azimuth_rad - mean.azimuth_rad) / std_rad;
        squares += Eigen::Vector4d(d.x() * d.x(), d.y() * d.y(), d.z() * d.z(), turn * turn);
      }
      squares /= static_cast<double>(count());
      // The variance of a mean of squares of standard normals is 2 / n.
      for (int k = 0; k < 4; ++k) {
        EXPECT_NEAR(squares[k], 1, 4 * std::sqrt(2.0 / static_cast<double>(count())))
            << "std " << std_m << " m, started at " << start << ", coordinate " << k;
      }
    }
  }
}

TEST_P(PoseSamplerTest, AScaleComesOutAsItIsAsked) {
  options_.scale_std = 0.03;
  PoseHypothesis mean = At("chair", 1, 2, 0.4);
  mean.log_scale = 0.01;
  for (const double start : {0.0, 1.0, 2.0}) {
    PoseSampler sampler =
        Sampler([&](const PoseHypothesis& h) { return LogGaussian(h, mean, 0.02, 0.05); });
    Population population = Around(mean, 0.02, 0.05, sampler);
    for (std::size_t i = 0; i < count(); ++i) {
      Random random({.seed = 9, .particle = static_cast<std::uint32_t>(i)});
      population.hypotheses[i].log_scale = 0.01 + start * kScaleStd * random.Gaussian();
    }
    population.judged = sampler.Judge(population.hypotheses);
    Sweep(sampler, population, 20, false);
    double sum = 0, squares = 0, position = 0;
    for (const PoseHypothesis& h : population.hypotheses) {
      const double off = (h.log_scale - 0.01) / kScaleStd;
      sum += off / static_cast<double>(count());
      squares += off * off / static_cast<double>(count());
      position += (h.center_in_world - mean.center_in_world).squaredNorm() /
                  (3 * 0.02 * 0.02 * static_cast<double>(count()));
    }
    EXPECT_NEAR(sum, 0, 4 / std::sqrt(static_cast<double>(count()))) << start;
    EXPECT_NEAR(squares, 1, 4 * std::sqrt(2.0 / static_cast<double>(count()))) << start;
    EXPECT_NEAR(position, 1, 4 * std::sqrt(2.0 / (3 * static_cast<double>(count())))) << start;
  }
}

TEST_P(PoseSamplerTest, ARidgeOfSizeAndDistanceIsFilled) {
  // What one camera sees: size over distance to 0.3 %, bearings to 5 mm; and the prior of the size.
  options_.scale_std = 0.03;
  constexpr double kDistance_m = 2, kRatio = 0.003, kBearing_m = 0.005;
  const PoseHypothesis mean = At("chair", kDistance_m, 0, 0.4);
  PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
    if (h.label != mean.label) return -1e30;
    const Eigen::Vector3d& at = h.center_in_world;
    const double ratio = (h.log_scale - std::log(at.x() / kDistance_m)) / kRatio;
    const double across = std::hypot(at.y(), at.z() - 0.5) / kBearing_m;
    const double turn = WrapAngle(h.azimuth_rad - 0.4) / 0.05, size = h.log_scale / 0.03;
    return -0.5 * (ratio * ratio + across * across + turn * turn + size * size);
  });
  Population population = Around(mean, 0.005, 0.05, sampler);
  Sweep(sampler, population, 40, false);
  double size = 0, ratio = 0, both = 0, distance = 0;
  const auto n = static_cast<double>(count());
  for (const PoseHypothesis& h : population.hypotheses) {
    const double depth = std::log(h.center_in_world.x() / kDistance_m);
    size += h.log_scale * h.log_scale / (0.03 * 0.03 * n);
    ratio += (h.log_scale - depth) * (h.log_scale - depth) / (kRatio * kRatio * n);
    both += h.log_scale * depth / n;
    distance += depth * depth / n;
  }
  EXPECT_NEAR(size, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(ratio, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(both / (0.03 * std::sqrt(size * distance)), 0.995, 0.005) << "correlation";
}

TEST_P(PoseSamplerTest, TwinsAreFoundAndSharedEqually) {
  const PoseHypothesis a = At("chair", 1, 2, 0.4),
                       b = At("chair", 1.3, 2.2, 0.4 - std::numbers::pi);
  PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
    const double la = LogGaussian(h, a, 0.02, 0.05), lb = LogGaussian(h, b, 0.02, 0.05);
    return std::max(la, lb) + std::log1p(std::exp(-std::abs(la - lb)));
  });
  Population population = Around(a, 0.02, 0.05, sampler);
  // The search has to find the twin: challengers about it, roughly.
  std::vector<PoseHypothesis> rough = Around(b, 0.08, 0.2, sampler).hypotheses;
  rough.resize(100);
  for (int i = 0; i < 20; ++i) {
    sampler.Jump(population, sampler.FindModes(population, rough));
    sampler.Walk(population);
  }
  const double share = Share(population, [&](const PoseHypothesis& h) {
    return (h.center_in_world - a.center_in_world).norm() < 0.15;
  });
  EXPECT_NEAR(share, 0.5, Error(0.5));
}

TEST_P(PoseSamplerTest, ShapesComeOutInTheirProportions) {
  const PoseHypothesis a = At("chair", 1, 2, 0.4), b = At("armchair", 1, 2, 0.4);
  PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
    return h.label == a.label   ? std::log(0.7) + LogGaussian(h, a, 0.02, 0.05)
           : h.label == b.label ? std::log(0.3) + LogGaussian(h, b, 0.03, 0.04)
                                : -1e30;
  });
  Population population = Around(a, 0.02, 0.05, sampler);
  std::vector<PoseHypothesis> rough = Around(b, 0.05, 0.1, sampler).hypotheses;
  rough.resize(100);
  for (int i = 0; i < 20; ++i) {
    sampler.Jump(population, sampler.FindModes(population, rough));
    sampler.Walk(population);
  }
  EXPECT_NEAR(Share(population, [&](const PoseHypothesis& h) { return h.label == a.label; }), 0.7,
              Error(0.7));
}

TEST_P(PoseSamplerTest, TellsByHowMuchAnotherShapeInThePlaceFallsShort) {
  const PoseHypothesis a = At("chair", 1, 2, 0.4), b = At("armchair", 1.01, 2.01, 0.42);
  for (const double log_ratio : {0.0, -7.0, -20.0}) {
    PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
      return h.label == a.label   ? LogGaussian(h, a, 0.02, 0.05)
             : h.label == b.label ? log_ratio + LogGaussian(h, b, 0.03, 0.04)
                                  : -1e30;
    });
    Population population = Around(a, 0.02, 0.05, sampler);
    for (int i = 0; i < 10; ++i) sampler.Walk(population);
    const std::vector<ShapeRival> rivals = sampler.RivalShapes(population, 30);
    ASSERT_EQ(rivals.size(), 1u) << "of all shapes but those that are impossible";
    EXPECT_EQ(rivals.front().label, b.label);
    EXPECT_NEAR(rivals.front().log_ratio, log_ratio, 1.5);
    if (log_ratio < -10) EXPECT_TRUE(sampler.RivalShapes(population, 10).empty());
  }
}

TEST_P(PoseSamplerTest, ASharpRivalIsReachedFromARoughSearch) {
  const PoseHypothesis a = At("chair", 1, 2, 0.4), b = At("armchair", 1.02, 2.01, 0.42);
  constexpr double kStd_m = 0.002, kStd_rad = 0.2 * kRadPerDeg;
  PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
    return h.label == a.label   ? std::log(0.1) + LogGaussian(h, a, kStd_m, kStd_rad)
           : h.label == b.label ? std::log(0.9) + LogGaussian(h, b, kStd_m, kStd_rad)
                                : -1e30;
  });
  Population population = Around(a, kStd_m, kStd_rad, sampler);
  std::vector<PoseHypothesis> rough = Around(b, 0.05, 0.1, sampler).hypotheses;
  rough.resize(100);
  for (int i = 0; i < 10; ++i) {
    sampler.Jump(population, sampler.FindModes(population, rough));
    sampler.Walk(population);
  }
  EXPECT_NEAR(Share(population, [&](const PoseHypothesis& h) { return h.label == b.label; }), 0.9,
              Error(0.9));
}

TEST_P(PoseSamplerTest, ASharpTargetIsSearchedAsABluntOne) {
  // Two shapes, bounded as edges are; one fits three times as well and is looked for 2 cm off,
  // among as many of the one that is known.
  constexpr double kSharpness = 16, kHeight = 10, kStd_m = 0.02, kStd_rad = 2 * kRadPerDeg;
  const PoseHypothesis a = At("chair", 1, 2, 0.4), b = At("armchair", 1.02, 2.01, 0.42);
  const auto log_target = [&](const PoseHypothesis& h, const PoseHypothesis& mean) {
    if (h.label != mean.label) return 0.0;
    const double turn = WrapAngle(h.azimuth_rad - mean.azimuth_rad) / kStd_rad;
    const double off = (h.center_in_world - mean.center_in_world).squaredNorm() / (kStd_m * kStd_m);
    return kSharpness * kHeight * std::exp(-0.5 * (off + turn * turn));
  };
  const auto share_of_b = [&](double sharpness) {
    PoseSampler sampler = Sampler([&](const PoseHypothesis& h) {
      return std::log(h.label == b.label ? 3 : 1) + log_target(h, a) + log_target(h, b);
    });
    const double narrow = 1 / std::sqrt(kSharpness * kHeight);
    Population population = Around(a, narrow * kStd_m, narrow * kStd_rad, sampler);
    std::vector<PoseHypothesis> rough = Around(b, 0.02, 0.03, sampler).hypotheses;
    rough.resize(20);
    std::vector<PoseHypothesis> near = Around(a, 0.02, 0.03, sampler).hypotheses;
    rough.insert(rough.end(), near.begin(), near.begin() + 80);
    for (int i = 0; i < 20; ++i) {
      sampler.Jump(population, sampler.FindModes(population, rough, sharpness));
      sampler.Walk(population);
    }
    return Share(population, [&](const PoseHypothesis& h) { return h.label == b.label; });
  };
  EXPECT_NEAR(share_of_b(kSharpness), 0.75, 1.5 * Error(0.75));
  EXPECT_LT(share_of_b(1), 0.1) << "then no search needs to know how sharp its target is";
}

TEST_P(PoseSamplerTest, AWiderShapeWithAnEndInCommonIsFound) {
  // What showed of a wide sofa was one end: a small one was taken for it, whose middle is 40 cm
  // from the wide one's. Targets are bounded, as edges are: away from them nothing leads there.
  MapFrame sofas = map_;
  std::vector<CadModel> models(2);
  models[0].name = "small";
  models[1].name = "wide";
  for (CadModel& model : models) {
    const float half_y = model.name == "small" ? 0.6f : 1.0f;
    model.category = "couch";
    model.mesh = MakeBox({-0.4f, -half_y, 0}, {0.4f, half_y, 0.8f});
    model.bounds = BoundingBox(model.mesh);
  }
  sofas.database = ModelDatabase::FromModels(std::move(models));
  const PoseHypothesis small{ModelId{0}, 0.4, {1, 2, 0.4}};
  PoseHypothesis wide{ModelId{1}, 0.4, small.center_in_world};
  wide.center_in_world +=
      Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(0, 0.4, 0);
  const auto fits = [](const PoseHypothesis& h, const PoseHypothesis& at) {
    if (h.label != at.label) return 0.0;
    const double off = (h.center_in_world - at.center_in_world).norm() / 0.05;
    const double turn = WrapAngle(h.azimuth_rad - at.azimuth_rad) / 0.1;
    const double size = h.log_scale / kScaleStd;
    return std::exp(-0.5 * (off * off + turn * turn + size * size));
  };
  PoseSampler sampler(sofas, options_,
                      [&](std::span<const PoseHypothesis> hypotheses) {
                        std::vector<Judgement> judged(hypotheses.size());
                        for (std::size_t i = 0; i < judged.size(); ++i)
                          judged[i].log_target =
                              12 * fits(hypotheses[i], small) + 24 * fits(hypotheses[i], wide);
                        return judged;
                      },
                      {.seed = 3, .frame = 1});
  Population population = Around(small, 0.01, 0.02, sampler);
  Sweep(sampler, population, 8, true);
  EXPECT_GT(Share(population, [&](const PoseHypothesis& h) { return h.label == wide.label; }), 0.9);
}

TEST_P(PoseSamplerTest, ASharpScreenIsTurnedRoundInItsPlace) {
  // Seen from behind first, a screen was taken for its twin; then its front shows. Its place is a
  // centimetre off, which is far where the target is sharp: a narrow peak on a broad hill.
  constexpr double kSharpness = 16, kStd_m = 0.01, kStd_rad = 1.5 * kRadPerDeg;
  MapFrame screens = map_;
  std::vector<CadModel> models(1);
  models[0].name = "screen";
  models[0].category = "tv";
  models[0].mesh = MakeBox({-0.1f, -0.28f, 0}, {0.1f, 0.28f, 0.5f});
  models[0].bounds = BoundingBox(models[0].mesh);
  screens.database = ModelDatabase::FromModels(std::move(models));
  const PoseHypothesis twin{ModelId{0}, 0.4, {1, 2, 0.25}};
  const PoseHypothesis right{ModelId{0}, WrapAngle(0.4 + std::numbers::pi), {1.01, 2.005, 0.25}};
  const auto fits = [&](const PoseHypothesis& h, const PoseHypothesis& at) {
    const double off = (h.center_in_world - at.center_in_world).norm() / kStd_m;
    const double turn = WrapAngle(h.azimuth_rad - at.azimuth_rad) / kStd_rad;
    const double size = h.log_scale / kScaleStd;
    const double squares = off * off + turn * turn + size * size;
    return 0.5 * std::exp(-0.5 * squares) + 0.5 * std::exp(-0.5 * squares / 16);
  };
  PoseSampler sampler(screens, options_,
                      [&](std::span<const PoseHypothesis> hypotheses) {
                        std::vector<Judgement> judged(hypotheses.size());
                        for (std::size_t i = 0; i < judged.size(); ++i)
                          judged[i].log_target = kSharpness * (12 * fits(hypotheses[i], twin) +
                                                               15 * fits(hypotheses[i], right));
                        return judged;
                      },
                      {.seed = 3, .frame = 1});
  Population population = Around(twin, 0.001, 0.002, sampler);
  for (int i = 0; i < 4; ++i) {
    sampler.Jump(
        population,
        sampler.FindModes(population, sampler.Challengers(population.hypotheses, 160), kSharpness));
    sampler.Walk(population);
  }
  EXPECT_GT(Share(population,
                  [&](const PoseHypothesis& h) {
                    return std::abs(WrapAngle(h.azimuth_rad - right.azimuth_rad)) < 0.1;
                  }),
            0.9);
}

TEST_P(PoseSamplerTest, TemperingFillsARing) {
  // Everywhere at once at the distance of 30 cm: no Gaussian fits it. Of few draws few are
  // ancestors of all, so one run says little of where the others are: ten are taken together.
  constexpr std::uint32_t kRuns = 10;
  double in_quadrants[2][2] = {}, squares = 0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    PoseSampler sampler = Sampler(
        [&](const PoseHypothesis& h) {
          const double off = (h.center_in_world.head<2>().norm() - 0.3) / 0.02;
          const double height = (h.center_in_world.z() - 0.5) / 0.02;
          return -0.5 * (off * off + height * height);
        },
        run);
    std::vector<PoseHypothesis> draws;
    for (std::uint32_t i = 0; i < 4 * count(); ++i) {
      Random random({.seed = 4, .frame = run, .particle = i});
      PoseHypothesis h = At("chair", random.Uniform(-1, 1), random.Uniform(-1, 1),
                            random.Uniform(-std::numbers::pi, std::numbers::pi));
      h.center_in_world.z() += random.Uniform(-0.5, 0.5);
      draws.push_back(h);
    }
    Population population = sampler.Temper(draws, count());
    ASSERT_EQ(population.size(), count());
    for (int i = 0; i < 20; ++i) sampler.Walk(population);
    const double share = 1.0 / (kRuns * static_cast<double>(count()));
    for (const PoseHypothesis& h : population.hypotheses) {
      in_quadrants[h.center_in_world.x() > 0][h.center_in_world.y() > 0] += share;
      squares += share * std::pow(h.center_in_world.head<2>().norm() - 0.3, 2);
    }
  }
  for (const auto& row : in_quadrants) {
    for (const double share : row) EXPECT_NEAR(share, 0.25, Error(0.25));
  }
  EXPECT_NEAR(std::sqrt(squares), 0.02, 4 * 0.02 / std::sqrt(2.0 * static_cast<double>(count())));
}

TEST_P(PoseSamplerTest, RepeatsForTheSameKey) {
  const PoseHypothesis mean = At("chair", 1, 2, 0.4);
  const auto run = [&] {
    PoseSampler sampler =
        Sampler([&](const PoseHypothesis& h) { return LogGaussian(h, mean, 0.02, 0.05); });
    Population population = Around(mean, 0.02, 0.05, sampler);
    Sweep(sampler, population, 2, true);
    return population;
  };
  const Population a = run(), b = run();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.hypotheses[i].center_in_world, b.hypotheses[i].center_in_world);
    EXPECT_EQ(a.hypotheses[i].azimuth_rad, b.hypotheses[i].azimuth_rad);
  }
}

INSTANTIATE_TEST_SUITE_P(FewAndMany, PoseSamplerTest, testing::Values(100, 500, 5000),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace plumbline
