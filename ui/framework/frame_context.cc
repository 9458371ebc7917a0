// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/frame_context.h"

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

const ObjectReport* FrameContext::SelectedObject() const {
  if (snapshot == nullptr) return nullptr;
  for (const ObjectReport& object : snapshot->report.objects) {
    if (object.id == selection.object) return &object;
  }
  return nullptr;
}

const std::vector<int>* FrameContext::ParticlesByRank() const {
  return analysis != nullptr && analysis->object == selection.object ? &analysis->by_rank : nullptr;
}

}  // namespace plumbline
