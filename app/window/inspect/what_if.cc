// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/what_if.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <utility>

#include "engine/analysis/true_instances.h"
#include "engine/runtime/run_file_place.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr auto kBlinkPeriod = std::chrono::milliseconds(700);

/// RUN-fork-1.plb beside the run, or the next number that is free. Of a run that is kept only for
/// the time being: in the working folder, named after the sequence.
std::string FreeName(const FrameContext& context) {
  std::error_code ignored;
  const std::filesystem::path run = context.playback->recording;
  const bool kept = !IsTemporaryRun(run);
  const std::filesystem::path folder =
      kept ? run.parent_path() : std::filesystem::current_path(ignored);
  std::string stem = run.stem().string();
  if (!kept) {
    const auto source = std::filesystem::path(context.source).lexically_normal();
    stem = context.source == kDemoPath
               ? "demo"
               : (source.has_filename() ? source : source.parent_path()).filename().string();
  }
  for (int i = 1;; ++i) {
    const auto name = folder / (stem + "-fork-" + std::to_string(i) + ".plb");
    if (!std::filesystem::exists(name, ignored)) return name.string();
  }
}

bool Phase() {
  return (std::chrono::steady_clock::now().time_since_epoch() / kBlinkPeriod) % 2 != 0;
}

}  // namespace

WhatIf::WhatIf(Opener opener, RunChoice inputs, std::string program_version,
               std::function<void()> on_publish)
    : opener_(std::move(opener)),
      inputs_(std::move(inputs)),
      program_version_(std::move(program_version)),
      on_publish_(std::move(on_publish)) {}

void WhatIf::Opened(FrameContext& context) {
  Compare("", context);
  fork_.reset();
  context.fork = nullptr;
  context.fork_offer = nullptr;
}

void WhatIf::OfferFork(FrameContext& context) const {
  auto offer = std::make_shared<ForkOffer>();
  context.fork_offer = offer;
  const std::string& run = context.playback->recording;
  if (run.empty() || context.playback->newest_mapped_frame < 0) {
    offer->why_not = context.sequence == nullptr
                         ? "Nothing is open: open a sequence or a run first."
                         : "Nothing is mapped yet: a run is forked at a frame that it has mapped.";
    return;
  }
  const PlaybackView& playback = *context.playback;
  if (playback.shown_options == nullptr) {
    offer->why_not = "The frame has not been shown yet.";
    return;
  }
  offer->options = *playback.shown_options;
  offer->seed = playback.seed;
  offer->out = FreeName(context);
}

void WhatIf::Compare(const std::string& run, FrameContext& context) {
  other_.reset();
  last_ = nullptr;
  sought_ = -1;
  compared_first_ = compared_other_ = {};
  comparison_.reset();
  context.other = nullptr;
  context.run_shown = RunShown::kFirst;
  context.shows_other = false;
  if (run.empty()) return;
  other_ = std::make_unique<MappingProcess>(opener_(run), context.playback->frame, on_publish_);
  auto other = std::make_shared<OtherRun>();
  other->source = run;
  other->playback = other_->Playback();
  context.other = other;
  context.run_shown = RunShown::kBeside;
  comparison_ = std::make_unique<ComparisonProcess>(on_publish_);
}

void WhatIf::Fork(const ForkCommand& fork, FrameContext& context) {
  ForkChoice choice{inputs_, fork.frame, fork.options, fork.seed, fork.out, program_version_};
  choice.run.run = context.playback->recording;
  if (!fork.plant.empty()) {
    // Nobody filled in a form: as the run is.
    OfferFork(context);
    if (!context.fork_offer->why_not.empty()) {
      context.fork = std::make_shared<const ForkView>(
          ForkView{ForkState::kFailed, "", context.fork_offer->why_not, 0, 0});
      return;
    }
    choice.options = context.fork_offer->options;
    choice.seed = context.fork_offer->seed;
    choice.out = context.fork_offer->out;
    choice.plant = PlantTruth(*context.sequence, fork.plant);
  }
  fork_ = std::make_unique<ForkProcess>(std::move(choice), on_publish_);
  context.fork = fork_->View();
}

void WhatIf::CancelFork() {
  if (fork_ != nullptr) fork_->Cancel();
}

