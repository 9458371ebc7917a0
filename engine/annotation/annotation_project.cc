// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_project.h"

#include <algorithm>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

using std::filesystem::path;

/// A relative path as seen from another folder.
std::string Moved(const std::string& relative, const path& from, const path& to) {
  if (relative.empty() || path(relative).is_absolute()) return relative;
  std::error_code error;
  const path moved = std::filesystem::relative(from / relative, to, error);
  return error || moved.empty() ? (from / relative).string() : moved.string();
}

void MoveInputs(Edit& edit, const path& from, const path& to) {
  if (auto* inputs = std::get_if<SetInputs>(&edit)) {
    for (std::string* text : {&inputs->scan, &inputs->models, &inputs->sequence}) {
      *text = Moved(*text, from, to);
    }
  }
  if (auto* group = std::get_if<EditGroup>(&edit)) {
    for (Edit& inner : group->edits) MoveInputs(inner, from, to);
  }
}

/// Names of the models that an edit would bring in by crops.
void AddCropModels(const Edit& edit, std::set<std::string>& names) {
  if (const auto* add = std::get_if<AddCrop>(&edit); add && add->crop.into == Crop::Into::kModel) {
    names.insert(add->crop.id);
  }
  if (const auto* group = std::get_if<EditGroup>(&edit)) {
    for (const Edit& inner : group->edits) AddCropModels(inner, names);
  }
}

path FolderOf(const path& file) { return file.has_parent_path() ? file.parent_path() : path("."); }

Result<std::unique_ptr<FileLock>> Lock(const path& project) {
  auto lock = FileLock::Acquire(project);
  if (lock.ok()) return lock;
  const bool in_use = lock.error().code == ErrorCode::kInvalidInput;
  return Error{
      lock.error().code,
      lock.error().message + (in_use ? "; close it there, or open it for reading"
                                     : "; open the project for reading, or save it elsewhere")};
}

Error About(const path& file, const Error& error) {
  return {error.code, "'" + file.string() + "' " + error.message};
}

}  // namespace

Result<std::unique_ptr<AnnotationProject>> AnnotationProject::Create(const path& file,
                                                                     AnnotationDocument document) {
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kInvalidInput, "there is a file '" + file.string() +
                                               "' already; open it, or choose another name"};
  }
  auto lock = Lock(file);
  if (!lock) return lock.error();
  std::unique_ptr<AnnotationProject> project(new AnnotationProject(file));
  project->lock_ = std::move(*lock);
  project->document_ = std::move(document);
  const std::string content = project->FileContent();
  if (const Status written = WriteFileAtomically(file, content); !written.ok()) {
    return written.error();
  }
  if (const Status started = project->StartJournal(content); !started.ok()) return started.error();
  return project;
}

Result<std::unique_ptr<AnnotationProject>> AnnotationProject::Open(const path& file,
                                                                   Access access) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no project '" + file.string() + "'"};
  }
  std::unique_ptr<AnnotationProject> project(new AnnotationProject(file));
  if (access == Access::kWrite) {
    auto lock = Lock(file);
    if (!lock) return lock.error();
    project->lock_ = std::move(*lock);
  } else {
    FileLock::RemoveStale(file);
  }
  if (const Status loaded = project->Load(access); !loaded.ok()) return loaded.error();
  return project;
}

Status AnnotationProject::Load(Access access) {
  const Result<std::string> content = ReadFile(file_);
  if (!content) return content.error();
  const Result<nlohmann::json> json = ReadJson(file_);
  if (!json) return json.error();
  Result<AnnotationDocument> document = DocumentFromJson(*json);
  if (!document) return About(file_, document.error());
  document_ = std::move(*document);
  if (access == Access::kWrite) LoadHistory(*content);
  return LoadJournal(*content, json->value("saved", nlohmann::json()), access);
}

