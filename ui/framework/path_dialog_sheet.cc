// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "ui/framework/path_dialog.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr const char* kPathPopup = "path_dialog";
constexpr double kDialogWidth = 860, kDialogHeight = 560, kPlacesWidth = 176;
constexpr double kRoomForPlaces = 560, kRoomForColumns = 540;  ///< Of the dialog; of the list.

const char* WordFor(PathKind kind) {
  switch (kind) {
    case PathKind::kSequence:
      return "sequence";
    case PathKind::kRun:
      return "recorded run";
    case PathKind::kScan:
      return "scan";
    case PathKind::kProject:
      return "annotation project";
    case PathKind::kModels:
      return "models";
    case PathKind::kNetwork:
      return "network";
    case PathKind::kFolder:
      return "folder";
    case PathKind::kOther:
      break;
  }
  return "";
}

/// "sequences (folders), recorded runs (.plb)"
std::string WordsFor(const std::vector<PathKind>& kinds) {
  std::string words;
  for (const PathKind kind : kinds) {
    const char* word = kind == PathKind::kSequence  ? "sequences"
                       : kind == PathKind::kRun     ? "recorded runs (.plb)"
                       : kind == PathKind::kScan    ? "scans (.ply, .pcd, .obj)"
                       : kind == PathKind::kProject ? "annotation projects (.json)"
                       : kind == PathKind::kModels  ? "folders of models"
                       : kind == PathKind::kNetwork ? "networks (.onnx)"
                       : kind == PathKind::kFolder  ? "folders"
                                                    : "";
    if (*word == '\0') continue;
    if (!words.empty()) words += kind == kinds.back() ? " or " : ", ";
    words += word;
  }
  return words;
}

std::string SizeText(std::uintmax_t bytes) {
  const auto size = static_cast<double>(bytes);
  return bytes < 1000     ? fmt::format("{} B", bytes)
         : bytes < 999500 ? fmt::format("{:.3g} kB", size / 1e3)
         : size < 999.5e6 ? fmt::format("{:.3g} MB", size / 1e6)
                          : fmt::format("{:.3g} GB", size / 1e9);
}

std::string DateText(std::int64_t seconds) {
  if (seconds == 0) return "";
  const std::time_t time = seconds;
  std::tm local{};
  localtime_r(&time, &local);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M", &local);
  return text;
}

/// A folder, or a sheet of paper.
void DrawFileIcon(const FrameContext& context, ImVec2 low, bool folder, ImU32 color) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float s = context.Scaled(1);
  if (folder) {
    draw.AddRectFilled({low.x, low.y + 1 * s}, {low.x + 6 * s, low.y + 5 * s}, color, 1.5f * s);
    draw.AddRectFilled({low.x, low.y + 3 * s}, {low.x + 14 * s, low.y + 12 * s}, color, 1.5f * s);
  } else {
    draw.AddRect({low.x + 2 * s, low.y}, {low.x + 12 * s, low.y + 13 * s}, color, 1.5f * s, 0, s);
    for (const float y : {4.0f, 6.5f, 9.0f})
      draw.AddLine({low.x + 4.5f * s, low.y + y * s}, {low.x + 9.5f * s, low.y + y * s}, color, s);
  }
}

/// The beginning of what is too long makes room: the end of a path tells more.
std::string EndOf(std::string text, float room) {
  constexpr const char* kMore = "\u2026";
  if (ImGui::CalcTextSize(text.c_str()).x <= room) return text;
  const auto is_inner_byte = [](char c) { return (c & 0xC0) == 0x80; };  // of UTF-8
  while (!text.empty() && ImGui::CalcTextSize((kMore + text).c_str()).x > room) {
    text.erase(0, 1);
    while (!text.empty() && is_inner_byte(text.front())) text.erase(0, 1);
  }
  return kMore + text;
}

/// What the field, which keeps a text of its own while it is edited, and its owner ask of each
/// other.
struct FieldEdits {
  std::optional<std::string>* new_text;  ///< Instead of what it has.
  bool* selects_name;                    ///< Then what follows the last slash is marked.
  bool* continues;                       ///< What was typed meanwhile comes after it.
  const std::string& before;
  bool completes = false;
};

