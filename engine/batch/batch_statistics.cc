// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>

#include <boost/math/distributions/students_t.hpp>

#include "engine/base/random.h"

namespace plumbline {
namespace {

constexpr double kLevel = 0.05;
constexpr double kPower = 0.8;
constexpr int kMostExact = 20;  ///< 2^20 patterns of signs take some milliseconds.
constexpr int kDraws = 100'000;
constexpr std::uint64_t kSignSeed = 0x5167'4E5;

/// The p-quantile of Student's t.
double StudentQuantile(double p, int dof) {
  return boost::math::quantile(boost::math::students_t(dof), p);
}

double MeanOf(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Sum of squared distances from the mean.
double SquaresAbout(double mean, std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

double DeviationOf(std::span<const double> values) {
  if (values.size() < 2) return 0;
  return std::sqrt(SquaresAbout(MeanOf(values), values) / static_cast<double>(values.size() - 1));
}

std::map<int, std::vector<double>> BySequence(std::span<const SequenceValue> values) {
  std::map<int, std::vector<double>> groups;
  for (const SequenceValue& value : values) groups[value.sequence].push_back(value.value);
  return groups;
}

/// How many patterns of signs give a sum that is at least as far out as the one that was seen.
class SignCount {
 public:
  explicit SignCount(double seen, double rounding) : seen_(seen), rounding_(rounding) {}
  void See(double sum) {
    ++patterns_;
    if (sum >= seen_ - rounding_) ++more_;
    if (sum <= seen_ + rounding_) ++less_;
    if (std::abs(sum) >= std::abs(seen_) - rounding_) ++apart_;
  }
  /// @param seen_too  The pattern that was seen counts as one more draw.
  void Write(bool seen_too, PairedDifference& result) const {
    const double one = seen_too ? 1 : 0, all = static_cast<double>(patterns_) + one;
    result.p = (static_cast<double>(apart_) + one) / all;
    result.p_more = (static_cast<double>(more_) + one) / all;
    result.p_less = (static_cast<double>(less_) + one) / all;
  }

 private:
  double seen_, rounding_;
  std::int64_t patterns_ = 0, more_ = 0, less_ = 0, apart_ = 0;
};

/// Every pattern once, each a change of one sign from the one before (Gray code).
void CountAllSigns(std::span<const double> terms, SignCount& count) {
  double sum = std::accumulate(terms.begin(), terms.end(), 0.0);
  count.See(sum);
  std::uint32_t negative = 0;
  for (std::uint32_t i = 1; i < (1U << terms.size()); ++i) {
    const int k = std::countr_zero(i);
    negative ^= 1U << k;
    sum += ((negative >> k & 1U) != 0 ? -2 : 2) * terms[static_cast<std::size_t>(k)];
    count.See(sum);
  }
}

void CountDrawnSigns(std::span<const double> terms, SignCount& count) {
  Random random({.seed = kSignSeed});
  for (int draw = 0; draw < kDraws; ++draw) {
    double sum = 0;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (i % 32 == 0) bits = random.Bits();
      sum += (bits >> (i % 32) & 1U) != 0 ? terms[i] : -terms[i];
    }
    count.See(sum);
  }
}

/// @param terms  What each pair adds to the mean.
void TestSigns(std::span<const double> terms, PairedDifference& result) {
  std::vector<double> differing;
  double size = 0;
  for (const double term : terms) {
    if (term != 0) differing.push_back(term);
    size += std::abs(term);
  }
  result.differing = static_cast<int>(differing.size());
  const bool exact = result.differing <= kMostExact;
  result.p_least = exact ? std::min(1.0, 2 * std::ldexp(1.0, -result.differing)) : 1.0 / kDraws;
  SignCount count(std::accumulate(differing.begin(), differing.end(), 0.0), 1e-9 * size);
  exact ? CountAllSigns(differing, count) : CountDrawnSigns(differing, count);
  count.Write(!exact, result);
}

}  // namespace

std::optional<MeanEstimate> EstimateMean(std::span<const SequenceValue> values) {
  if (values.empty()) return std::nullopt;
  std::vector<double> means;
  double within = 0;
  int within_dof = 0;
  const auto groups = BySequence(values);
  for (const auto& [sequence, group] : groups) {
    means.push_back(MeanOf(group));
    within += SquaresAbout(means.back(), group);
    within_dof += static_cast<int>(group.size()) - 1;
  }
  MeanEstimate estimate;
  estimate.mean = MeanOf(means);
  estimate.values = static_cast<int>(values.size());
  estimate.sequences = static_cast<int>(means.size());
  estimate.over_sequences = means.size() > 1;
  estimate.seed_std = within_dof > 0 ? std::sqrt(within / within_dof) : 0;
  estimate.sequence_std = DeviationOf(means);
  const std::vector<double>& units = estimate.over_sequences ? means : groups.begin()->second;
  if (units.size() < 2) return estimate;
  const int dof = static_cast<int>(units.size()) - 1;
  const double half = StudentQuantile(1 - kLevel / 2, dof) * DeviationOf(units) /
                      std::sqrt(static_cast<double>(units.size()));
  estimate.low = estimate.mean - half;
  estimate.high = estimate.mean + half;
  return estimate;
}

std::optional<PairedDifference> ComparePairs(std::span<const SequenceValue> differences) {
  const std::optional<MeanEstimate> mean = EstimateMean(differences);
  if (!mean) return std::nullopt;
  PairedDifference result;
  result.mean = *mean;
  const auto groups = BySequence(differences);
  std::vector<double> terms;
  double squares = 0;
  for (const auto& [sequence, group] : groups) {
    const double weight = 1.0 / static_cast<double>(groups.size() * group.size());
    for (const double difference : group) {
      terms.push_back(weight * difference);
      squares += std::pow(weight * (difference - mean->mean), 2);
    }
  }
  TestSigns(terms, result);
  const auto n = static_cast<double>(terms.size());
  if (terms.size() > 1) {
    const int dof = static_cast<int>(terms.size()) - 1;
    result.detectable = (StudentQuantile(1 - kLevel / 2, dof) + StudentQuantile(kPower, dof)) *
                        std::sqrt(squares * n / (n - 1));
  }
  return result;
}

std::vector<double> HolmAdjusted(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double most = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    most = std::max(most, std::min(1.0, static_cast<double>(p.size() - rank) * p[order[rank]]));
    adjusted[order[rank]] = most;
  }
  return adjusted;
}

}  // namespace plumbline
