// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "engine/mapping/bytes.h"

namespace plumbline {

/// The edge surplus (EdgeSurplus) that right objects have in a sequence: running means over those
/// that are settled, of all and of each category. Strong edges give more to right and wrong objects
/// alike, and the outline of a cabinet gives more than the slats of a chair.
class EdgeLevel {
 public:
  /// Of right objects in the sequences that the constants of existence were fitted on; the least
  /// that is taken.
  static constexpr double kUsual = 0.25;

  /// @param looks  How independent of those before it this sight of a settled object is, in [0, 1].
  void Add(const std::string& category, double surplus, double looks);
  /// The least of what all have and what settled objects of its category have.
  double Of(const std::string& category) const;

  void Save(ByteWriter& out) const;
  void Restore(ByteReader& in);

 private:
  double all_ = kUsual;
  std::map<std::string, double> of_category_;
};

}  // namespace plumbline
