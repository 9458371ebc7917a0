// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <string>

#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kBannerWidth = 600, kPadding = 14;

/// A sheet over the top of the view that is as high as what is in it.
void BeginSheet(const FrameContext& context, const char* name, float x, float& y, float width,
                ImU32 edge) {
  ImGui::SetCursorScreenPos({x, y});
  ImGui::PushStyleColor(ImGuiCol_ChildBg, colors::kSheet);
  ImGui::PushStyleColor(ImGuiCol_Border, edge);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(kPadding), context.Scaled(10)});
  // Heights are those of the last frame: what is in a sheet rarely changes.
  ImGuiStorage& heights = *ImGui::GetStateStorage();
  const float height = heights.GetFloat(ImGui::GetID(name), context.Scaled(80));
  ImGui::PushStyleVar(ImGuiStyleVar_ChildBorderSize, context.Scaled(1));
  ImGui::BeginChild(name, {width, height}, true,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_AlwaysUseWindowPadding);
  ImGui::PushTextWrapPos(width - context.Scaled(kPadding));
}

void EndSheet(const FrameContext& context, const char* name, float& y) {
  ImGui::PopTextWrapPos();
  const float height = ImGui::GetCursorPosY() + context.Scaled(6);
  ImGui::EndChild();
  LogItem(context, name);
  ImGui::PopStyleVar(2);
  ImGui::PopStyleColor(2);
  ImGui::GetStateStorage()->SetFloat(ImGui::GetID(name), height);
  y += height + context.Scaled(8);
}

void DrawDiskProblem(const FrameContext& context, float x, float& y, float width,
                     CommandSink& sink) {
  const std::string& problem = context.annotation->journal_problem;
  if (problem.empty()) return;
  BeginSheet(context, "annotate.disk", x, y, width, colors::kBad);
  ImGui::PushStyleColor(ImGuiCol_Text, colors::kBad);
  ImGui::TextUnformatted("Your edits have not been written to disk.");
  ImGui::PopStyleColor();
  std::string why = problem;
  why[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(why[0])));
  ImGui::TextWrapped("%s. What waits is written as soon as there is room.", why.c_str());
  static constexpr std::size_t kLongest = 512;
  char path[kLongest];
  std::snprintf(path, sizeof(path), "%s", context.annotate->save_elsewhere.c_str());
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - context.Scaled(120) -
                          BrowseWidth(context));
  const bool entered =
      ImGui::InputTextWithHint("##annotate.elsewhere", "/another/disk/PROJECT.json", path,
                               sizeof(path), ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "annotate.elsewhere");
  context.annotate->save_elsewhere = path;
  BrowseButton(context, "annotate.elsewhere.browse", [&] {
    return PathQuestion{.what = PathQuestion::What::kSave,
                        .title = "Save the project elsewhere",
                        .button = "Save",
                        .kinds = {PathKind::kProject},
                        .at = path,
                        .ending = ".json",
                        .answer = [](const std::string& chosen, CommandSink& to) {
                          to.Post(SaveProjectCommand{chosen});
                        }};
  });
  ImGui::SameLine(0, context.Scaled(6));
  const bool clicked =
      Button(context, "annotate.save_elsewhere", "Save elsewhere",
             "Continues in that file; paths to scan, models and sequence are adapted.");
  if ((entered || clicked) && path[0] != '\0') sink.Post(SaveProjectCommand{path});
  if (context.annotation->refused) {
    ImGui::PushStyleColor(ImGuiCol_Text, colors::kWarning);
    ImGui::TextWrapped("%s", context.annotation->answer.c_str());
    ImGui::PopStyleColor();
  }
  EndSheet(context, "annotate.disk", y);
}

/// Metres are asked for where no room can be meant.
void DrawUnitQuestion(const FrameContext& context, float x, float& y, float width,
                      CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  if (!snapshot.doubted_size_m || !snapshot.instances.empty()) return;
  BeginSheet(context, "annotate.unit", x, y, width, colors::kWarning);
  ImGui::TextWrapped(
      "%s spans %.0f in the unit of its file. If that were metres, it would be larger than any "
      "room, and models would be lost in it. Which unit is it?",
      snapshot.scan_name.c_str(), *snapshot.doubted_size_m);
  ImGui::Dummy({0, context.Scaled(2)});
  const auto unit = [&](const char* name, const char* label, double metres, const char* help) {
    if (Button(context, name, label, help)) sink.Post(SetScanUnitCommand{metres});
    ImGui::SameLine(0, context.Scaled(6));
  };
  const char* copies =
      "Writes a copy in metres beside the scan and goes on with that. Undo goes back to this one.";
  ImGui::BeginDisabled(snapshot.read_only);
  unit("annotate.unit.mm", "Millimetres", 0.001, copies);
  unit("annotate.unit.cm", "Centimetres", 0.01, copies);
  ImGui::EndDisabled();
  unit("annotate.unit.m", "Metres, as it is", 1, "It stays as it is.");
  ImGui::NewLine();
  EndSheet(context, "annotate.unit", y);
}

void DrawNotices(const FrameContext& context, float x, float& y, float width, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  if (snapshot.notices.empty()) return;
  BeginSheet(context, "annotate.notices", x, y, width, colors::kWarning);
  for (const std::string& notice : snapshot.notices) ImGui::TextWrapped("%s", notice.c_str());
  ImGui::Dummy({0, context.Scaled(2)});
  if (snapshot.num_recovered > 0) {
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    if (Button(context, "annotate.recover_save", "Keep and save", "Saves the project with them.")) {
      sink.Post(SaveProjectCommand{});
      sink.Post(DismissNoticesCommand{});
    }
    ImGui::PopStyleColor();
    ImGui::SameLine(0, context.Scaled(6));
    if (Button(context, "annotate.recover_drop", "Undo them all",
               "Restores the project as it was saved; Redo restores the edits.")) {
      sink.Post(DropRecoveredCommand{});
    }
    ImGui::SameLine(0, context.Scaled(6));
  }
  if (Button(context, "annotate.dismiss", snapshot.num_recovered > 0 ? "Decide later" : "OK", "")) {
    sink.Post(DismissNoticesCommand{});
  }
  EndSheet(context, "annotate.notices", y);
}

}  // namespace

void DrawAnnotateBanners(const FrameContext& context, ImVec2 low, ImVec2 high, CommandSink& sink) {
  const float width = std::min(context.Scaled(kBannerWidth), high.x - low.x - context.Scaled(24));
  const float x = 0.5f * (low.x + high.x - width);
  float y = low.y + context.Scaled(10);
  DrawDiskProblem(context, x, y, width, sink);
  DrawUnitQuestion(context, x, y, width, sink);
  DrawNotices(context, x, y, width, sink);
}

}  // namespace plumbline
