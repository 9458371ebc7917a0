// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_project.h"

#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
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
  auto lock = ProjectLock::Acquire(file);
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
    auto lock = ProjectLock::Acquire(file);
    if (!lock) return lock.error();
    project->lock_ = std::move(*lock);
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

  std::error_code ignored;
  if (std::filesystem::exists(JournalFile(), ignored)) {
    const Result<JournalContent> journal = ReadJournal(JournalFile());
    const nlohmann::json saved = json->value("saved", nlohmann::json::object());
    if (journal.ok() && TextFromJson(saved, "journal") == journal->id) {
      Replay(journal->records, saved.value("records", std::size_t{0}));
    } else if (journal.ok() && journal->base == HashHex(*content)) {
      Replay(journal->records, 0);
    } else if (journal.ok() && journal->records.empty()) {
      // It never held anything.
    } else if (access == Access::kWrite) {
      const path kept = JournalFile().string() + ".kept-" + HashHex(*content).substr(0, 8);
      std::filesystem::rename(JournalFile(), kept, ignored);
      warnings_.push_back("the journal of '" + file_.string() +
                          "' belongs to another version of it; it is kept as '" + kept.string() +
                          "'");
    }
    if (num_recovered_ > 0 && access == Access::kWrite) {
      if (const Status opened = journal_.Continue(JournalFile(), *journal); !opened.ok()) {
        journal_problem_ = opened.error();
      }
      return {};
    }
  }
  if (access == Access::kWrite) {
    if (const Status started = StartJournal(*content); !started.ok()) {
      journal_problem_ = started.error();
    }
  }
  return {};
}

Status AnnotationProject::StartJournal(const std::string& content) {
  return journal_.Begin(JournalFile(), HashHex(content));
}

void AnnotationProject::Replay(const std::vector<JournalRecord>& records, std::size_t first) {
  for (std::size_t i = first; i < records.size(); ++i) {
    const JournalRecord& record = records[i];
    if (const Status done = Do(record.kind, record.edit, record.label); !done.ok()) {
      warnings_.push_back("edit " + std::to_string(i + 1) + " of the journal ('" + record.label +
                          "') could not be repeated: " + done.error().message);
      return;
    }
    ++num_recovered_;
  }
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

/// Changes the document and the stacks, not the journal.
Status AnnotationProject::Do(EditKind kind, const Edit& edit, const std::string& label) {
  Result<Edit> back = ApplyEdit(edit, document_);
  if (!back) return back.error();
  modified_ = true;
  switch (kind) {
    case EditKind::kDo:
      undo_.push_back({std::move(*back), label});
      redo_.clear();
      break;
    case EditKind::kUndo:
      if (!undo_.empty()) undo_.pop_back();  // after a recovery the stack may begin later
      redo_.push_back({std::move(*back), label});
      break;
    case EditKind::kRedo:
      if (!redo_.empty()) redo_.pop_back();
      undo_.push_back({std::move(*back), label});
      break;
  }
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
  Write(EditKind::kUndo, step.edit, step.label);
  return {};
}

Status AnnotationProject::Redo() {
  if (redo_.empty()) return Error{ErrorCode::kInvalidInput, "there is nothing to redo"};
  const Step step = redo_.back();
  if (const Status done = Do(EditKind::kRedo, step.edit, step.label); !done.ok()) return done;
  Write(EditKind::kRedo, step.edit, step.label);
  return {};
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
  return json.dump(1) + "\n";
}

Status AnnotationProject::Save() {
  if (!lock_) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + file_.string() + "' is open for reading only; save it under another name"};
  }
  if (const Status written = WriteFileAtomically(file_, FileContent()); !written.ok()) {
    return written;
  }
  journal_.DropWaiting();
  journal_problem_.reset();
  modified_ = false;
  return {};
}

Status AnnotationProject::SaveAs(const path& file) {
  std::error_code ignored;
  if (lock_ && std::filesystem::equivalent(file, file_, ignored)) return Save();
  auto lock = ProjectLock::Acquire(file);
  if (!lock) return lock.error();
  const path from = std::filesystem::absolute(FolderOf(file_), ignored);
  const path to = std::filesystem::absolute(FolderOf(file), ignored);
  AnnotationDocument moved = document_;
  for (std::string* text : {&moved.scan, &moved.models, &moved.sequence}) {
    *text = Moved(*text, from, to);
  }
  std::swap(moved, document_);
  const std::string content = FileContent();
  if (const Status written = WriteFileAtomically(file, content); !written.ok()) {
    std::swap(moved, document_);
    return written;
  }
  for (std::vector<Step>* steps : {&undo_, &redo_}) {
    for (Step& step : *steps) MoveInputs(step.edit, from, to);
  }
  file_ = file;
  lock_ = std::move(*lock);
  modified_ = false;
  const Status started = StartJournal(content);
  journal_problem_ = started.ok() ? std::nullopt : std::optional(started.error());
  return {};
}

}  // namespace plumbline
