// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/base/random.h"
#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// Runs with two figures: "found" (about 80 %, more is better) and "translation" (about 2 cm, less
/// is better), which depend on sequence and seed by chance alone. Options have the values 1 and 2.
inline BatchTable TableOf(std::vector<std::string> sequences, std::vector<std::string> recipes,
                          int seeds, std::vector<std::string> options) {
  BatchTable table{"table", std::move(sequences), std::move(recipes), std::move(options), {}, {}};
  table.figures = {{"found", "%", "those that are there", 1},
                   {"translation", "cm", "how far they are off", -1}};
  const std::vector<std::vector<double>> points = table.options.empty()
                                                      ? std::vector<std::vector<double>>{{}}
                                                      : std::vector<std::vector<double>>{{1}, {2}};
  for (int seed = 0; seed < seeds; ++seed) {
    for (const auto& point : points) {
      for (const std::string& recipe : table.recipes) {
        for (const std::string& sequence : table.sequences) {
          BatchRun run;
          run.number = static_cast<int>(table.runs.size());
          run.sequence = sequence;
          run.recipe = recipe;
          run.point = point;
          run.seed = static_cast<std::uint64_t>(seed);
          run.status = "ok";
          run.folder = "jobs/" + std::to_string(run.number);
          Random random({.seed = 5, .frame = static_cast<std::uint32_t>(run.number)});
          run.figures = {80 + 3 * random.Gaussian(), 2 + 0.2 * random.Gaussian()};
          table.runs.push_back(std::move(run));
        }
      }
    }
  }
  return table;
}

}  // namespace plumbline
