// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "engine/snapshot/commands.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kQueueWidth = 660, kQueueHeight = 420;

ImU32 ColorOf(WorkStage stage) {
  switch (stage) {
    case WorkStage::kInWork:
      return colors::kWarning;
    case WorkStage::kToReview:
      return colors::kAccent;
    case WorkStage::kDone:
      return colors::kGood;
    case WorkStage::kNew:
      break;
  }
  return colors::kText;
}

std::string TimeInWords(double seconds) {
  if (seconds <= 0) return "";
  if (seconds < 60) return fmt::format("{:.0f} s", seconds);
  if (seconds < 3600) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

/// "Ada, Grace; reviewed by Edsger"
std::string WhoOf(const QueueEntry& entry) {
  std::string who;
  for (const std::string& name : entry.annotators) who += (who.empty() ? "" : ", ") + name;
  if (entry.reviewer.empty()) return who;
  return who + (entry.stage == WorkStage::kDone ? "; reviewed by " : "; sent back by ") +
         entry.reviewer;
}

/// What was said of it last.
std::string SaidOf(const ProjectState& state) {
  const bool by_reviewer = !state.reviewer.empty();
  std::string text;
  switch (state.stage) {
    case WorkStage::kToReview:
      text = "handed over by " + state.annotator;
      break;
    case WorkStage::kDone:
      text = by_reviewer ? "by " + state.annotator + ", reviewed by " + state.reviewer
                         : "by " + state.annotator + "; nobody has reviewed it";
      break;
    default:
      text = by_reviewer ? "sent back by " + state.reviewer : "taken back by " + state.annotator;
  }
  return text + (state.note.empty() ? "" : ": \u201c" + state.note + "\u201d");
}

void DrawStage(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  AnnotateView& view = *context.annotate;
  ImGui::TextUnformatted(snapshot.project_name.c_str());
  ImGui::SameLine(0, context.Scaled(8));
  ImGui::PushStyleColor(ImGuiCol_Text, ColorOf(snapshot.stage));
  ImGui::TextUnformatted(std::string(NameOf(snapshot.stage)).c_str());
  ImGui::PopStyleColor();
  LogItem(context, "queue.stage");
  if (snapshot.project_state) WrappedText(colors::kDimText, SaidOf(*snapshot.project_state));
  if (snapshot.read_only) return;
  const auto button = [&](const char* name, const char* label, WorkStage stage, const char* help) {
    if (Button(context, name, label, help)) {
      sink.Post(SetStageCommand{stage, view.stage_note});
      view.stage_note.clear();
    }
    ImGui::SameLine(0, context.Scaled(6));
  };
  const bool mine =
      snapshot.project_state && snapshot.project_state->annotator == snapshot.annotator;
  const bool waits = snapshot.stage == WorkStage::kToReview;
  if (!waits && snapshot.stage != WorkStage::kDone) {
    button("queue.hand_over", "Hand over for review", WorkStage::kToReview,
           "Somebody else looks at it, and says that it is done or sends it back. One edit.");
    button("queue.done", "Done", WorkStage::kDone, "Done, and nobody reviews it. One edit.");
  } else {
    if (waits && !mine)
      button("queue.done", "Reviewed: done", WorkStage::kDone,
             "It is good. Your name is kept as the reviewer's. One edit.");
    button("queue.back", "Back to work", WorkStage::kInWork,
           "Something has to be mended: say in the note what. One edit.");
  }
  char note[1024];
  std::snprintf(note, sizeof(note), "%s", view.stage_note.c_str());
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (ImGui::InputTextWithHint("##queue.note", "Note, kept with the button's answer", note,
                               sizeof(note)))
    view.stage_note = note;
  LogItem(context, "queue.note");
  Tooltip(context, "Is kept with the state when one of these buttons is pressed.");
  SmallText(context, colors::kFaint,
            waits && mine ? "You are %s and handed it over: somebody else reviews it."
                          : "You are %s (More, Annotator).",
            snapshot.annotator.empty() ? "nobody yet" : snapshot.annotator.c_str());
}

void DrawFolder(const FrameContext& context, const AnnotationQueueView* queue, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  char folder[1024];
  const std::string& shown =
      view.queue_folder.empty() && queue != nullptr ? queue->folder : view.queue_folder;
  std::snprintf(folder, sizeof(folder), "%s", shown.c_str());
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - context.Scaled(64) -
                          BrowseWidth(context));
  const bool entered =
      ImGui::InputTextWithHint("##queue.folder", "Folder of scans", folder, sizeof(folder),
                               ImGuiInputTextFlags_EnterReturnsTrue);
  if (ImGui::IsItemEdited()) view.queue_folder = folder;
  LogItem(context, "queue.folder");
  Tooltip(context, "Scans and annotation projects of this folder and of the folders in it.");
  BrowseButton(context, "queue.browse", [&] {
    return PathQuestion{.what = PathQuestion::What::kFolder,
                        .title = "Choose a folder of scans",
                        .button = "List",
                        .at = shown.empty() ? "" : shown + "/",
                        .answer =
                            [&view](const std::string& path, CommandSink& to) {
                              view.queue_folder = path;
                              view.open_queue = true;
                              to.Post(ListQueueCommand{path});
                            },
                        .gave_up = [&view] { view.open_queue = true; }};
  });
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "queue.list", "List", "Reads the folder again.") || entered)
    sink.Post(ListQueueCommand{folder});
}

