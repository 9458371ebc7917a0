// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/annotation_edit.h"
#include "engine/annotation/annotation_journal.h"
#include "engine/base/file_lock.h"

namespace plumbline {

/// An annotation document in a file, with everything that keeps work from being lost: each edit is
/// in the journal beside the file (FILE.journal) before `Apply` returns, saving is atomic, a
/// project whose process was killed opens with all its edits, edits that cannot be read or repeated
/// are kept beside it (FILE.journal.unreadable-*), what can be undone and redone is kept with what
/// is saved (FILE.undo), and only one process at a time may change it (FILE.lock). Not thread-safe.
class AnnotationProject {
 public:
  enum class Access { kWrite, kRead };

  /// Errors: kInvalidInput (the file exists, or is open elsewhere), kIo.
  static Result<std::unique_ptr<AnnotationProject>> Create(const std::filesystem::path& file,
                                                           AnnotationDocument document);
  /// Errors: kNotFound, kIo, kCorrupt, kUnsupported, kInvalidInput (what is wrong in the file, or
  /// who has it open).
  static Result<std::unique_ptr<AnnotationProject>> Open(const std::filesystem::path& file,
                                                         Access access = Access::kWrite);
  /// Deletes the journal if nothing is left to save.
  ~AnnotationProject();

  const std::filesystem::path& file() const { return file_; }
  const AnnotationDocument& document() const { return document_; }
  /// A path of the document as the file system knows it; empty for "".
  std::filesystem::path Resolve(const std::string& path) const;

  /// Errors: as of ApplyEdit, and kInvalidInput for a project opened for reading; the document is
  /// then unchanged. A journal that cannot be written is no error: see `journal_problem`.
  Status Apply(const Edit& edit);
  /// Errors: kInvalidInput when there is nothing to undo or redo.
  Status Undo();
  Status Redo();
  /// What would be undone or redone, as a menu says it.
  std::optional<std::string> UndoLabel() const;
  std::optional<std::string> RedoLabel() const;
  /// Names of models whose crops undo or redo would bring back.
  std::vector<std::string> ForgottenModels() const;

  /// Undoes what the last process had not saved; redo restores it. False if some of it has to
  /// stay: it undid what was saved and went on from there.
  Result<bool> UndoRecovered();

  /// Errors: kIo; nothing is lost by it.
  Status Save();
  /// Goes on in another file, which is overwritten; relative paths are made to fit.
  Status SaveAs(const std::filesystem::path& file);
  bool modified() const { return modified_; }
  /// Changes with the document.
  std::uint64_t revision() const { return revision_; }

  /// Why edits are not safe on the disk at the moment, if so: it is full or read-only.
  const std::optional<Error>& journal_problem() const { return journal_problem_; }
  /// Edits that the last process did not save and that were taken from the journal.
  std::size_t num_recovered() const { return num_recovered_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  struct Step {
    Edit edit;
    std::string label;
    bool lost = false;  ///< A gap in place of an edit of the journal that could not be repeated.
  };
  struct Replayed {
    std::vector<JournalRecord> done;
    std::string lost;  ///< Lines of the journal.
  };

  explicit AnnotationProject(std::filesystem::path file) : file_(std::move(file)) {}
  Status Load(Access access);
  Status LoadJournal(const std::string& content, const nlohmann::json& saved, Access access);
  Status StartJournal(const std::string& content, const std::vector<JournalRecord>& records = {});
  Result<Replayed> Replay(const JournalContent& journal, std::size_t num_saved, Access access);
  Result<JournalRecord> Repeat(const JournalLine& line);
  Status Do(EditKind kind, const Edit& edit, const std::string& label);
  void Write(EditKind kind, const Edit& edit, const std::string& label);
  std::filesystem::path JournalFile() const { return file_.string() + ".journal"; }
  std::filesystem::path HistoryFile() const { return file_.string() + ".undo"; }
  std::string FileContent() const;
  /// Writes the project's file, with what can be undone and redone beside it.
  Status WriteProject(const std::string& content);
  void LoadHistory(const std::string& content);

  std::filesystem::path file_;
  std::unique_ptr<FileLock> lock_;
  AnnotationDocument document_;
  AnnotationJournal journal_;
  std::optional<Error> journal_problem_;
  std::vector<Step> undo_, redo_;
  std::vector<std::string> warnings_;
  std::size_t num_recovered_ = 0;
  // Steps that can be undone: as it was saved, and the fewest while edits were repeated.
  std::size_t saved_depth_ = 0, least_depth_ = 0;
  bool left_saved_ = false;  ///< What was repeated undid saved steps and went another way.
  bool modified_ = false;
  std::uint64_t revision_ = 1;
};

}  // namespace plumbline
