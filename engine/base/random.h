// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace plumbline {

/// Names one random draw. The same key always gives the same numbers, whatever was drawn before, on
/// whatever thread: runs repeat, resume and fork bit for bit.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t frame = 0;
  std::uint32_t object = 0;
  std::uint32_t particle = 0;
};

/// Counter-based generator (Philox4x32-10; Salmon et al., "Parallel random numbers: as easy as 1,
/// 2, 3", SC 2011). Constructing one is cheap: make one for each particle.
class Random {
 public:
  explicit Random(const RandomKey& key);

  std::uint32_t Bits();
  /// Uniform in [0, 1), 53 random bits.
  double Uniform();
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Standard normal (Box-Muller).
  double Gaussian();
  /// Uniform in 0 .. n-1; n > 0.
  std::uint32_t Index(std::uint32_t n);

 private:
  void Refill();

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace plumbline