/// The one that was written with this content; of another version of the project, it is of no use.
void AnnotationProject::LoadHistory(const std::string& content) {
  for (const path& file : {HistoryFile(), path(HistoryFile().string() + ".new")}) {
    Result<nlohmann::json> json = ReadJson(file);
    if (!json.ok() || TextFromJson(*json, "base") != HashHex(content)) continue;
    const auto check = TextFromJson(*json, "check");
    json->erase("check");
    if (check != HashHex(JsonText(*json))) continue;
    const auto steps_of = [&](const char* key) {
      std::vector<Step> steps;
      for (const nlohmann::json& step : (*json)[key]) {
        Result<Edit> edit = EditFromJson(step.value("edit", nlohmann::json()));
        // The last ones are undone first: one that a newer version wrote hides those before it.
        if (edit.ok())
          steps.push_back({std::move(*edit), TextFromJson(step, "label").value_or("")});
        else
          steps.clear();
      }
      return steps;
    };
    undo_ = steps_of("undo");
    redo_ = steps_of("redo");
    break;
  }
  saved_depth_ = least_depth_ = undo_.size();
}

Status AnnotationProject::WriteProject(const std::string& content) {
  nlohmann::json json = {{"plumbline_undo", 1},
                         {"base", HashHex(content)},
                         {"undo", nlohmann::json::array()},
                         {"redo", nlohmann::json::array()}};
  for (const auto& [key, steps] : {std::pair("undo", &undo_), std::pair("redo", &redo_)}) {
    for (const Step& step : *steps) {
      json[key].push_back({{"label", step.label}, {"edit", EditToJson(step.edit)}});
    }
  }
  json["check"] = HashHex(JsonText(json));
  // The old one stays until the project is replaced: a process may end in between.
  const path next = HistoryFile().string() + ".new";
  const Status kept = WriteFileAtomically(next, JsonText(json) + "\n");
  Status written = WriteFileAtomically(file_, content);
  std::error_code ignored;
  if (!written.ok() && kept.ok()) {
    // Where there is room for one of them, it is the project's.
    std::filesystem::remove(next, ignored);
    return WriteFileAtomically(file_, content);
  }
  if (written.ok() && kept.ok()) std::filesystem::rename(next, HistoryFile(), ignored);
  if (!kept.ok())
    log::warn("undo will not reach behind this save of the project: {}", kept.error().message);
  return written;
}

Status AnnotationProject::LoadJournal(const std::string& content, const nlohmann::json& saved,
                                      Access access) {
  const auto journal = ReadJournal(JournalFile());
  const bool exists = journal.ok() || journal.error().code != ErrorCode::kNotFound;
  const bool continued = journal.ok() && TextFromJson(saved, "journal") == journal->id;
  Replayed replayed;
  bool appendable = false;
  if (continued || (journal.ok() && journal->base == HashHex(content))) {
    const bool counted =
        continued && saved.contains("records") && saved["records"].is_number_unsigned();
    const std::size_t num_saved = counted ? saved["records"].get<std::size_t>() : 0;
    auto repeated = Replay(*journal, num_saved, access);
    if (!repeated) return repeated.error();
    replayed = std::move(*repeated);
    appendable = replayed.lost.empty() && journal->appendable && !replayed.done.empty();
  } else if (exists && !(journal.ok() && journal->lines.empty())) {
    path kept = JournalFile();
    if (access == Access::kWrite) {
      kept += ".kept-" + HashHex(content).substr(0, 8);
      std::error_code ignored;
      std::filesystem::rename(JournalFile(), kept, ignored);
    }
    warnings_.push_back(
        "the journal of '" + file_.string() +
        (journal.ok() ? "' belongs to another version of it" : "' has a damaged first line") +
        "; it is kept as '" + kept.string() + "'");
  }
  if (access == Access::kRead) return {};
  const Status ready = appendable ? journal_.Continue(JournalFile(), *journal)
                                  : StartJournal(content, replayed.done);
  if (!ready.ok()) journal_problem_ = ready.error();
  return {};
}

Status AnnotationProject::StartJournal(const std::string& content,
                                       const std::vector<JournalRecord>& records) {
  return journal_.Begin(JournalFile(), HashHex(content), records);
}

