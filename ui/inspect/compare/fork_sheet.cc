// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/fork_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "ui/framework/actions.h"
#include "ui/framework/options_form.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/compare/option_names.h"

namespace plumbline {
namespace {

constexpr double kWidth = 760, kHeight = 620, kLowHeight = 190;

void Label(const FrameContext& context, const char* text) {
  ImGui::AlignTextToFramePadding();
  DimText("%s", text);
  ImGui::SameLine(context.Scaled(110));
}

}  // namespace

void ForkSheet::Open(const FrameContext& context, bool show) {
  open_ = show && context.fork_offer != nullptr;
  forks_ = true;
  waits_ = false;
  filter_[0] = '\0';
  frame_ = context.playback->frame;
  if (!open_) return;
  why_not_ = context.fork_offer->why_not;
  options_ = before_ = context.fork_offer->options;
  seed_ = before_seed_ = static_cast<int>(context.fork_offer->seed);
  std::strncpy(out_, context.fork_offer->out.c_str(), sizeof(out_) - 1);
}

void ForkSheet::OpenOptions(const FrameContext& context, bool show) {
  open_ = show;
  forks_ = waits_ = false;
  filter_[0] = '\0';
  why_not_ = context.playback->options == nullptr ? "Nothing is open: open a sequence first."
             : context.playback->recorded
                 ? "A recorded run keeps its options. Fork it to try others."
                 : "";
  if (context.playback->options != nullptr) options_ = before_ = *context.playback->options;
}

void ForkSheet::Draw(const FrameContext& context, CommandSink& sink) {
  if (!open_) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const bool running =
      forks_ && context.fork != nullptr && context.fork->state == ForkState::kRunning;
  const bool form = !running && why_not_.empty();
  const ImVec2 size(std::min(context.Scaled(kWidth), 0.94f * display.x),
                    std::min(context.Scaled(form ? kHeight : kLowHeight), 0.9f * display.y));
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(24), context.Scaled(18)});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kSheet);
  ImGui::Begin(
      "fork", nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  if (ImGui::IsWindowAppearing()) ImGui::SetWindowFocus();
  ImGui::PushFont(context.fonts.strong);
  if (forks_)
    ImGui::Text("What if? Fork from frame %d", frame_);
  else
    ImGui::TextUnformatted("Options of this run, from the next frame on");
  ImGui::PopFont();
  if (waits_ && !running && context.fork->state != ForkState::kFailed) open_ = false;
  if (running)
    DrawProgress(context, sink);
  else
    DrawBody(context, sink);
  if (ImGui::IsKeyPressed(keys::kEscape, false) && !AsksForPath(context)) open_ = false;
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

void ForkSheet::DrawBody(const FrameContext& context, CommandSink& sink) {
  if (!why_not_.empty()) {
    ImGui::Dummy({0, context.Scaled(10)});
    ImGui::TextWrapped("%s", why_not_.c_str());
    ImGui::Dummy({0, context.Scaled(10)});
    if (Button(context, "fork.close", "Close", "Esc closes it too.")) open_ = false;
    return;
  }
  DrawExplanation(context);
  if (forks_) DrawPlace(context);
  DrawFilter(context);
  DrawOptions(context);
  DrawButtons(context, sink);
}

void ForkSheet::DrawProgress(const FrameContext& context, CommandSink& sink) {
  const ForkView& fork = *context.fork;
  ImGui::Dummy({0, context.Scaled(10)});
  ImGui::TextWrapped("%s", fork.out.c_str());
  ImGui::Dummy({0, context.Scaled(4)});
  const double share = fork.total > 0 ? static_cast<double>(fork.done) / fork.total : 0;
  Bar({ImGui::GetContentRegionAvail().x, context.Scaled(10)}, share, colors::kAccent);
  LogItem(context, "fork.progress");
  if (fork.total > 0)
    DimText("%s: %d of %d", fork.message.c_str(), fork.done, fork.total);
  else
    DimText("%s", fork.message.c_str());
  ImGui::Dummy({0, context.Scaled(10)});
  if (Button(context, "fork.cancel", "Stop", "Stops the fork; what is done stays in its file."))
    sink.Post(CancelForkCommand{});
  ImGui::SameLine();
  if (Button(context, "fork.hide", "Go on meanwhile",
             "Closes this sheet; the fork is opened beside the run once it is done."))
    open_ = false;
}

void ForkSheet::DrawExplanation(const FrameContext& context) const {
  WrappedText(colors::kDimText,
              forks_
                  ? "The past up to this frame is taken over as it is; from the next frame on the "
                    "mapper goes on with these options and this seed, into a file of its own."
                  : "The mapper uses them from the next frame that it maps. The change is "
                    "marked in the timeline and kept in the run, so that it can be resumed and "
                    "forked as it was.");
  if (forks_ && context.fork != nullptr && context.fork->state == ForkState::kFailed)
    WrappedText(colors::kBad, "The last fork: " + context.fork->message);
  ImGui::Dummy({0, context.Scaled(6)});
}

void ForkSheet::DrawPlace(const FrameContext& context) {
  Label(context, "New run file");
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - BrowseWidth(context));
  ImGui::InputText("##fork.out", out_, sizeof(out_));
  LogItem(context, "fork.out");
  Tooltip(context, "Where the fork is kept. A run of that name is replaced.");
  BrowseButton(context, "fork.browse", [this] {
    return PathQuestion{.what = PathQuestion::What::kSave,
                        .title = "Where the fork is kept",
                        .button = "Take it",
                        .kinds = {PathKind::kRun},
                        .at = out_,
                        .ending = ".plb",
                        .answer = [this](const std::string& path, CommandSink&) {
                          std::snprintf(out_, sizeof(out_), "%s", path.c_str());
                        }};
  });
  Label(context, "Seed");
  ImGui::SetNextItemWidth(context.Scaled(110));
  ImGui::InputInt("##fork.seed", &seed_);
  seed_ = std::max(seed_, 0);
  LogItem(context, "fork.seed");
  Tooltip(context,
          "Seed of all randomness. With the same seed and options the fork is the same run.");
  ImGui::SameLine(0, context.Scaled(24));
}

