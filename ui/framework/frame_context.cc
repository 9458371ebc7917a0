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

bool FrameContext::Shows(const ObjectReport& object) const {
  return !confirmed_only || object.state == ObjectState::kConfirmed ||
         object.id == selection.object;
}

ObjectLook FrameContext::LookOf(const ObjectLooks* run, ObjectId id) {
  if (run == nullptr) return {};
  const auto found = run->find(id);
  return found != run->end() ? found->second : ObjectLook{};
}

const ObjectSpread* FrameContext::SpreadOf(ObjectId object) const {
  if (analysis == nullptr || analysis->frame != snapshot) return nullptr;
  for (const ObjectSpread& spread : analysis->spreads) {
    if (spread.object == object) return &spread;
  }
  return nullptr;
}

}  // namespace plumbline
