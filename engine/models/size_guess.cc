// SPDX-License-Identifier: Apache-2.0
#include "engine/models/size_guess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

#include "engine/models/axis_guess.h"

namespace plumbline {
namespace {

constexpr double kDegreesOfFreedom = 5;
constexpr double kFarOff = 3.5;     ///< Deviations.
constexpr double kOddUnits = 0.03;  ///< Of files that are in inches, or in no unit at all.

/// How often files are in metres, centimetres, millimetres.
constexpr std::array<double, 3> kUnitHabit = {0.6, 0.25, 0.15}, kStlUnitHabit = {0.25, 0.15, 0.6};

/// Of anything in a room: the longest side about 0.7 m, within a factor of 3.
double LogFitInRoom(const Eigen::Vector3d& size_m) { return LogFit(size_m.maxCoeff(), 0.7, 1.1); }

double LogFitLying(const Eigen::Vector3d& size_m, const Thing& thing) {
  double best = LogFitStanding(size_m, 0, thing);
  for (const int up : {1, 2}) best = std::max(best, LogFitStanding(size_m, up, thing));
  return best;
}

}  // namespace

double LogFit(double length_m, double usual_m, double spread) {
  const double z = std::log(std::max(length_m, 1e-12) / usual_m) / spread;
  return -0.5 * (kDegreesOfFreedom + 1) * std::log1p(z * z / kDegreesOfFreedom);
}

double LogFitStanding(const Eigen::Vector3d& size_m, int up, const Thing& thing) {
  const double u = size_m[(up + 1) % 3], v = size_m[(up + 2) % 3];
  const auto across = [&](double width, double depth) {
    return LogFit(width, thing.width_m, thing.spread) + LogFit(depth, thing.depth_m, thing.spread);
  };
  return LogFit(size_m[up], thing.height_m, thing.spread) + std::max(across(u, v), across(v, u));
}

bool FitsThing(const Eigen::Vector3d& size_m, const Thing& thing) {
  std::array<int, 3> order = {0, 1, 2};
  do {
    const auto off = [&](int side, double usual_m) {
      return std::abs(std::log(std::max(size_m[side], 1e-12) / usual_m)) / thing.spread;
    };
    if (std::max({off(order[0], thing.height_m), off(order[1], thing.width_m),
                  off(order[2], thing.depth_m)}) < kFarOff) {
      return true;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return false;
}

Guess<LengthUnit> GuessUnit(const Eigen::Vector3d& size, const KnownOfMesh& known) {
  const auto& habit = known.extension == ".stl" ? kStlUnitHabit : kUnitHabit;
  Guess<LengthUnit> guess;
  double sum = 0;
  for (const LengthUnit unit :
       {LengthUnit::kMetre, LengthUnit::kCentimetre, LengthUnit::kMillimetre}) {
    const Eigen::Vector3d size_m = MetresPer(unit) * size;
    const double fit =
        known.thing != nullptr ? LogFitLying(size_m, *known.thing) : LogFitInRoom(size_m);
    // A floor under the tails: of three absurd sizes none is certain.
    const double likely = habit[static_cast<std::size_t>(unit)] * (std::exp(fit) + 1e-6);
    guess.shares.emplace_back(unit, likely);
    sum += likely;
  }
  for (auto& [unit, share] : guess.shares) share = (1 - kOddUnits) * share / sum + kOddUnits / 3;
  std::stable_sort(guess.shares.begin(), guess.shares.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  guess.value = guess.shares[0].first;
  guess.confidence = guess.shares[0].second;
  const double largest_m = MetresPer(guess.value) * size.maxCoeff();
  const Thing* thing = known.thing;
  const double usual_m =
      thing == nullptr ? 0.7 : std::max({thing->height_m, thing->width_m, thing->depth_m});
  char text[160];
  std::snprintf(text, sizeof(text), "so its longest side is %.3g m, and %.2g m is usual for %s",
                largest_m, usual_m,
                thing != nullptr ? ("a " + std::string(thing->name)).c_str() : "things in a room");
  guess.reason = text;
  return guess;
}

}  // namespace plumbline
