// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/object_looks.h"

#include <array>
#include <map>
#include <tuple>

#include "engine/analysis/run_review.h"

namespace plumbline {
namespace {

/// Who wears a look.
struct LookUse {
  int times = 0, now = 0;
  int until = -1;  ///< The last frame of the last one who no longer does.
};
using LookUses = std::array<LookUse, 2 * kLookColors.size()>;

/// One that nobody has worn since `first_frame`, where there is one: solid before dashed, then the
/// least used.
std::size_t LookFor(const LookUses& uses, int first_frame) {
  const auto rank = [&](std::size_t i) {
    const bool worn = uses[i].now > 0 || uses[i].until >= first_frame;
    return std::tuple(worn, i >= kLookColors.size(), uses[i].times, i);
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < uses.size(); ++i) {
    if (rank(i) < rank(best)) best = i;
  }
  return best;
}

std::size_t IndexOf(const ObjectLook& look) {
  return static_cast<std::size_t>(look.color) + (look.dashed ? kLookColors.size() : 0);
}

}  // namespace

ObjectLooks LooksOf(const std::vector<FrameEvent>& events) {
  LookUses uses;
  std::map<ObjectId, int> spawned;
  ObjectLooks looks;
  for (const FrameEvent& event : events) {
    const ObjectId id = event.event.object;
    switch (event.event.kind) {
      case EventKind::kSpawned:
        spawned.emplace(id, event.frame);
        break;
      case EventKind::kConfirmed: {
        if (looks.contains(id)) break;
        const auto born = spawned.find(id);
        const std::size_t look = LookFor(uses, born != spawned.end() ? born->second : event.frame);
        ++uses[look].times;
        ++uses[look].now;
        looks[id] = {static_cast<int>(look % kLookColors.size()), look >= kLookColors.size()};
        break;
      }
      case EventKind::kMerged:
      case EventKind::kRetired:
        if (const auto found = looks.find(id); found != looks.end()) {
          LookUse& use = uses[IndexOf(found->second)];
          --use.now;
          use.until = event.frame;
        }
        break;
      default:
        break;
    }
  }
  return looks;
}

ObjectLooks LooksOf(const RunReview& review) {
  std::vector<FrameEvent> events;
  for (const RunEvent& event : review.events) events.push_back({event.frame, event.event});
  return LooksOf(events);
}

}  // namespace plumbline
