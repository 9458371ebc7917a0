// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/path_dialog.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "ui/framework/actions.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

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

std::string PathDialog::NameIn(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return name.empty() ? path : name;
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