int EditField(ImGuiInputTextCallbackData* data) {
  auto& edits = *static_cast<FieldEdits*>(data->UserData);
  if (data->EventFlag == ImGuiInputTextFlags_CallbackCompletion) edits.completes = true;
  if (data->EventFlag != ImGuiInputTextFlags_CallbackAlways || !*edits.new_text) return 0;
  std::string text = **edits.new_text;
  const std::string now(data->Buf, static_cast<std::size_t>(data->BufTextLen));
  if (std::exchange(*edits.continues, false) && now != edits.before) text += now;
  edits.new_text->reset();
  data->DeleteChars(0, data->BufTextLen);
  data->InsertChars(0, text.c_str());
  if (!std::exchange(*edits.selects_name, false)) return 0;
  const std::size_t name = text.rfind('/') + 1, dot = text.rfind('.');
  data->SelectionStart = static_cast<int>(name);
  data->SelectionEnd = data->CursorPos =
      dot != std::string::npos && dot > name ? static_cast<int>(dot) : data->BufTextLen;
  return 0;
}

}  // namespace

bool PathDialog::Draw(const FrameContext& context, CommandSink& sink) {
  if (!is_open()) return false;
  const bool fresh = std::exchange(fresh_, false);
  if (fresh) ImGui::OpenPopup(kPathPopup);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const ImVec2 size(std::min(context.Scaled(kDialogWidth), 0.96f * display.x),
                    std::min(context.Scaled(kDialogHeight), 0.94f * display.y));
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(20), context.Scaled(16)});
  ImGui::PushStyleColor(ImGuiCol_PopupBg, colors::kSheet);
  const bool begun = ImGui::BeginPopupModal(
      kPathPopup, nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
  if (!begun) {  // another popup has taken its place
    Close();
    return true;
  }
  if (decides_ && Knows()) Decide(sink);
  // The key that opened it does nothing else.
  if (is_open() && !fresh) TakeKeys(sink);
  if (is_open()) {
    DrawTitle(context);
    DrawPath(context, sink);
  }
  if (is_open()) {
    const bool places = size.x >= context.Scaled(kRoomForPlaces);
    const float below = ImGui::GetFrameHeight() +
                        ImGui::CalcTextSize(RemarkBelow().text.c_str(), nullptr, false,
                                            ImGui::GetContentRegionAvail().x)
                            .y +
                        3 * ImGui::GetStyle().ItemSpacing.y;
    const float height = std::max(context.Scaled(60), ImGui::GetContentRegionAvail().y - below);
    if (places) {
      DrawPlaces(context, context.Scaled(kPlacesWidth), height, sink);
      ImGui::SameLine(0, context.Scaled(10));
    }
    if (is_open()) DrawList(context, height, sink);
    if (is_open()) DrawBelow(context, sink);
  }
  if (!is_open()) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  return true;
}

void PathDialog::DrawTitle(const FrameContext& context) const {
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted(question_->title.c_str());
  ImGui::PopFont();
  LogItem(context, "path.title");
}

void PathDialog::DrawPath(const FrameContext& context, CommandSink& sink) {
  if (Button(context, "path.up", "Up", "The folder above (Backspace).")) GoUp();
  ImGui::SameLine(0, context.Scaled(6));
  ImGui::SetNextItemWidth(-1);
  const bool focuses = std::exchange(focus_, false);
  if (focuses) ImGui::SetKeyboardFocusHere();
  const std::string before = field_;
  FieldEdits edits{&new_text_, &selects_name_, &continues_, before};
  const bool entered =
      ImGui::InputText("##path.field", field_, sizeof(field_),
                       ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CallbackAlways |
                           ImGuiInputTextFlags_CallbackCompletion,
                       EditField, &edits);
  const bool edited = ImGui::IsItemEdited();
  typing_ = ImGui::IsItemActive() || focuses;
  LogItem(context, "path.field");
  Tooltip(context,
          "The path; Tab completes it, ~ is your home, a name alone is one of this folder.");
  if (edited && before != field_) FieldChanged();
  if (edits.completes) Complete();
  if (entered) Choose(false, sink);
  ImGui::Dummy({0, context.Scaled(2)});
}

