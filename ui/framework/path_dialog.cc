// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/path_dialog.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <utility>

#include "ui/framework/actions.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr const char* kPathPopup = "path_dialog";
constexpr double kDialogWidth = 860, kDialogHeight = 560, kPlacesWidth = 176;
constexpr double kRoomForPlaces = 560, kRoomForColumns = 540;  ///< Of the dialog; of the list.
constexpr std::size_t kMostPlaces = 8;
constexpr double kLettersBelongTogether_s = 1;

std::string InLowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Without "." and "..", and without a slash at its end.
std::string Normal(const std::string& path) {
  std::string normal = std::filesystem::path(path).lexically_normal().string();
  while (normal.size() > 1 && normal.back() == '/') normal.pop_back();
  return normal;
}

std::string ParentOf(const std::string& path) {
  return std::filesystem::path(path).parent_path().string();
}

std::string NameIn(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return name.empty() ? path : name;
}

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

void PathDialog::Ask(PathQuestion question) {
  const std::string at = question.at;
  question_ = std::move(question);
  all_ = hidden_ = decides_ = typing_ = false;
  view_.reset();
  problem_.clear();
  replaces_.clear();
  letters_.clear();
  fresh_ = true;
  const bool saves = question_->what == PathQuestion::What::kSave;
  focus_ = selects_name_ = saves;
  continues_ = false;
  std::string from = at;
  if (!from.empty() && from.front() != '/') from = working_ + "/" + from;
  const std::string usual = places_.empty() ? working_ : places_.front();
  if (from.empty()) return Show(usual, "");
  if (from.back() == '/') return Show(Normal(from), "");
  from = Normal(from);
  Show(ParentOf(from), NameIn(from));
}

std::optional<std::string> PathDialog::TakeWanted() { return std::exchange(wanted_, std::nullopt); }

void PathDialog::Take(std::shared_ptr<const FolderView> view) {
  if (!is_open() || view == nullptr || view == view_ || view->folder != folder_) return;
  view_ = std::move(view);
  FindVisible();
}

