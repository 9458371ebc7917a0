// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/landmark_history.h"

namespace plumbline {

void AddLandmarks(int frame, const LifeEvent& event, LandmarkHistory& history) {
  if (event.kind != EventKind::kPosesCorrected) return;
  auto edges = LandmarkEdgesFromText(event.landmarks);  // checked where it was read
  if (edges.ok()) history[frame] = std::move(edges).value();
}

Result<LandmarkHistory> ReadLandmarks(RunReader& reader) {
  const auto events = reader.Events();
  if (!events.ok()) return events.error();
  LandmarkHistory history;
  for (const RunEvent& event : *events) AddLandmarks(event.frame, event.event, history);
  return history;
}

}  // namespace plumbline
