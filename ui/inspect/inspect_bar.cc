// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/inspect_bar.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/framework/widgets.h"
#include "ui/inspect/networks_sheet.h"

namespace plumbline {
namespace {

/// Of a recording that is played by the clock.
std::string LiveText(const PlaybackView& playback, const std::string& rate) {
  const LiveReport& live = *playback.live;
  const std::string fares = fmt::format("{} of {} frames mapped as they came, {} passed over",
                                        live.done, live.came(), live.passed_over);
  if (playback.state == PlaybackState::kFinished) return "At the end: " + fares + ".";
  if (playback.state == PlaybackState::kPlaying || playback.mapping)
    return fmt::format("Live, frame {}: {}; {:.0f} ms old when mapped{}", playback.frame, fares,
                       live.done_age_ms, rate);
  return fmt::format("Paused; what comes now is passed over. Space goes on. So far {}.", fares);
}

std::string StatusText(const FrameContext& context) {
  const PlaybackView& playback = *context.playback;
  const std::string rate = playback.frames_per_second > 0 ? fmt::format("  \u00b7  {:.1f} frames/s",
                                                                        playback.frames_per_second)
                                                          : "";
  if (context.sequence == nullptr && context.source.empty()) return "Nothing is open.";
  if (context.sequence == nullptr) return playback.message.empty() ? "Opening" : playback.message;
  const int last = std::max(0, context.sequence->num_frames - 1);
  const bool at_newest = playback.frame >= playback.newest_mapped_frame;
  const char* doing = playback.recorded || !at_newest ? "Playing the recording" : "Mapping";
  if (playback.live && playback.state != PlaybackState::kFailed) return LiveText(playback, rate);
  switch (playback.state) {
    case PlaybackState::kFailed:
      return playback.message;
    case PlaybackState::kFinished:
      return fmt::format("At the end: all {} frames are {}.", last + 1,
                         playback.recorded ? "recorded" : "mapped");
    case PlaybackState::kPlaying:
      if (playback.mapping && !playback.follow)
        return fmt::format("Playing frame {}; the mapper is at {} of {}{}", playback.frame,
                           playback.newest_mapped_frame, last, rate);
      return fmt::format("{} frame {} of {}{}", doing, playback.frame, last, rate);
    case PlaybackState::kPaused:
      break;
  }
  if (playback.seek_target) {
    const int missing = *playback.seek_target - playback.newest_mapped_frame;
    const std::string eta =
        playback.frames_per_second > 0
            ? fmt::format(", about {:.0f} s", missing / playback.frames_per_second)
            : "";
    return fmt::format("Mapping up to frame {}: {} to go{}{}", *playback.seek_target, missing, eta,
                       rate);
  }
  if (playback.mapping)
    return fmt::format("Mapping continues: frame {} of {}. N shows the newest.",
                       playback.newest_mapped_frame, last);
  if (playback.recorded) return "Paused. Space plays the recording.";
  return fmt::format("Paused. Mapped up to frame {}; Space goes on.", playback.newest_mapped_frame);
}

}  // namespace

void DrawSequenceName(const FrameContext& context) {
  const std::string what = context.sequence != nullptr ? context.sequence->name : context.source;
  ImGui::TextUnformatted(what.c_str());
  if (context.sequence == nullptr) return;
  Tooltip(context, context.sequence->path);
  ImGui::SameLine(0, context.Scaled(12));
  DimText("%d frames, %d \u00d7 %d px, %g Hz%s", context.sequence->num_frames,
          context.sequence->image_width, context.sequence->image_height, context.sequence->rate_hz,
          context.playback->recorded ? ", recorded run" : "");
}

void DrawNetworksButton(const FrameContext& context, const LayoutRect& bar, CommandSink& sink) {
  if (context.sequence == nullptr) return;
  const PlaybackView& playback = context.shown_playback();
  const std::string label = fmt::format("edges: {}  \u00b7  boxes: {}", NetworkName(playback.edges),
                                        NetworkName(playback.detector));
  ImGui::SameLine(0, context.Scaled(12));
  if (ImGui::GetCursorScreenPos().x + ToggleWidth(context, label.c_str()) > bar.high.x) return;
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(2));
  bool on = false;
  if (Toggle(context, "top.networks", label.c_str(), on,
             "Which networks find edges and boxes; choose others."))
    sink.Post(AskNetworksCommand{});
}

StatusLine InspectStatus(const FrameContext& context) {
  StatusLine line{StatusText(context), context.playback->state == PlaybackState::kFailed};
  if (const ForkView* fork = context.fork.get();
      fork != nullptr && fork->state == ForkState::kRunning)
    line.text += fmt::format("  \u00b7  Fork: {} of {}", fork->done, fork->total);
  if (const PlaybackView* next = context.reopening.get();
      next != nullptr && next->state != PlaybackState::kFailed)
    line.text += "  \u00b7  With other networks: " + next->message;
  return line;
}

}  // namespace plumbline