void ForkSheet::DrawFilter(const FrameContext& context) {
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##fork.filter", "find an option", filter_, sizeof(filter_));
  LogItem(context, "fork.filter");
  Tooltip(context, "Shows the options whose name, key or description contains this text.");
  ImGui::Dummy({0, context.Scaled(4)});
}

void ForkSheet::DrawOptions(const FrameContext& context) {
  const float below = ImGui::GetFrameHeightWithSpacing() + context.Scaled(14);
  ImGui::PushStyleColor(ImGuiCol_ChildBg, colors::kPanel);
  ImGui::BeginChild("fork.options", {0, ImGui::GetContentRegionAvail().y - below}, false,
                    ImGuiWindowFlags_AlwaysUseWindowPadding);
  DrawOptionsForm(context, "fork.option", filter_, MapperOptionNames(), before_, options_);
  ImGui::EndChild();
  ImGui::PopStyleColor();
}

void ForkSheet::DrawButtons(const FrameContext& context, CommandSink& sink) {
  ImGui::Dummy({0, context.Scaled(4)});
  const int changed = NumChanged(before_, options_);
  const bool other_seed = forks_ && seed_ != before_seed_;
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  const bool start =
      forks_
          ? Button(context, "fork.start", "Fork",
                   "Starts it; the fork is opened beside the run once it is done.")
          : Button(context, "options.apply", "Change", "Used from the next frame that is mapped.");
  ImGui::PopStyleColor();
  if (start && forks_ && out_[0] != '\0') {
    sink.Post(ForkCommand{frame_, options_, static_cast<std::uint64_t>(seed_), out_});
    waits_ = true;
  } else if (start && !forks_) {
    if (changed > 0) sink.Post(SetOptionsCommand{options_});
    open_ = false;
  }
  ImGui::SameLine();
  if (Button(context, "fork.close", "Cancel", "Esc closes it too.")) open_ = false;
  ImGui::SameLine(0, context.Scaled(16));
  ImGui::AlignTextToFramePadding();
  if (changed == 0 && !other_seed)
    DimText(forks_ ? "Nothing is changed yet: the fork would be the same run."
                   : "Nothing is changed yet.");
  else
    DimText("%d %s changed%s", changed, changed == 1 ? "option" : "options",
            other_seed ? ", another seed" : "");
}

}  // namespace plumbline