void PathDialog::DrawPlaces(const FrameContext& context, float width, float height,
                            CommandSink& sink) {
  ImGui::BeginChild("path.places", {width, height});
  const auto place = [&](const std::string& name, const std::string& label,
                         const std::string& folder) {
    const float room = ImGui::GetContentRegionAvail().x;
    const bool clicked =
        ImGui::Selectable((EndOf(label, room) + "##" + name).c_str(), folder == folder_);
    LogItem(context, name);
    Tooltip(context, folder);
    return clicked;
  };
  const bool saves = question_->what == PathQuestion::What::kSave;
  const auto go = [&](const std::string& folder) { Show(folder, saves ? NameOfField() : ""); };
  SmallText(context, colors::kAccent, "Places");
  if (place("path.home", "Home", home_)) go(home_);
  if (place("path.working", "Started in", working_)) go(working_);
  if (place("path.root", "Everything", "/")) go("/");
  if (!places_.empty()) {
    ImGui::Dummy({0, context.Scaled(4)});
    SmallText(context, colors::kAccent, "Used before");
  }
  const std::vector<std::string> used = places_;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (place(fmt::format("path.place.{}", i), NameIn(used[i]), used[i])) go(used[i]);
  }
  if (question_->offers_recent && !context.recent.empty()) {
    ImGui::Dummy({0, context.Scaled(4)});
    SmallText(context, colors::kAccent, "Opened before");
    for (std::size_t i = 0; i < context.recent.size() && is_open(); ++i) {
      const std::string& path = context.recent[i];
      const bool demo = path == kDemoPath;
      const bool chosen =
          place(fmt::format("path.recent.{}", i), demo ? "Built-in demo" : NameIn(path), path);
      if (!chosen) continue;
      if (demo) {
        const auto answer = std::move(question_->answer);
        question_.reset();
        answer(path, sink);
      } else {
        Answer(path, sink);
      }
    }
  }
  ImGui::EndChild();
}

void PathDialog::DrawList(const FrameContext& context, float height, CommandSink& sink) {
  const float width = ImGui::GetContentRegionAvail().x;
  const int columns = width >= context.Scaled(kRoomForColumns) ? 4 : 2;
  ImGui::PushStyleColor(ImGuiCol_ChildBg, colors::kPanel);
  if (ImGui::BeginTable(
          "path.list", columns,
          ImGuiTableFlags_ScrollY | ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_PadOuterX,
          {width, height})) {
    std::vector<TableHead> heads = {
        {"Name", "Folders first. Letters jump to the names that begin with them.",
         ImGuiTableColumnFlags_WidthStretch}};
    if (columns == 4) heads.push_back({"What it is", "By its name and what is in it.", 0, 9.5f});
    heads.push_back({"Size", "Of the file.", 0, 5});
    if (columns == 4) heads.push_back({"Changed", "When it was written last.", 0, 9});
    DrawTableHeads(context, heads, "path.head");
    if (visible_.empty()) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      DimText("%s", !Knows()         ? "reading ..."
                    : typed_.empty() ? "Nothing to choose here."
                                     : "No name begins so.");
    }
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(visible_.size()));
    const float row_height = ImGui::GetTextLineHeight() + 2 * ImGui::GetStyle().CellPadding.y;
    if (std::exchange(scroll_, false) && marked_ >= 0) {
      const float top = row_height * static_cast<float>(marked_);
      const float room = height - 2.5f * row_height;
      if (top < ImGui::GetScrollY()) ImGui::SetScrollY(top);
      if (top > ImGui::GetScrollY() + room) ImGui::SetScrollY(top - room);
    }
    while (is_open() && clipper.Step()) {
      for (int row = clipper.DisplayStart; row < clipper.DisplayEnd && is_open(); ++row) {
        if (row >= static_cast<int>(visible_.size())) break;
        DrawRow(context, row, columns, sink);
      }
    }
    clipper.End();
    ImGui::EndTable();
  }
  ImGui::PopStyleColor();
}