/// Repeats the edits that were not saved, each where it stands on its own. What is lost is in a
/// file of its own before this returns, or the project does not open for writing.
Result<AnnotationProject::Replayed> AnnotationProject::Replay(const JournalContent& journal,
                                                              std::size_t num_saved,
                                                              Access access) {
  Replayed replayed;
  std::size_t num_lost = 0;
  std::string first_problem;
  for (const JournalLine& line : journal.lines) {
    if (line.number <= num_saved) continue;
    left_saved_ = left_saved_ || (line.kind.value_or(EditKind::kDo) == EditKind::kDo &&
                                  undo_.size() < saved_depth_);
    Result<JournalRecord> repeated = Repeat(line);
    least_depth_ = std::min(least_depth_, undo_.size());
    if (repeated) {
      replayed.done.push_back(std::move(*repeated));
      continue;
    }
    if (num_lost++ == 0) {
      first_problem = "edit " + std::to_string(line.number) + ": " + repeated.error().message;
    }
    replayed.lost += line.text + "\n";
  }
  for (std::vector<Step>* steps : {&undo_, &redo_}) {
    std::erase_if(*steps, [](const Step& step) { return step.lost; });
  }
  num_recovered_ = replayed.done.size();
  if (num_lost == 0) return replayed;
  path kept = JournalFile();
  if (access == Access::kWrite) {
    kept += ".unreadable-" + HashHex(replayed.lost).substr(0, 8);
    if (const Status written = WriteFileAtomically(kept, replayed.lost); !written.ok()) {
      return Error{written.error().code,
                   "'" + file_.string() + "' has edits in its journal that cannot be repeated, " +
                       "and they cannot be kept beside it: " + written.error().message};
    }
  }
  warnings_.push_back(std::to_string(num_lost) + " of " +
                      std::to_string(num_lost + num_recovered_) + " unsaved edits of '" +
                      file_.string() + "' could not be repeated and are kept in '" + kept.string() +
                      "' (" + first_problem + ")");
  return replayed;
}

/// Repeats one line of the journal, and says what was done. If that fails, a gap takes the place
/// of the step: what was undone and redone afterwards then still meets its own step.
Result<JournalRecord> AnnotationProject::Repeat(const JournalLine& line) {
  const EditKind kind = line.kind.value_or(EditKind::kDo);
  std::vector<Step>& from = kind == EditKind::kUndo ? undo_ : redo_;
  std::optional<Step> own;  // what is undone or redone, if it was done since the last save
  if (kind != EditKind::kDo && !from.empty() &&
      (!line.record || from.back().lost || from.back().label == line.record->label)) {
    own = std::move(from.back());
    from.pop_back();
  }
  Error problem{ErrorCode::kCorrupt, line.problem};
  std::vector<JournalRecord> ways;
  if (own && own->lost && kind == EditKind::kUndo) {
    problem.message = "it takes back an edit that could not be repeated";
  } else {
    if (line.record) ways.push_back(*line.record);
    if (own && !own->lost) ways.push_back({kind, own->label, own->edit});
  }
  for (JournalRecord& way : ways) {
    const Status done = Do(kind, way.edit, way.label);
    if (done.ok()) return std::move(way);
    problem = done.error();
  }
  if (kind == EditKind::kDo) redo_.clear();
  (kind == EditKind::kUndo ? redo_ : undo_).push_back({.edit = {}, .label = {}, .lost = true});
  return problem;
}

AnnotationProject::~AnnotationProject() {
  if (!lock_ || modified_ || journal_problem_) return;
  std::error_code ignored;
  std::filesystem::remove(JournalFile(), ignored);
}

std::filesystem::path AnnotationProject::Resolve(const std::string& relative) const {
  if (relative.empty()) return {};
  return path(relative).is_absolute() ? path(relative) : FolderOf(file_) / relative;
}

/// Changes the document and remembers the way back. What was undone or redone stays on its stack,
/// and the journal is not told.
Status AnnotationProject::Do(EditKind kind, const Edit& edit, const std::string& label) {
  ++revision_;
  Result<Edit> back = ApplyEdit(edit, document_);
  if (!back) return back.error();
  modified_ = true;
  if (kind == EditKind::kDo) redo_.clear();
  (kind == EditKind::kUndo ? redo_ : undo_).push_back({std::move(*back), label});
  return {};
}

void AnnotationProject::Write(EditKind kind, const Edit& edit, const std::string& label) {
  const Status written = journal_.Append({kind, label, edit});
  journal_problem_ = written.ok() ? std::nullopt : std::optional(written.error());
}