void WhatIf::PostComparison(const FrameContext& context,
                            const std::shared_ptr<const RunHeader>& header) {
  const ComparedRun first{context.first_snapshot, context.playback, header};
  const ComparedRun other{other_->Snapshot(), other_->Playback(), other_->Header()};
  if (first.snapshot == nullptr || other.snapshot == nullptr || context.sequence == nullptr) return;
  // A new frame, more history, more events; not every step of the playback.
  const auto same = [](const ComparedRun& a, const ComparedRun& b) {
    return a.snapshot == b.snapshot && a.header == b.header && a.playback != nullptr &&
           a.playback->history == b.playback->history && a.playback->events == b.playback->events;
  };
  if (same(compared_first_, first) && same(compared_other_, other)) return;
  compared_first_ = first;
  compared_other_ = other;
  comparison_->Post({first, other, context.sequence->up_in_world});
}

void WhatIf::ReadSlots(FrameContext& context, std::shared_ptr<const RunHeader> header,
                       std::shared_ptr<const MapSnapshot>& shown) {
  if (fork_ != nullptr) {
    const bool ran = context.fork != nullptr && context.fork->state == ForkState::kRunning;
    context.fork = fork_->View();
    // What a stopped fork has done is kept, and shown, too.
    const bool ended = context.fork->state == ForkState::kDone ||
                       (context.fork->state == ForkState::kCancelled && context.fork->done > 0);
    if (ran && ended) Compare(context.fork->out, context);
  }
  context.shows_other = false;
  if (other_ == nullptr) return;
  if (sought_ != context.playback->frame && context.first_snapshot != nullptr) {
    sought_ = context.playback->frame;
    other_->Post(SeekCommand{sought_});
  }
  auto snapshot = other_->Snapshot();
  if (snapshot != last_) ++version_;
  last_ = snapshot;
  PostComparison(context, header);
  auto other = std::make_shared<OtherRun>();
  other->source = context.other->source;
  other->sequence = other_->Sequence();
  other->snapshot = snapshot;
  other->playback = other_->Playback();
  other->looks = looks_.Of(*other->playback);
  other->version = version_;
  other->comparison = comparison_->View();
  context.other = other;
  blink_phase_ = Phase();
  const bool wanted = context.run_shown == RunShown::kOther ||
                      (context.run_shown == RunShown::kBlink && blink_phase_);
  if (!wanted || snapshot == nullptr) return;
  context.shows_other = true;
  context.probe = other_->Probe();
  context.history = other_->History();
  context.truths = other_->Truths();
  shown = snapshot;
}

bool WhatIf::TakeBlink(const FrameContext& context) {
  return context.run_shown == RunShown::kBlink && Phase() != blink_phase_;
}

void AddWhatIfState(const FrameContext& context, const ForkSheet& sheet, nlohmann::json& state) {
  static constexpr const char* kShown[] = {"first", "other", "blink", "beside"};
  static constexpr const char* kForks[] = {"idle", "running", "done", "cancelled", "failed"};
  state["fork_sheet"] = sheet.is_open();
  state["fork"] =
      kForks[context.fork != nullptr ? static_cast<std::size_t>(context.fork->state) : 0];
  state["fork_done"] = context.fork != nullptr ? context.fork->done : 0;
  state["fork_message"] = context.fork != nullptr ? context.fork->message : "";
  state["option_changes"] = nlohmann::json::array();
  for (const FrameEvent& event : *context.playback->events) {
    if (event.event.kind == EventKind::kOptionsChanged)
      state["option_changes"].push_back(fmt::format("{}: {}", event.frame, event.event.text));
  }
  state["run_shown"] = kShown[static_cast<std::size_t>(context.run_shown)];
  state["shows_other"] = context.shows_other;
  const OtherRun* other = context.other.get();
  state["other_run"] = other != nullptr ? other->source : "";
  state["other_frame"] =
      other != nullptr && other->snapshot != nullptr ? other->snapshot->report.frame : -1;
  const ComparisonView* comparison = other != nullptr ? other->comparison.get() : nullptr;
  state["compared_frame"] = comparison != nullptr ? comparison->b->report.frame : -1;
  state["other_settings"] =
      comparison != nullptr ? comparison->settings : std::vector<std::string>();
}

}  // namespace plumbline
