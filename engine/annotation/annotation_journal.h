// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/annotation_edit.h"

namespace plumbline {

/// How an edit came about: undoing and redoing are edits, too.
enum class EditKind { kDo, kUndo, kRedo };

struct JournalRecord {
  EditKind kind = EditKind::kDo;
  std::string label;
  Edit edit;
};

/// One line of a journal: an edit, or what is left of one.
struct JournalLine {
  std::size_t number = 0;  ///< Counts the edits of the journal from 1.
  std::string text;
  std::optional<EditKind> kind;         ///< Where at least that can be told.
  std::optional<JournalRecord> record;  ///< Nothing for a line that cannot be read: see `problem`.
  std::string problem;
};

/// What a journal file holds.
struct JournalContent {
  std::string id;    ///< Names this journal; the saved project refers to it.
  std::string base;  ///< Hash of the project file that it begins with.
  std::vector<JournalLine> lines;
  std::uint64_t good_bytes = 0;  ///< What follows was torn by the end of a process.
  bool appendable = true;        ///< Whether a line can follow; not so if the last end is damaged.
};

/// Errors: kNotFound, kIo, kCorrupt (no header).
Result<JournalContent> ReadJournal(const std::filesystem::path& file);

/// Appends edits to a file, each one written through to the disk before Append returns. What cannot
/// be written (a full disk) waits in memory and is tried again with the next.
class AnnotationJournal {
 public:
  AnnotationJournal() = default;
  ~AnnotationJournal();
  AnnotationJournal(const AnnotationJournal&) = delete;
  AnnotationJournal& operator=(const AnnotationJournal&) = delete;

  /// Begins a new file that holds `records`; an older one is replaced in one step. Errors: kIo;
  /// then they and appended records wait.
  Status Begin(const std::filesystem::path& file, const std::string& base,
               const std::vector<JournalRecord>& records = {});
  /// Goes on with a file that was read.
  Status Continue(const std::filesystem::path& file, const JournalContent& content);

  Status Append(const JournalRecord& record);
  /// Forgets the edits that wait: the project was saved with them.
  void DropWaiting() { waiting_.resize(num_waiting_headers()); }

  const std::string& id() const { return id_; }
  /// Records in the file.
  std::size_t num_written() const { return num_written_; }

 private:
  Status Open(const std::filesystem::path& file);
  std::size_t num_waiting_headers() const { return bytes_ == 0 && !waiting_.empty() ? 1 : 0; }

  std::filesystem::path file_;
  std::string id_;
  std::vector<std::string> waiting_;
  std::uint64_t bytes_ = 0;
  std::size_t num_written_ = 0;
  int descriptor_ = -1;
};

}  // namespace plumbline
