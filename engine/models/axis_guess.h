// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// A coordinate axis of a mesh file with its sign, such as -y.
struct SignedAxis {
  int axis = 0;  ///< 0 x, 1 y, 2 z
  int sign = 1;

  Eigen::Vector3d vector() const { return sign * Eigen::Vector3d::Unit(axis); }
  /// "+x" ... "-z"
  std::string text() const;
  bool operator==(const SignedAxis&) const = default;
};

/// "x", "+x", "-x" and so on; nothing for other text.
std::optional<SignedAxis> ParseSignedAxis(std::string_view text);

enum class LengthUnit { kMetre, kCentimetre, kMillimetre };
double MetresPer(LengthUnit unit);
const char* NameOf(LengthUnit unit);  ///< m, cm, mm
std::optional<LengthUnit> ParseLengthUnit(std::string_view text);

/// A guess with the reason in words and how sure it is: 1 certain, 0.5 a coin.
template <typename T>
struct Guess {
  T value{};
  double confidence = 0;
  std::string reason;
};

/// The unit in which `size` (of the bounding box) fits the category best; `extension` (".stl")
/// because formats have habits, and glTF a rule.
Guess<LengthUnit> GuessUnit(const Eigen::Vector3f& size, std::string_view category,
                            std::string_view extension);

/// The axis that points up: on its supporting plane the object stands stably, well balanced and
/// perhaps on feet, what is above differs from what is below while left and right are alike, seats
/// and tops are level, and it is as tall or flat as usual for the category; positive axes and those
/// usual for the format come first. With `only_axis` just its sign is in question. Errors:
/// kDegenerate for a mesh without area.
Result<Guess<SignedAxis>> GuessUp(const TriangleMesh& mesh, std::string_view extension,
                                  std::string_view category,
                                  std::optional<int> only_axis = std::nullopt);

/// The horizontal axis that the object faces, given the one that points up: within the plane of its
/// lateral symmetry, away from its tallest part (a back rest, a head board). Without a tallest
/// part, along the longer side. Errors: kDegenerate.
Result<Guess<SignedAxis>> GuessFront(const TriangleMesh& mesh, const SignedAxis& up);

}  // namespace plumbline