bool PathDialog::Takes(PathKind kind) const {
  const auto& kinds = question_->kinds;
  return kinds.empty() || std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

std::string PathDialog::PathOf(const std::string& name) const {
  return (folder_ == "/" ? "/" : folder_ + "/") + name;
}

std::string PathDialog::NameOfField() const {
  const std::string text = field_;
  return text.substr(text.rfind('/') + 1);  // all of it where there is none
}

void PathDialog::SetField(const std::string& text) {
  std::snprintf(field_, sizeof(field_), "%s", text.c_str());
  new_text_ = text;
}

void PathDialog::Show(const std::string& folder, const std::string& name) {
  if (folder_ != folder || view_ == nullptr) wanted_ = folder;
  folder_ = base_ = folder;
  typed_.clear();
  wanted_name_ = name;
  marked_ = -1;
  problem_.clear();
  replaces_.clear();
  SetField(PathOf(name));
  FindVisible();
}

void PathDialog::GoUp() {
  const bool saves = question_->what == PathQuestion::What::kSave;
  const std::string left = NameIn(folder_);
  const std::string name = saves ? NameOfField() : left;
  if (folder_ == "/") return;
  Show(ParentOf(folder_), name);
  if (!saves) SetField(PathOf(""));
}

void PathDialog::FieldChanged() {
  problem_.clear();
  replaces_.clear();
  std::string text = field_;
  if (text.starts_with("~")) text = home_ + text.substr(1);
  if (!text.starts_with("/")) text = base_ + "/" + text;
  const std::size_t slash = text.rfind('/');
  const std::string folder = Normal(text.substr(0, slash + 1));
  if (folder != folder_) wanted_ = folder;
  folder_ = folder;
  typed_ = text.substr(slash + 1);
  wanted_name_ = typed_;
  FindVisible();
}

void PathDialog::FindVisible() {
  visible_.clear();
  marked_ = -1;
  if (!Knows()) return;
  const std::string typed = InLowerCase(typed_);
  const bool filters = question_->what != PathQuestion::What::kSave && !typed.empty();
  for (std::size_t i = 0; i < view_->entries.size(); ++i) {
    const FolderEntry& entry = view_->entries[i];
    if (entry.name.starts_with(".") && !hidden_ && !typed.starts_with(".")) continue;
    if (!entry.is_folder &&
        (question_->what == PathQuestion::What::kFolder || (!all_ && !Takes(entry.kind))))
      continue;
    if (filters && !InLowerCase(entry.name).starts_with(typed)) continue;
    if (entry.name == wanted_name_) marked_ = static_cast<int>(visible_.size());
    visible_.push_back(static_cast<int>(i));
  }
  const bool begins = filters && marked_ < 0 && !visible_.empty();
  if (begins) marked_ = 0;
  scroll_ = true;
}

void PathDialog::Mark(int row) {
  if (visible_.empty()) return;
  marked_ = std::clamp(row, 0, static_cast<int>(visible_.size()) - 1);
  scroll_ = true;
  problem_.clear();
  replaces_.clear();
  const FolderEntry& entry = *Marked();
  const bool keeps_name = question_->what == PathQuestion::What::kSave && entry.is_folder;
  if (!keeps_name) SetField(PathOf(entry.name));
}

const FolderEntry* PathDialog::Marked() const {
  if (!Knows() || marked_ < 0 || marked_ >= static_cast<int>(visible_.size())) return nullptr;
  return &view_->entries[static_cast<std::size_t>(visible_[static_cast<std::size_t>(marked_)])];
}

const FolderEntry* PathDialog::Find(const std::string& name) const {
  const auto found = std::find_if(view_->entries.begin(), view_->entries.end(),
                                  [&](const FolderEntry& entry) { return entry.name == name; });
  return found == view_->entries.end() ? nullptr : &*found;
}

void PathDialog::Complete() {
  if (!Knows()) return;
  const std::string typed = InLowerCase(typed_);
  std::string common;
  int fitting = 0;
  const FolderEntry* last = nullptr;
  for (const FolderEntry& entry : view_->entries) {
    if (entry.name.starts_with(".") && !hidden_ && !typed.starts_with(".")) continue;
    if (!InLowerCase(entry.name).starts_with(typed)) continue;
    last = &entry;
    if (fitting++ == 0) common = entry.name;
    std::size_t same = 0;
    while (same < std::min(common.size(), entry.name.size()) && common[same] == entry.name[same])
      ++same;
    common.resize(same);
  }
  if (fitting == 0) return;
  if (fitting > 1 && common.size() < typed_.size()) return;
  SetField(PathOf(fitting == 1 ? last->name + (last->is_folder ? "/" : "") : common));
  FieldChanged();
}

void PathDialog::Choose(bool from_list, CommandSink& sink) {
  const FolderEntry* marked = Marked();
  if (from_list && marked != nullptr) {
    const bool answers = marked->is_folder ? question_->what == PathQuestion::What::kOpen &&
                                                 marked->kind != PathKind::kFolder &&
                                                 Takes(marked->kind) && !question_->kinds.empty()
                                           : true;
    if (!answers) {
      const bool saves = question_->what == PathQuestion::What::kSave;
      return Show(PathOf(marked->name), saves ? NameOfField() : "");
    }
    SetField(PathOf(marked->name));
  }
  FieldChanged();
  decides_ = true;
  if (Knows()) Decide(sink);
}

void PathDialog::Decide(CommandSink& sink) {
  using What = PathQuestion::What;
  decides_ = false;
  if (!view_->problem.empty()) return;  // which is said below
  const bool any_folder = question_->what == What::kFolder;
  if (typed_.empty()) {
    if (any_folder) return Answer(folder_, sink);
    problem_ = question_->what == What::kSave ? "Type a name, too." : "Choose what to open.";
    return;
  }
  std::string name = typed_;
  const FolderEntry* entry = Find(name);
  if (question_->what == What::kSave) {
    if (entry != nullptr && entry->is_folder && !question_->may_replace)
      return Show(PathOf(name), "");
    if (!question_->ending.empty() && std::filesystem::path(name).extension().empty())
      name += question_->ending;
    entry = Find(name);
    if (entry != nullptr && !question_->may_replace && replaces_ != PathOf(name)) {
      replaces_ = PathOf(name);
      return;
    }
    return Answer(PathOf(name), sink);
  }
  if (entry == nullptr && visible_.size() == 1) {  // the only one that begins so
    entry = &view_->entries[static_cast<std::size_t>(visible_.front())];
    name = entry->name;
  }
  if (entry == nullptr) {
    problem_ = "There is no " + name + " in this folder.";
  } else if (!entry->is_folder) {
    if (question_->what == What::kFolder)
      problem_ = name + " is no folder.";
    else
      Answer(PathOf(name), sink);
  } else if (any_folder || (!question_->kinds.empty() && Takes(entry->kind))) {
    Answer(PathOf(name), sink);
  } else {
    Show(PathOf(name), "");
  }
}

void PathDialog::Answer(const std::string& path, CommandSink& sink) {
  const std::string place = question_->what == PathQuestion::What::kFolder ? path : ParentOf(path);
  std::erase(places_, place);
  places_.insert(places_.begin(), place);
  if (places_.size() > kMostPlaces) places_.resize(kMostPlaces);
  const auto answer = std::move(question_->answer);
  question_.reset();
  answer(path, sink);
}

void PathDialog::Close() {
  const auto gave_up = std::move(question_->gave_up);
  question_.reset();
  if (gave_up) gave_up();
}

void PathDialog::JumpTo(const std::string& letters) {
  const double now_s = ImGui::GetTime();
  if (now_s - letters_s_ > kLettersBelongTogether_s) letters_.clear();
  letters_s_ = now_s;
  letters_ += InLowerCase(letters);
  const auto count = static_cast<int>(visible_.size());
  // One letter again and again walks through the names that begin with it.
  const bool walks =
      letters_.size() > 1 && letters_.find_first_not_of(letters_[0]) == std::string::npos;
  const std::string start = walks ? letters_.substr(0, 1) : letters_;
  const int first = walks || letters_.size() == 1 ? marked_ + 1 : std::max(0, marked_);
  for (int i = 0; i < count; ++i) {
    const int row = (first + i) % count;
    const auto index = static_cast<std::size_t>(visible_[static_cast<std::size_t>(row)]);
    if (InLowerCase(view_->entries[index].name).starts_with(start)) return Mark(row);
  }
}

void PathDialog::TakeKeys(CommandSink& sink) {
  const ImGuiIO& io = ImGui::GetIO();
  // As it goes up, which would close the sheet that comes back.
  if (ImGui::IsKeyReleased(keys::kEscape)) {
    if (replaces_.empty()) return Close();
    replaces_.clear();
    return;
  }
  if (ImGui::IsKeyPressed(keys::kDown)) Mark(marked_ + 1);
  if (ImGui::IsKeyPressed(keys::kUp)) Mark(marked_ < 0 ? 0 : marked_ - 1);
  constexpr int kPage = 10;
  if (ImGui::IsKeyPressed(keys::kPageDown)) Mark(marked_ + kPage);
  if (ImGui::IsKeyPressed(keys::kPageUp)) Mark(marked_ - kPage);
  if (typing_) return;
  if (ImGui::IsKeyPressed(keys::kEnter, false) || ImGui::IsKeyPressed(keys::kPadEnter, false))
    return Choose(replaces_.empty(), sink);
  if (ImGui::IsKeyPressed(keys::kHome)) Mark(0);
  if (ImGui::IsKeyPressed(keys::kEnd)) Mark(static_cast<int>(visible_.size()) - 1);
  if (ImGui::IsKeyPressed(keys::kBackspace) || ImGui::IsKeyPressed(keys::kLeft)) GoUp();
  if (ImGui::IsKeyPressed(keys::kRight) && Marked() != nullptr && Marked()->is_folder)
    Show(PathOf(Marked()->name), question_->what == PathQuestion::What::kSave ? NameOfField() : "");
  if (io.KeyCtrl && ImGui::IsKeyPressed(keys::kH, false)) {
    hidden_ = !hidden_;
    FindVisible();
  }
  if ((io.KeyCtrl && ImGui::IsKeyPressed(keys::kL, false)) ||
      ImGui::IsKeyPressed(keys::kTab, false))
    focus_ = true;
  if (io.KeyCtrl || io.KeyAlt) return;
  std::string letters;
  for (const ImWchar c : io.InputQueueCharacters) {
    if (c > ' ' && c < 0x7F) letters += static_cast<char>(c);
  }
  if (letters.starts_with('/') || letters.starts_with('~')) {
    focus_ = continues_ = true;
    SetField(letters);
    FieldChanged();
  } else if (!letters.empty()) {
    JumpTo(letters);
  }
}

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

void AskPath(const FrameContext& context, PathQuestion question) {
  if (context.path_dialog != nullptr) context.path_dialog->Ask(std::move(question));
}

bool AsksForPath(const FrameContext& context) {
  return context.path_dialog != nullptr && context.path_dialog->is_open();
}

void BrowseButton(const FrameContext& context, const std::string& name,
                  const std::function<PathQuestion()>& question) {
  ImGui::SameLine(0, context.Scaled(4));
  if (Button(context, name, "\u2026", "Choose it from a list of folders and files."))
    AskPath(context, question());
}

float BrowseWidth(const FrameContext& context) {
  return ImGui::CalcTextSize("\u2026").x + 2 * ImGui::GetStyle().FramePadding.x + context.Scaled(4);
}

}  // namespace plumbline
