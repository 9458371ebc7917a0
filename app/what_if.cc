// SPDX-License-Identifier: Apache-2.0
#include "app/what_if.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include "engine/process/run_difference.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

constexpr auto kBlinkPeriod = std::chrono::milliseconds(700);

bool IsRun(const std::string& path) { return std::filesystem::path(path).extension() == ".plb"; }

/// RUN-fork-1.plb beside the run, or the next number that is free.
std::string FreeName(const std::filesystem::path& run) {
  std::error_code ignored;
  for (int i = 1;; ++i) {
    const std::filesystem::path name =
        run.parent_path() / (run.stem().string() + "-fork-" + std::to_string(i) + ".plb");
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

void WhatIf::Opened(const std::string& path, FrameContext& context) {
  Compare("", context);
  fork_.reset();
  context.fork = nullptr;
  OfferFork(path, context);
}

void WhatIf::OfferFork(const std::string& path, FrameContext& context) {
  auto offer = std::make_shared<ForkOffer>();
  context.fork_offer = offer;
  if (!IsRun(path)) {
    offer->why_not =
        "A run is forked once it is recorded: keep it with --out RUN.plb, and open that file.";
    return;
  }
  auto reader = RunReader::Open(path);
  if (!reader.ok()) {
    offer->why_not = reader.error().message;
    return;
  }
  offer->options = OptionsOf((*reader)->header());
  offer->seed = (*reader)->header().seed;
  offer->out = FreeName(path);
}

void WhatIf::Compare(const std::string& run, FrameContext& context) {
  other_.reset();
  last_ = nullptr;
  sought_ = -1;
  settings_.clear();
  context.other = nullptr;
  context.run_shown = RunShown::kFirst;
  context.shows_other = false;
  if (run.empty()) return;
  if (IsRun(run) && IsRun(context.source)) {
    const auto a = RunReader::Open(context.source), b = RunReader::Open(run);
    if (a.ok() && b.ok()) settings_ = DifferentSettings((*a)->header(), (*b)->header());
  }
  other_ = std::make_unique<MappingProcess>(opener_(run), context.playback->frame, on_publish_);
  auto other = std::make_shared<OtherRun>();
  other->source = run;
  other->playback = other_->Playback();
  other->settings = settings_;
  context.other = other;
  context.run_shown = RunShown::kBeside;
}

bool WhatIf::Handle(const WindowCommand& command, FrameContext& context) {
  if (const auto* fork = std::get_if<ForkCommand>(&command)) {
    ForkChoice choice{inputs_, fork->frame, fork->options, fork->seed, fork->out, program_version_};
    choice.run.run = context.source;
    fork_ = std::make_unique<ForkProcess>(std::move(choice), on_publish_);
    context.fork = fork_->View();
    return true;
  }
  if (std::holds_alternative<CancelForkCommand>(command)) {
    if (fork_ != nullptr) fork_->Cancel();
    return true;
  }
  if (const auto* compare = std::get_if<CompareRunCommand>(&command)) {
    Compare(compare->run, context);
    return true;
  }
  if (const auto* show = std::get_if<ShowRunCommand>(&command)) {
    if (context.other != nullptr) context.run_shown = show->shown;
    return true;
  }
  return false;
}

void WhatIf::ReadSlots(FrameContext& context, std::shared_ptr<const MapSnapshot>& shown) {
  if (fork_ != nullptr) {
    const bool ran = context.fork != nullptr && context.fork->state == ForkState::kRunning;
    context.fork = fork_->View();
    if (ran && context.fork->state == ForkState::kDone) {
      Compare(context.fork->out, context);
      OfferFork(context.source, context);  // the name is taken now
    }
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
  auto other = std::make_shared<OtherRun>();
  other->source = context.other->source;
  other->sequence = other_->Sequence();
  other->snapshot = snapshot;
  other->playback = other_->Playback();
  other->version = version_;
  other->settings = settings_;
  context.other = other;
  blink_phase_ = Phase();
  const bool wanted = context.run_shown == RunShown::kOther ||
                      (context.run_shown == RunShown::kBlink && blink_phase_);
  if (!wanted || snapshot == nullptr) return;
  context.shows_other = true;
  context.probe = other_->Probe();
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
  state["fork_message"] = context.fork != nullptr ? context.fork->message : "";
  state["run_shown"] = kShown[static_cast<std::size_t>(context.run_shown)];
  state["shows_other"] = context.shows_other;
  const OtherRun* other = context.other.get();
  state["other_run"] = other != nullptr ? other->source : "";
  state["other_frame"] =
      other != nullptr && other->snapshot != nullptr ? other->snapshot->report.frame : -1;
  state["other_settings"] = other != nullptr ? other->settings : std::vector<std::string>();
}

}  // namespace plumbline
