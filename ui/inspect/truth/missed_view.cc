// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/truth/missed_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/geometry/angles.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

void SeekButton(const FrameContext& context, const char* name, const char* label, int frame,
                const char* help, CommandSink& sink) {
  if (frame < 0) return;
  ImGui::SameLine();
  if (Button(context, name, fmt::format("{} {}", label, frame).c_str(), help))
    sink.Post(SeekCommand{frame});
}

void DrawBoxes(const TruthView& truth) {
  std::string text;
  constexpr std::size_t kMost = 4;
  for (std::size_t i = 0; i < std::min(kMost, truth.boxes.size()); ++i) {
    const BoxUse& use = truth.boxes[i];
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", use.frames, InWords(NameOf(use.fate)));
    if (use.object.value > 0)
      text +=
          fmt::format("{} #{}", use.fate == ProposalFate::kSpawned ? "" : " by", use.object.value);
  }
  if (truth.boxes.size() > kMost) text += fmt::format(", {} more", truth.boxes.size() - kMost);
  ImGui::PushStyleColor(ImGuiCol_Text, colors::kDimText);
  ImGui::TextWrapped("Boxed in %d of %d%s%s", truth.frames_boxed, truth.frames_seen,
                     text.empty() ? "" : ": ", text.c_str());
  ImGui::PopStyleColor();
}

void DrawCandidate(const FrameContext& context, const NearCandidate& candidate, CommandSink& sink) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const std::string name = fmt::format("missed.candidate.{}", candidate.object.value);
  if (ImGui::Selectable(fmt::format("#{}##{}", candidate.object.value, name).c_str(), false,
                        ImGuiSelectableFlags_SpanAllColumns)) {
    sink.Post(SeekCommand{candidate.nearest_frame});
    sink.Post(SelectObjectCommand{candidate.object});
  }
  LogItem(context, name);
  Tooltip(context, candidate.end.empty()
                       ? "It lives. A click goes to where it was nearest."
                       : candidate.end + ". A click goes to where it was nearest.");
  ImGui::TableNextColumn();
  ImGui::Text("%d, %.0f cm", candidate.first_frame, 100 * candidate.first_m);
  ImGui::TableNextColumn();
  ImGui::Text("%d, %.0f cm, %.0f\u00b0", candidate.nearest_frame, 100 * candidate.nearest_m,
              kDegPerRad * candidate.nearest_rad);
  ImGui::TableNextColumn();
  ImGui::Text("\u00b1 %.0f cm", 100 * candidate.last_std_m);
  if (candidate.last_std_rad > 0) {
    ImGui::SameLine(0, 0);
    ImGui::Text(", %.0f\u00b0", kDegPerRad * candidate.last_std_rad);
  }
  ImGui::TableNextColumn();
  ImGui::Text("%.1f", candidate.most_evidence);
  ImGui::TableNextColumn();
  if (candidate.ended)
    ImGui::Text("%d", *candidate.ended);
  else
    DimText("lives");
}

void DrawCandidates(const FrameContext& context, const TruthView& truth, CommandSink& sink) {
  if (truth.candidates.empty()) return DimText("No candidate came within 60 cm of it.");
  const TableHead heads[] = {
      {"Candidate", "An object that came near and became no other true instance."},
      {"Appeared", "In which frame, and how far from the true place."},
      {"Nearest", "In which frame it came nearest, how near, and how far it was turned."},
      {"Belief", "How wide it is when it was last looked at: a wide one is not confirmed."},
      {"Evidence", "The most that it came to: log odds that it exists."},
      {"Gone", "In which frame it was withdrawn or merged; point at the row for the reason."}};
  if (!ImGui::BeginTable("missed.candidates", static_cast<int>(std::size(heads)),
                         ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp))
    return;
  DrawTableHeads(context, heads);
  constexpr std::size_t kMost = 8;
  for (std::size_t i = 0; i < std::min(kMost, truth.candidates.size()); ++i)
    DrawCandidate(context, truth.candidates[i], sink);
  ImGui::EndTable();
}

/// Would it have been confirmed, had it been found? A fork tells.
void DrawPlanting(const FrameContext& context, const TruthView& truth, CommandSink& sink) {
  if (truth.first_seen < 0) return;
  const ForkView* fork = context.fork.get();
  const bool busy = fork != nullptr && fork->state == ForkState::kRunning;
  ImGui::Spacing();
  ImGui::BeginDisabled(busy || context.shows_other);
  if (Button(
          context, "missed.plant", "Plant it and see",
          "Forks the run where it first shows, with a candidate at its true place, and opens the "
          "fork beside this run: does the candidate gather the evidence that it needs?")) {
    ForkCommand command;
    command.frame = std::max(0, truth.first_seen - 1);
    command.plant = truth.id;
    sink.Post(command);
  }
  ImGui::EndDisabled();
  if (fork == nullptr) return;
  ImGui::SameLine();
  if (busy)
    DimText("Mapping the fork: %d of %d frames ('What if?' stops it)", fork->done, fork->total);
  else if (fork->state == ForkState::kFailed)
    DimText("%s", fork->message.c_str());
}

}  // namespace

void DrawMissedView(const FrameContext& context, const TruthView& truth, CommandSink& sink) {
  ImGui::PushStyleColor(ImGuiCol_Text, truth.found ? colors::kGood : colors::kWarning);
  ImGui::TextWrapped("%s", truth.text.c_str());
  ImGui::PopStyleColor();
  ImGui::AlignTextToFramePadding();
  if (truth.frames_seen == 0) {
    DimText("It shows in no frame.");
  } else {
    DimText("Shows in %d of %d frames", truth.frames_seen, truth.frames);
    SeekButton(context, "missed.first", "First", truth.first_seen, "Goes to the first of them.",
               sink);
    SeekButton(context, "missed.best", "Most of it", truth.best_frame,
               "Goes to the frame in which most of it shows.", sink);
    SeekButton(context, "missed.last", "Last", truth.last_seen, "Goes to the last of them.", sink);
    DrawBoxes(truth);
  }
  DrawCandidates(context, truth, sink);
  if (!truth.found) DrawPlanting(context, truth, sink);
}

}  // namespace plumbline
