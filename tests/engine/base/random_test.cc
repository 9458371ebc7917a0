// SPDX-License-Identifier: Apache-2.0
#include "engine/base/random.h"

#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Random, GivesTheKnownAnswersOfThePhiloxPaper) {
  // Random123's kat_vectors: philox4x32, 10 rounds, counter 0 and key 0.
  Random random({});
  EXPECT_EQ(random.Bits(), 0x6627e8d5u);
  EXPECT_EQ(random.Bits(), 0xe169c58du);
  EXPECT_EQ(random.Bits(), 0xbc57ac4cu);
  EXPECT_EQ(random.Bits(), 0x9b00dbd8u);
}

TEST(Random, RepeatsWithTheSameKeyWhateverWasDrawnBefore) {
  const RandomKey key{.seed = 5, .frame = 6, .object = 7, .particle = 8};
  Random other({.seed = 1});
  Random first(key), second(key);
  for (int i = 0; i < 100; ++i) {
    other.Gaussian();
    EXPECT_EQ(first.Gaussian(), second.Gaussian());
  }
}

TEST(Random, DiffersInEveryPartOfTheKey) {
  std::set<std::tuple<std::uint32_t, std::uint32_t>> seen;
  for (const RandomKey& key :
       {RandomKey{}, RandomKey{.seed = 1}, RandomKey{.seed = std::uint64_t{1} << 32},
        RandomKey{.frame = 1}, RandomKey{.object = 1}, RandomKey{.particle = 1}}) {
    Random random(key);
    const std::uint32_t first = random.Bits();
    seen.emplace(first, random.Bits());
  }
  EXPECT_EQ(seen.size(), 6u);
}

TEST(Random, FillsTheUnitIntervalEvenly) {
  constexpr int kBins = 64, kDraws = 640000;
  std::array<int, kBins> counts{};
  Random random({.seed = 3});
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.Uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++counts[static_cast<std::size_t>(u * kBins)];
  }
  double chi_squared = 0;
  for (const int count : counts)
    chi_squared += std::pow(count - kDraws / kBins, 2) / (kDraws / kBins);
  // 63 degrees of freedom: mean 63, standard deviation 11.2; five of them either way.
  EXPECT_GT(chi_squared, 7);
  EXPECT_LT(chi_squared, 119);
}

TEST(Random, IsIndependentFromOneParticleToTheNext) {
  // Particles draw from neighbouring counters: the first draw of 100 000 of them must look like one
  // good stream.
  constexpr int kParticles = 100000;
  double sum = 0, sum_of_products = 0, previous = 0;
  for (int i = 0; i < kParticles; ++i) {
    const double u =
        Random({.seed = 9, .frame = 4, .object = 2, .particle = static_cast<std::uint32_t>(i)})
            .Uniform();
    sum += u - 0.5;
    sum_of_products += (u - 0.5) * previous;
    previous = u - 0.5;
  }
  // Standard errors: sqrt(1/12/N) = 0.0009 and (1/12)/sqrt(N) = 0.00026; five of each.
  EXPECT_NEAR(sum / kParticles, 0, 0.0046);
  EXPECT_NEAR(sum_of_products / kParticles, 0, 0.0014);
}

TEST(Random, GaussianHasTheMomentsOfTheStandardNormal) {
  constexpr int kDraws = 400000;
  Random random({.seed = 4});
  std::array<double, 5> moments{};
  int beyond_three = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.Gaussian();
    double power = 1;
    for (double& moment : moments) moment += (power *= x) / kDraws;
    if (std::abs(x) > 3) ++beyond_three;
  }
  // Standard errors of the means of x .. x^4 are sqrt(1, 2, 15, 96) / sqrt(N); five of each.
  const double error = 5 / std::sqrt(kDraws);
  EXPECT_NEAR(moments[0], 0, error);
  EXPECT_NEAR(moments[1], 1, error * std::sqrt(2));
  EXPECT_NEAR(moments[2], 0, error * std::sqrt(15));
  EXPECT_NEAR(moments[3], 3, error * std::sqrt(96));
  EXPECT_NEAR(beyond_three, 0.0027 * kDraws, 5 * std::sqrt(0.0027 * kDraws));
}

TEST(Random, IndexReachesEveryValueEquallyOften) {
  std::array<int, 7> counts{};
  Random random({.seed = 6});
  for (int i = 0; i < 70000; ++i) ++counts.at(random.Index(7));
  for (const int count : counts) EXPECT_NEAR(count, 10000, 5 * std::sqrt(10000.0 * 6 / 7));
  EXPECT_EQ(random.Index(1), 0u);
}

}  // namespace
}  // namespace plumbline
