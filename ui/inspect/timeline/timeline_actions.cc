// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_actions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace plumbline {
namespace {

constexpr std::array kSpeeds = {0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 0.0};

double NextSpeed(double speed, int direction) {
  const auto found = std::find(kSpeeds.begin(), kSpeeds.end(), speed);
  const auto index = found == kSpeeds.end() ? 3 : std::distance(kSpeeds.begin(), found);
  return kSpeeds[static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(index + direction, 0, std::ssize(kSpeeds) - 1))];
}

void AddSteps(std::vector<Action>& actions) {
  actions.push_back({.text = "Play or pause",
                     .keys = {{keys::kSpace}},
                     .run = Posts(TogglePlayCommand{}),
                     .help_keys = "Space",
                     .help = "Play or pause"});
  actions.push_back({.text = "One frame on",
                     .keys = {{keys::kRight}, {keys::kPeriod}},
                     .run = Posts(StepCommand{1}),
                     .help_keys = "\u2190  \u2192",
                     .help = "One frame back, on",
                     .repeats = true});
  actions.push_back({.text = "One frame back",
                     .keys = {{keys::kLeft}, {keys::kComma}},
                     .run = Posts(StepCommand{-1}),
                     .repeats = true});
  actions.push_back({.text = "Ten frames on",
                     .keys = {{keys::kRight, true}},
                     .run = Posts(StepCommand{10}),
                     .help_keys = "Shift + \u2190  \u2192",
                     .help = "Ten frames back or forward",
                     .repeats = true});
  actions.push_back({.text = "Ten frames back",
                     .keys = {{keys::kLeft, true}},
                     .run = Posts(StepCommand{-10}),
                     .repeats = true});
  actions.push_back({.text = "First frame",
                     .keys = {{keys::kHome}},
                     .run = Posts(SeekCommand{0}),
                     .help_keys = "Home  End",
                     .help = "First frame, newest mapped frame"});
  actions.push_back({.text = "Newest mapped frame",
                     .keys = {{keys::kEnd}},
                     .run = [](const FrameContext& context, CommandSink& sink) {
                       sink.Post(SeekCommand{context.playback->newest_mapped_frame});
                     }});
  actions.push_back({.text = "Go to frame",
                     .keys = {{keys::kG}},
                     .run = Posts(AskFrameCommand{}),
                     .help_keys = "G",
                     .help = "Go to frame"});
}

void AddSpeeds(std::vector<Action>& actions) {
  const auto next = [](int direction) {
    return [direction](const FrameContext& context, CommandSink& sink) {
      sink.Post(SetSpeedCommand{NextSpeed(context.playback->speed, direction)});
    };
  };
  actions.push_back({.text = "Speed: slower",
                     .keys = {{keys::kLeftBracket}},
                     .run = next(-1),
                     .help_keys = "[  ]",
                     .help = "Slower, faster"});
  actions.push_back({.text = "Speed: faster", .keys = {{keys::kRightBracket}}, .run = next(1)});
  for (const double speed : kSpeeds)
    actions.push_back({.text = speed > 0 ? fmt::format("Speed: {:g} times", speed)
                                         : std::string("Speed: as fast as it goes"),
                       .run = Posts(SetSpeedCommand{speed})});
}

void AddMapping(std::vector<Action>& actions) {
  const auto maps = [](const FrameContext& context) {
    return !context.playback->recorded || context.playback->growing;
  };
  actions.push_back(
      {.text = "Resume mapping and follow the newest frame",
       .keys = {{keys::kN}},
       .run = [](const FrameContext& context,
                 CommandSink& sink) { sink.Post(FollowNewestCommand{!context.playback->follow}); },
       .help_keys = "N",
       .help = "Resume mapping and follow the newest frame, or stop",
       .text_when_on = "Stop mapping",
       .is_on = [](const FrameContext& context) { return context.playback->follow; },
       .is_offered = maps});
  actions.push_back({.text = "Pause the mapper",
                     .run = Posts(PauseCommand{}),
                     .is_offered = [](const FrameContext& context) {
                       return !context.playback->recorded && context.playback->mapping;
                     }});
}

void AddRange(std::vector<Action>& actions) {
  actions.push_back(
      {.text = "Loop",
       .keys = {{keys::kL}},
       .run = [](const FrameContext& context,
                 CommandSink& sink) { sink.Post(SetLoopCommand{!context.playback->loop}); },
       .help_keys = "L",
       .help = "Loop",
       .text_when_on = "Do not loop",
       .is_on = [](const FrameContext& context) { return context.playback->loop; }});
  actions.push_back({.text = "Play only after this frame",
                     .keys = {{keys::kI}},
                     .run =
                         [](const FrameContext& context, CommandSink& sink) {
                           const PlaybackView& playback = *context.playback;
                           sink.Post(SetRangeCommand{playback.frame, playback.range_end});
                         },
                     .help_keys = "I  O",
                     .help = "Play only after, before this frame"});
  actions.push_back({.text = "Play only before this frame",
                     .keys = {{keys::kO}},
                     .run = [](const FrameContext& context, CommandSink& sink) {
                       const PlaybackView& playback = *context.playback;
                       sink.Post(SetRangeCommand{playback.range_begin, playback.frame});
                     }});
  actions.push_back({.text = "Play everything: no sub-range", .run = Posts(SetRangeCommand{})});
}

}  // namespace

ActionGroup PlaybackActions() {
  ActionGroup group{"Playback", {}};
  AddSteps(group.actions);
  AddSpeeds(group.actions);
  AddRange(group.actions);
  AddMapping(group.actions);
  group.actions.push_back({.text = "Bookmark this frame",
                           .keys = {{keys::kB}},
                           .run =
                               [](const FrameContext& context, CommandSink& sink) {
                                 sink.Post(BookmarkCommand{context.playback->frame, ""});
                               },
                           .help_keys = "B",
                           .help = "Bookmark this frame"});
  group.actions.push_back({.text = "Demo mode: full screen with captions, until any key",
                           .keys = {{keys::kF5}},
                           .run = Posts(PresentCommand{}),
                           .help_keys = "F5",
                           .help = "Demo mode: full screen with captions, until any key"});
  return group;
}

std::span<const double> PlaybackSpeeds() { return kSpeeds; }

}  // namespace plumbline
