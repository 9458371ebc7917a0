// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

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

/// What a mesh file, or the definition of its format, states about the numbers in it.
struct FileFrame {
  std::optional<double> metres;  ///< One unit of the file [m].
  std::optional<SignedAxis> up;
  std::string by;  ///< Who says so, as the subject of a sentence: "the COLLADA file".
};

}  // namespace plumbline
