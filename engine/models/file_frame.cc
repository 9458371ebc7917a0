// SPDX-License-Identifier: Apache-2.0
#include "engine/models/file_frame.h"

#include <array>

namespace plumbline {

std::string SignedAxis::text() const { return std::string(sign > 0 ? "+" : "-") + "xyz"[axis]; }

std::optional<SignedAxis> ParseSignedAxis(std::string_view text) {
  SignedAxis axis;
  if (!text.empty() && (text[0] == '+' || text[0] == '-')) {
    axis.sign = text[0] == '+' ? 1 : -1;
    text.remove_prefix(1);
  }
  if (text.size() != 1 || text[0] < 'x' || text[0] > 'z') return std::nullopt;
  axis.axis = text[0] - 'x';
  return axis;
}

double MetresPer(LengthUnit unit) {
  static constexpr std::array<double, 3> kMetres = {1.0, 0.01, 0.001};
  return kMetres[static_cast<std::size_t>(unit)];
}

const char* NameOf(LengthUnit unit) {
  static constexpr std::array<const char*, 3> kNames = {"m", "cm", "mm"};
  return kNames[static_cast<std::size_t>(unit)];
}

std::optional<LengthUnit> ParseLengthUnit(std::string_view text) {
  for (const LengthUnit unit :
       {LengthUnit::kMetre, LengthUnit::kCentimetre, LengthUnit::kMillimetre}) {
    if (text == NameOf(unit)) return unit;
  }
  return std::nullopt;
}

}  // namespace plumbline
