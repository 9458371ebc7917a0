// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/window/inspect/looks_keeper.h"
#include "engine/runtime/comparison_process.h"
#include "engine/runtime/fork_process.h"
#include "engine/runtime/mapping_process.h"
#include "ui/framework/frame_context.h"
#include "ui/inspect/compare/fork_sheet.h"

namespace plumbline {

/// Forks of the run that is open, and a second run beside it on the same clock. Main thread only.
class WhatIf {
 public:
  using Opener = std::function<MappingProcess::OpenSource(const std::string& path)>;

  WhatIf(Opener opener, RunChoice inputs, std::string program_version,
         std::function<void()> on_publish);

  /// Instead of the models that runs were made with.
  void UseModels(const std::string& folder) { inputs_.models = folder; }
  /// Something else was opened: forgets the second run and the fork of the last.
  void Opened(FrameContext& context);
  /// Brings `context.fork_offer` up to the frame that is shown.
  void OfferFork(FrameContext& context) const;
  /// Opens a second run; "" closes it.
  void Compare(const std::string& run, FrameContext& context);
  void Fork(const ForkCommand& fork, FrameContext& context);
  void CancelFork();
  /// Brings the second run to the frame of the first; puts its snapshot in the place of `shown`
  /// where it is to be seen.
  /// @param header  Of the first run; null: it is not open, or has none.
  void ReadSlots(FrameContext& context, std::shared_ptr<const RunHeader> header,
                 std::shared_ptr<const MapSnapshot>& shown);
  /// True when a blinking window has to be drawn again.
  bool TakeBlink(const FrameContext& context);
  /// Null unless the second run shows.
  MappingProcess* shown_process(const FrameContext& context) {
    return context.shows_other ? other_.get() : nullptr;
  }

 private:
  /// Has the two runs compared, where something has changed since.
  void PostComparison(const FrameContext& context, const std::shared_ptr<const RunHeader>& header);

  Opener opener_;
  RunChoice inputs_;
  std::string program_version_;
  std::function<void()> on_publish_;
  std::shared_ptr<const MapSnapshot> last_;
  LooksKeeper looks_;
  std::uint64_t version_ = 0;
  int sought_ = -1;  ///< The frame that the second run was sent to.
  bool blink_phase_ = false;
  ComparedRun compared_first_, compared_other_;  ///< What was posted last.
  std::unique_ptr<ForkProcess> fork_;
  std::unique_ptr<MappingProcess> other_;
  std::unique_ptr<ComparisonProcess> comparison_;
};

/// For scripts and tests.
void AddWhatIfState(const FrameContext& context, const ForkSheet& sheet, nlohmann::json& state);

}  // namespace plumbline
