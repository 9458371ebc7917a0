// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/comparison_process.h"

#include <utility>

#include "engine/analysis/frame_difference.h"
#include "engine/analysis/run_difference.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

void AddChanges(const char* which, const ComparedRun& run, std::vector<std::string>& settings) {
  std::vector<RunEvent> events;
  for (const FrameEvent& event : *run.playback->events)
    events.push_back({0, event.frame, event.event});
  for (std::string& change : ChangesOnTheWay(which, *run.header, events))
    settings.push_back(std::move(change));
}

}  // namespace

ComparisonProcess::ComparisonProcess(std::function<void()> on_publish)
    : on_publish_(std::move(on_publish)), thread_([this] { Run(); }) {}

ComparisonProcess::~ComparisonProcess() {
  posted_.Close();
  if (thread_.joinable()) thread_.join();
}

void ComparisonProcess::Post(ComparisonInput input) {
  input_.Publish(std::make_shared<const ComparisonInput>(std::move(input)));
  posted_.TryPush(true);  // a full queue: it will look anyway
}

void ComparisonProcess::Run() {
  std::shared_ptr<const ComparisonInput> before;
  ComparisonView view;
  while (posted_.Pop()) {
    const auto now = input_.Latest();
    Compare(*now, before.get(), view);
    before = now;
    view_.Publish(std::make_shared<const ComparisonView>(view));
    if (on_publish_) on_publish_();
  }
}

/// Only what has changed since.
void ComparisonProcess::Compare(const ComparisonInput& now, const ComparisonInput* before,
                                ComparisonView& view) {
  const ComparedRun &a = now.first, &b = now.other;
  const bool first = before == nullptr;
  if (first || before->first.snapshot != a.snapshot || before->other.snapshot != b.snapshot) {
    view.a = a.snapshot;
    view.b = b.snapshot;
    view.pairs = PairObjects(a.snapshot->report, b.snapshot->report, now.up_in_world);
  }
  if (first || before->first.playback->history != a.playback->history ||
      before->other.playback->history != b.playback->history) {
    view.first_difference = FirstDifference(*a.playback->history, *b.playback->history);
    view.stages = CompareStages(*a.playback->history, *b.playback->history);
  }
  if (a.header == nullptr || b.header == nullptr) return;
  if (first || before->first.header != a.header || before->other.header != b.header ||
      before->first.playback->events != a.playback->events ||
      before->other.playback->events != b.playback->events) {
    view.settings = DifferentSettings(*a.header, *b.header);
    AddChanges("first", a, view.settings);
    AddChanges("other", b, view.settings);
  }
}

}  // namespace plumbline
