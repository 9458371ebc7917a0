// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "engine/models/axis_guess.h"
#include "engine/models/shape_measures.h"
#include "engine/models/side_view.h"
#include "engine/models/size_guess.h"

namespace plumbline {
namespace {

constexpr double kAlike = 0.004;      ///< Mirror distance under which two sides look alike.
constexpr double kFewLines = 0.02;    ///< Of the pixels: less is no detail.
constexpr double kOddFronts = 0.05;   ///< Follow no rule at all.
constexpr double kWithoutName = 0.5;  ///< What is seen counts less if nobody says what it is.

/// How often files have their fronts along each horizontal axis: toward who looks at the front view
/// of Blender, 3ds Max (z up: -y) or of glTF and Maya (y up: +z); +x is that of robots (REP 103).
double FrontHabitOf(const SignedAxis& front, const SignedAxis& up) {
  const SignedAxis first = up.axis == 2 ? SignedAxis{1, -up.sign} : SignedAxis{2, 1};
  if (front == first) return 0.4;
  if (front == SignedAxis{0, 1}) return 0.28;
  return 0.16;
}

/// Where the highest quarter lies beside the rest, of half the size along an axis.
double OffsetOfHighest(const ShapeMeasures& shape, const SignedAxis& up, int axis) {
  const double middle = shape.bounds.center()[up.axis],
               half_height = 0.5 * shape.bounds.sizes()[up.axis];
  std::array<double, 2> sum{};
  std::array<int, 2> count{};
  for (const Eigen::Vector3d& point : shape.points) {
    const std::size_t high = up.sign * (point[up.axis] - middle) < 0.5 * half_height ? 0 : 1;
    sum[high] += point[axis];
    ++count[high];
  }
  if (count[0] == 0 || count[1] == 0) return 0;
  return (sum[1] / count[1] - sum[0] / count[0]) / (0.5 * shape.bounds.sizes()[axis]);
}

/// Weighs the four horizontal directions.
class Facing {
 public:
  Facing(const TriangleMesh& mesh, const ShapeMeasures& shape, const SignedAxis& up,
         const KnownOfMesh& known)
      : mesh_(mesh), shape_(shape), up_(up), known_(known) {
    if (known.thing != nullptr) habit_ = known.thing->front;
  }

  double Weigh(const SignedAxis& front, std::string& reason) const {
    const double strength = known_.thing != nullptr ? 1.0 : kWithoutName;
    return std::log(FrontHabitOf(front, up_)) + strength * (OfSides(front) + OfEnds(front, reason));
  }

 private:
  /// What speaks for the axis: left and right alike, depth and width as usual.
  double OfSides(const SignedAxis& front) const {
    const int across = 3 - up_.axis - front.axis;
    const auto of = [](const std::array<double, 3>& values, int axis) {
      return values[static_cast<std::size_t>(axis)];
    };
    const double along = of(shape_.asymmetry, front.axis), beside = of(shape_.asymmetry, across);
    double weight = 0;
    if (std::max(along, beside) > kAlike) weight += 2 * (along - beside) / (along + beside);
    if (known_.thing == nullptr) return weight;
    const Eigen::Vector3d size_m = known_.metres * shape_.bounds.sizes();
    return weight + LogFit(size_m[front.axis], known_.thing->depth_m, known_.thing->spread) +
           LogFit(size_m[across], known_.thing->width_m, known_.thing->spread);
  }

  /// A board stands upright: what is high at one side of it is no back rest.
  bool TooThinForSeat(int axis) const {
    return shape_.bounds.sizes()[axis] < 0.25 * shape_.bounds.sizes().maxCoeff();
  }

