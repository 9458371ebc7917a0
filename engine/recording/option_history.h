// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "engine/mapping/event_report.h"
#include "engine/mapping/mapper_options.h"
#include "engine/recording/run_file.h"

namespace plumbline {

/// The options that each frame of a run was mapped with: those that it began with, and the changes
/// that its life events tell of. Of what a fork has taken over it knows nothing: there, too, it
/// gives the options of the fork.
class OptionHistory {
 public:
  explicit OptionHistory(const RunHeader& header);
  /// All of a run file, as far as it is written. Errors: kCorrupt.
  static Result<OptionHistory> Read(RunReader& reader);

  /// Events come by rising frame; those of other kinds are passed over.
  void Add(int frame, const LifeEvent& event);
  const MapperOptions& At(int frame) const;
  const MapperOptions& newest() const { return changes_.back().second; }

 private:
  int forked_after_;
  std::vector<std::pair<int, MapperOptions>> changes_;  ///< From which frame on.
};

}  // namespace plumbline
