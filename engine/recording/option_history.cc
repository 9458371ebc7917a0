// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/option_history.h"

#include <limits>

#include "engine/base/log.h"
#include "engine/mapping/option_changes.h"

namespace plumbline {

OptionHistory::OptionHistory(const RunHeader& header)
    : forked_after_(header.forked_after.value_or(std::numeric_limits<int>::min())),
      changes_{{std::numeric_limits<int>::min(), header.recipe.options}} {}

Result<OptionHistory> OptionHistory::Read(RunReader& reader) {
  OptionHistory history(reader.header());
  const auto events = reader.Events();
  if (!events.ok()) return events.error();
  for (const RunEvent& event : *events) history.Add(event.frame, event.event);
  return history;
}

void OptionHistory::Add(int frame, const LifeEvent& event) {
  if (event.kind != EventKind::kOptionsChanged || frame <= forked_after_) return;
  MapperOptions options = newest();
  if (const Status status = ApplyOptionChanges(event.option_changes, options); !status.ok())
    log::warn("frame {} of the run: {}", frame, status.error().message);
  changes_.emplace_back(frame, options);
}

const MapperOptions& OptionHistory::At(int frame) const {
  auto found = changes_.end() - 1;
  while (found->first > frame) --found;
  return found->second;
}

}  // namespace plumbline