void PathDialog::DrawRow(const FrameContext& context, int row, int columns, CommandSink& sink) {
  // Of a folder that this row may leave.
  const FolderEntry entry =
      view_->entries[static_cast<std::size_t>(visible_[static_cast<std::size_t>(row)])];
  const std::string widget = "path.row." + entry.name;
  const bool openable = !question_->kinds.empty() && Takes(entry.kind);
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::Selectable(
      ("##" + widget).c_str(), row == marked_,
      ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick);
  LogItem(context, widget);
  const float room = ImGui::GetContentRegionAvail().x - context.Scaled(22);
  const bool long_name = ImGui::CalcTextSize(entry.name.c_str()).x > room;
  if (long_name) Tooltip(context, entry.name);
  const bool doubled = clicked && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
  const float line = ImGui::GetTextLineHeight();
  DrawFileIcon(context, {low.x + context.Scaled(2), low.y + 0.5f * (line - context.Scaled(13))},
               entry.is_folder,
               openable && entry.kind != PathKind::kFolder ? colors::kAccent : colors::kFaint);
  ImGui::GetWindowDrawList()->AddText({low.x + context.Scaled(22), low.y}, colors::kText,
                                      entry.name.c_str());
  if (columns == 4) {
    ImGui::TableNextColumn();
    DimText("%s", WordFor(entry.kind));
  }
  ImGui::TableNextColumn();
  if (!entry.is_folder) DimText("%s", SizeText(entry.size_bytes).c_str());
  if (columns == 4) {
    ImGui::TableNextColumn();
    DimText("%s", DateText(entry.changed_s).c_str());
  }
  if (clicked) Mark(row);
  if (doubled) Choose(true, sink);
}

PathDialog::Remark PathDialog::RemarkBelow() const {
  if (!replaces_.empty()) {
    const FolderEntry* old = Knows() ? Find(NameIn(replaces_)) : nullptr;
    const bool file = old != nullptr && !old->is_folder;
    return {
        NameIn(replaces_) + " is there already" +
            (file ? fmt::format(" ({}, {})", SizeText(old->size_bytes), DateText(old->changed_s))
                  : "") +
            ". Replace it?",
        colors::kWarning};
  }
  if (!problem_.empty()) return {problem_, colors::kWarning};
  if (Knows() && !view_->problem.empty()) return {view_->problem, colors::kWarning};
  const std::string words = WordsFor(question_->kinds);
  return {question_->what == PathQuestion::What::kFolder ? "Shown: folders."
          : all_ || words.empty()                        ? "Shown: every file."
                                                         : "Shown: " + words + ".",
          colors::kDimText};
}

void PathDialog::DrawBelow(const FrameContext& context, CommandSink& sink) {
  const Remark remark = RemarkBelow();
  WrappedText(remark.color, remark.text);
  LogItem(context, replaces_.empty() ? "path.remark" : "path.replaces");
  const float button = context.Scaled(96);
  if (!replaces_.empty()) {
    AlignRight(2 * button + context.Scaled(8));
    if (ImGui::Button("Keep it##path.keep", {button, 0})) replaces_.clear();
    LogItem(context, "path.keep");
    ImGui::SameLine(0, context.Scaled(8));
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    const bool replace = ImGui::Button("Replace##path.replace", {button, 0});
    ImGui::PopStyleColor();
    LogItem(context, "path.replace");
    if (replace) Answer(PathOf(NameIn(replaces_)), sink);
    return;
  }
  const auto shown = [&](const char* name, const char* label, bool& value, const char* help) {
    if (Toggle(context, name, label, value, help)) FindVisible();
    ImGui::SameLine(0, context.Scaled(4));
  };
  if (!question_->kinds.empty() && question_->what != PathQuestion::What::kFolder)
    shown("path.all", "All files", all_, "Also what cannot be opened as this.");
  shown("path.hidden", "Hidden", hidden_, "Also names that begin with a dot (Ctrl + H).");
  AlignRight(2 * button + context.Scaled(8));
  if (ImGui::Button("Cancel##path.cancel", {button, 0})) {
    LogItem(context, "path.cancel");
    return Close();
  }
  LogItem(context, "path.cancel");
  ImGui::SameLine(0, context.Scaled(8));
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  const bool chosen = ImGui::Button((question_->button + "##path.choose").c_str(), {button, 0});
  ImGui::PopStyleColor();
  LogItem(context, "path.choose");
  if (chosen) Choose(false, sink);
}

}  // namespace plumbline
