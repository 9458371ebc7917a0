// SPDX-License-Identifier: Apache-2.0
#include "engine/base/options.h"

#include <numeric>
#include <sstream>

namespace plumbline {

std::string NearestName(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i - 1] == candidate[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

namespace internal {
std::string OutOfRange(const FieldInfo& info, double value) {
  std::ostringstream text;
  text << "option '" << info.name << "' is " << value << " but must lie between " << info.min
       << " and " << info.max;
  if (!info.unit.empty()) text << " " << info.unit;
  return text.str();
}
}  // namespace internal

}  // namespace plumbline