  /// What speaks for this end of the axis.
  double OfEnds(const SignedAxis& front, std::string& reason) const {
    if (known_.thing == nullptr && TooThinForSeat(front.axis)) return 0;
    if (habit_ == FrontHabit::kSeat || known_.thing == nullptr) {
      const double behind = -front.sign * OffsetOfHighest(shape_, up_, front.axis);
      reason = "its highest quarter lies " + std::to_string(std::lround(100 * behind)) +
               " % of half the depth behind the rest";
      return 5 * std::clamp(behind, -0.8, 0.8);
    }
    const SideView here = LookFrom(mesh_, front, up_);
    const SideView behind = LookFrom(mesh_, {front.axis, -front.sign}, up_);
    char text[160];
    if (habit_ == FrontHabit::kScreen) {
      std::snprintf(text, sizeof(text), "%.0f %% of it is flat from there, %.0f %% from behind",
                    100 * here.flat_share, 100 * behind.flat_share);
      reason = text;
      return 5 * std::clamp(here.flat_share - behind.flat_share, -0.5, 0.5);
    }
    const auto lines = [](const SideView& view) { return view.shape_lines + view.color_lines; };
    std::snprintf(text, sizeof(text),
                  "it shows %.0f %% lines there (doors, drawers, handles), %.0f %% behind",
                  100 * lines(here), 100 * lines(behind));
    reason = text;
    return 1.5 *
           std::clamp(std::log((lines(here) + kFewLines) / (lines(behind) + kFewLines)), -1.5, 1.5);
  }

  const TriangleMesh& mesh_;
  const ShapeMeasures& shape_;
  const SignedAxis& up_;
  const KnownOfMesh& known_;
  FrontHabit habit_ = FrontHabit::kNone;
};

}  // namespace

namespace {

/// By agreement along the longer side.
Guess<SignedAxis> NoFront(const ShapeMeasures& shape, const SignedAxis& up) {
  const int u = (up.axis + 1) % 3, v = (up.axis + 2) % 3;
  const int longer = shape.bounds.sizes()[u] >= shape.bounds.sizes()[v] ? u : v;
  Guess<SignedAxis> guess{{longer, 1}, 0.25, "along its longer side; nothing tells a front", {}};
  for (const int axis : {longer, 3 - up.axis - longer}) {
    for (const int sign : {1, -1}) guess.shares.emplace_back(SignedAxis{axis, sign}, 0.25);
  }
  return guess;
}

bool HasNoFront(const ShapeMeasures& shape, const SignedAxis& up, const Thing* thing) {
  if (thing != nullptr) return thing->front == FrontHabit::kNone;
  const auto asymmetry = [&](int axis) { return shape.asymmetry[static_cast<std::size_t>(axis)]; };
  return std::max(asymmetry((up.axis + 1) % 3), asymmetry((up.axis + 2) % 3)) < kAlike;
}

}  // namespace

Result<Guess<SignedAxis>> GuessFront(const TriangleMesh& mesh, const SignedAxis& up,
                                     const KnownOfMesh& known) {
  const Result<ShapeMeasures> shape = MeasureShape(mesh);
  if (!shape.ok()) return shape.error();
  if (HasNoFront(*shape, up, known.thing)) return NoFront(*shape, up);
  const Facing facing(mesh, *shape, up, known);
  Guess<SignedAxis> guess;
  double highest = -1e9, sum = 0;
  for (const int axis : {(up.axis + 1) % 3, (up.axis + 2) % 3}) {
    for (const int sign : {1, -1}) {
      std::string reason;
      const double weight = facing.Weigh({axis, sign}, reason);
      guess.shares.emplace_back(SignedAxis{axis, sign}, std::exp(weight));
      sum += guess.shares.back().second;
      if (weight <= highest) continue;
      highest = weight;
      guess.reason = reason;
    }
  }
  for (auto& [front, share] : guess.shares) share = (1 - kOddFronts) * share / sum + kOddFronts / 4;
  std::stable_sort(guess.shares.begin(), guess.shares.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  guess.value = guess.shares[0].first;
  guess.confidence = guess.shares[0].second;
  return guess;
}

}  // namespace plumbline
