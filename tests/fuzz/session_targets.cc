// SPDX-License-Identifier: Apache-2.0
// The queue of scans, and the pairs that lay a sequence onto a scan.
#include <array>

#include "engine/base/check.h"
#include "engine/dataset/sequence.h"
#include "engine/session/annotation_queue.h"
#include "engine/session/registration_pairs.h"
#include "engine/session/sequence_registration.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

/// A folder of scans and projects, as `annotate queue` and the window list it. A project that
/// cannot be read is a row that says so.
Status Queue(std::string_view input) {
  const auto folder = FolderOf(input);
  (void)IsQueue(folder);
  const auto entries = ReadQueue(folder);
  if (!entries.ok()) return entries.error();
  const auto first = FirstToDo(*entries);
  PLB_CHECK(first.has_value() == !entries->empty());
  for (const QueueEntry& entry : *entries) {
    PLB_CHECK(!entry.name.empty());
    if (!entry.problem.empty()) return Error{ErrorCode::kCorrupt, entry.problem};
  }
  return {};
}

constexpr std::string_view kWalk = R"(==> camera.json <==
{"width": 64, "height": 48, "model": "pinhole", "fx": 60, "fy": 60, "cx": 31.5, "cy": 23.5,
 "distortion": [], "rate_hz": 10}
==> gravity.json <==
{"gravity": [0, 0, -9.81]}
==> trajectory.txt <==
0.0 0 0 1 0 0 0 1
0.1 1 0 1 0 0 0 1
0.2 2 0 1 0 0 0 1
==> color.csv <==
0.0,0.jpg
0.1,1.jpg
0.2,2.jpg
)";

/// `annotate register --pairs`, with a sequence of three frames.
Status Pairs(std::string_view input) {
  static const auto kSequence = OpenSequence(FolderOf(kWalk)).value();
  const auto pairs = ReadRegistrationPairs(FileOf("pairs.json", input));
  if (!pairs.ok()) return pairs.error();
  const auto found = RegisterByPicks({}, *kSequence, pairs->in_frames, pairs->in_world);
  if (!found.ok()) return found.error();
  PLB_CHECK(found->scan_from_world.matrix().allFinite() && found->position_std_m.allFinite());
  return {};
}

constexpr std::array kSessionTargets = {Target{"queue", Queue},
                                        Target{"registration_pairs", Pairs}};

}  // namespace

std::span<const Target> SessionTargets() { return kSessionTargets; }

}  // namespace plumbline::fuzz