Status AnnotationProject::Apply(const Edit& edit) {
  if (!lock_) {
    return Error{ErrorCode::kInvalidInput, "'" + file_.string() + "' is open for reading only"};
  }
  const std::string label = DescribeEdit(edit);
  if (const Status done = Do(EditKind::kDo, edit, label); !done.ok()) return done;
  Write(EditKind::kDo, edit, label);
  return {};
}

Status AnnotationProject::Undo() {
  if (undo_.empty()) return Error{ErrorCode::kInvalidInput, "there is nothing to undo"};
  const Step step = undo_.back();
  if (const Status done = Do(EditKind::kUndo, step.edit, step.label); !done.ok()) return done;
  undo_.pop_back();
  Write(EditKind::kUndo, step.edit, step.label);
  return {};
}

Status AnnotationProject::Redo() {
  if (redo_.empty()) return Error{ErrorCode::kInvalidInput, "there is nothing to redo"};
  const Step step = redo_.back();
  if (const Status done = Do(EditKind::kRedo, step.edit, step.label); !done.ok()) return done;
  redo_.pop_back();
  Write(EditKind::kRedo, step.edit, step.label);
  return {};
}

Result<bool> AnnotationProject::UndoRecovered() {
  while (undo_.size() > least_depth_) {
    if (const Status done = Undo(); !done.ok()) return done.error();
  }
  while (!left_saved_ && undo_.size() < saved_depth_ && !redo_.empty()) {
    if (const Status done = Redo(); !done.ok()) return done.error();
  }
  return undo_.size() == saved_depth_ && !left_saved_;
}

std::optional<std::string> AnnotationProject::UndoLabel() const {
  return undo_.empty() ? std::nullopt : std::optional(undo_.back().label);
}

std::optional<std::string> AnnotationProject::RedoLabel() const {
  return redo_.empty() ? std::nullopt : std::optional(redo_.back().label);
}

std::vector<std::string> AnnotationProject::ForgottenModels() const {
  std::set<std::string> names;
  for (const std::vector<Step>* steps : {&undo_, &redo_}) {
    for (const Step& step : *steps) AddCropModels(step.edit, names);
  }
  for (const Crop& crop : document_.crops) names.erase(crop.id);
  return {names.begin(), names.end()};
}

std::string AnnotationProject::FileContent() const {
  nlohmann::json json = DocumentToJson(document_);
  json["saved"] = {{"journal", journal_.id()}, {"records", journal_.num_written()}};
  return JsonText(json, 1) + "\n";
}

Status AnnotationProject::Save() {
  if (!lock_) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + file_.string() + "' is open for reading only; save it under another name"};
  }
  if (const Status written = WriteProject(FileContent()); !written.ok()) return written;
  journal_.DropWaiting();
  journal_problem_.reset();
  modified_ = false;
  return {};
}

Status AnnotationProject::SaveAs(const path& file) {
  std::error_code ignored;
  if (lock_ && std::filesystem::equivalent(file, file_, ignored)) return Save();
  auto lock = Lock(file);
  if (!lock) return lock.error();
  const path from = std::filesystem::absolute(FolderOf(file_), ignored);
  const path to = std::filesystem::absolute(FolderOf(file), ignored);
  AnnotationDocument moved = document_;
  for (std::string* text : {&moved.scan, &moved.models, &moved.sequence}) {
    *text = Moved(*text, from, to);
  }
  std::swap(moved, document_);
  const std::string content = FileContent();
  const path before = std::exchange(file_, file);
  const auto move_steps = [&](const path& old_folder, const path& new_folder) {
    for (std::vector<Step>* steps : {&undo_, &redo_}) {
      for (Step& step : *steps) MoveInputs(step.edit, old_folder, new_folder);
    }
  };
  move_steps(from, to);
  if (const Status written = WriteProject(content); !written.ok()) {
    move_steps(to, from);
    file_ = before;
    std::swap(moved, document_);
    return written;
  }
  lock_ = std::move(*lock);
  modified_ = false;
  const Status started = StartJournal(content);
  journal_problem_ = started.ok() ? std::nullopt : std::optional(started.error());
  return {};
}

}  // namespace plumbline