void DrawEntry(const FrameContext& context, const QueueEntry& entry, bool open, CommandSink& sink) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const std::string name = "queue.row." + entry.name;
  if (ImGui::Selectable((entry.name + "##" + name).c_str(), open,
                        ImGuiSelectableFlags_SpanAllColumns)) {
    if (!open) sink.Post(OpenCommand{entry.path});
    ImGui::CloseCurrentPopup();
  }
  LogItem(context, name);
  const std::string& more = entry.problem.empty() ? entry.note : entry.problem;
  Tooltip(context, more.empty() ? entry.path : entry.path + "\n" + more);
  ImGui::TableNextColumn();
  const bool readable = entry.problem.empty();
  ImGui::PushStyleColor(ImGuiCol_Text, readable ? ColorOf(entry.stage) : colors::kBad);
  ImGui::TextUnformatted(readable ? std::string(NameOf(entry.stage)).c_str() : "cannot be read");
  ImGui::PopStyleColor();
  ImGui::TableNextColumn();
  if (entry.objects > 0) ImGui::Text("%zu", entry.objects);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(TimeInWords(entry.seconds).c_str());
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(WhoOf(entry).c_str());
}

void DrawEntries(const FrameContext& context, const AnnotationQueueView& queue, CommandSink& sink) {
  const ImGuiTableFlags flags =
      ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_SizingFixedFit;
  const float below = ImGui::GetTextLineHeightWithSpacing();
  if (ImGui::BeginTable("queue.table", 5, flags, {0, ImGui::GetContentRegionAvail().y - below})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("Scan", ImGuiTableColumnFlags_WidthStretch, 3);
    ImGui::TableSetupColumn("State");
    ImGui::TableSetupColumn("Objects");
    ImGui::TableSetupColumn("Time");
    ImGui::TableSetupColumn("Who", ImGuiTableColumnFlags_WidthStretch, 2);
    ImGui::TableHeadersRow();
    for (std::size_t i = 0; i < queue.entries.size(); ++i)
      DrawEntry(context, queue.entries[i], queue.open == i, sink);
    ImGui::EndTable();
  }
  std::array<std::size_t, 4> count{};
  std::size_t objects = 0;
  double seconds = 0;
  for (const QueueEntry& entry : queue.entries) {
    ++count[static_cast<std::size_t>(entry.stage)];
    objects += entry.objects;
    seconds += entry.seconds;
  }
  std::string text;
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count[i],
                        NameOf(static_cast<WorkStage>(i)));
  }
  const std::string time = TimeInWords(seconds);
  SmallText(context, colors::kDimText, "%s; %zu object%s%s%s", text.c_str(), objects,
            objects == 1 ? "" : "s", time.empty() ? "" : " in ", time.c_str());
}

}  // namespace

float QueueWidth(const FrameContext& context) {
  return context.Scaled(kQueueWidth) + 2 * ImGui::GetStyle().WindowPadding.x;
}

void DrawQueue(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const AnnotationQueueView* queue = snapshot.queue ? &*snapshot.queue : nullptr;
  ImGui::BeginChild("queue", {context.Scaled(kQueueWidth), context.Scaled(kQueueHeight)});
  DrawStage(context, sink);
  ImGui::Dummy({0, context.Scaled(6)});
  ImGui::Separator();
  ImGui::Dummy({0, context.Scaled(2)});
  DrawFolder(context, queue, sink);
  if (queue == nullptr) {
    DimText("reading the folder ...");
  } else if (!queue->problem.empty()) {
    WrappedText(colors::kBad, queue->problem);
  } else if (queue->entries.empty()) {
    DimText("No scans and no annotation projects in this folder.");
  } else {
    DrawEntries(context, *queue, sink);
  }
  ImGui::EndChild();
}

}  // namespace plumbline
