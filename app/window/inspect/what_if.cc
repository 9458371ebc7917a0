// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/what_if.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <utility>

#include "engine/analysis/run_difference.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/mapping_source.h"

namespace plumbline {
namespace {

constexpr auto kBlinkPeriod = std::chrono::milliseconds(700);

bool IsRun(const std::string& path) { return std::filesystem::path(path).extension() == ".plb"; }

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
  auto reader = RunReader::Open(run);
  auto options =
      reader.ok() ? OptionHistory::Read(**reader) : Result<OptionHistory>(reader.error());
  if (!options.ok()) {
    offer->why_not = options.error().message;
    return;
  }
  offer->options = options->At(context.playback->frame);
  offer->seed = (*reader)->header().seed;
  offer->out = FreeName(context);
}

void WhatIf::Compare(const std::string& run, FrameContext& context) {
  other_.reset();
  last_ = nullptr;
  sought_ = -1;
  settings_.clear();
  settings_of_ = 0;
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
  ReadSettings(context);
}

void WhatIf::ReadSettings(const FrameContext& context) {
  const std::string &first = context.playback->recording, &second = context.other->source;
  if (!IsRun(first) || !IsRun(second)) return;
  const auto a = RunReader::Open(first), b = RunReader::Open(second);
  if (!a.ok() || !b.ok()) return;
  settings_ = DifferentSettings((*a)->header(), (*b)->header());
  const auto add_changes = [&](const char* which, const RunHeader& header,
                               const std::vector<FrameEvent>& events) {
    std::vector<RunEvent> of_run;
    for (const FrameEvent& event : events) of_run.push_back({0, event.frame, event.event});
    for (std::string& change : ChangesOnTheWay(which, header, of_run))
      settings_.push_back(std::move(change));
  };
  add_changes("first", (*a)->header(), *context.playback->events);
  add_changes("other", (*b)->header(), *context.other->playback->events);
}

bool WhatIf::Handle(const WindowCommand& command, FrameContext& context) {
  if (const auto* fork = std::get_if<ForkCommand>(&command)) {
    ForkChoice choice{inputs_, fork->frame, fork->options, fork->seed, fork->out, program_version_};
    choice.run.run = context.playback->recording;
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
  const std::size_t events =
      context.playback->events->size() + context.other->playback->events->size();
  if (events != std::exchange(settings_of_, events)) ReadSettings(context);
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
  state["other_settings"] = other != nullptr ? other->settings : std::vector<std::string>();
}

}  // namespace plumbline
