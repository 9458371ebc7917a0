// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

constexpr const char* kKinds[] = {"do", "undo", "redo"};

double SecondsNow() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string LineOf(const JournalRecord& record) {
  const nlohmann::json json = {{"kind", kKinds[static_cast<int>(record.kind)]},
                               {"label", record.label},
                               {"time_s", SecondsNow()},
                               {"edit", EditToJson(record.edit)}};
  return json.dump() + "\n";
}

/// Nothing for a line that is no record.
std::optional<JournalRecord> RecordOf(const std::string& line) {
  const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (json.is_discarded() || !json.contains("edit")) return std::nullopt;
  Result<Edit> edit = EditFromJson(json["edit"]);
  if (!edit) return std::nullopt;
  const std::string kind = TextFromJson(json, "kind").value_or("do");
  JournalRecord record{EditKind::kDo, TextFromJson(json, "label").value_or(""), std::move(*edit)};
  if (kind == kKinds[1]) record.kind = EditKind::kUndo;
  if (kind == kKinds[2]) record.kind = EditKind::kRedo;
  return record;
}

Error IoError(const std::filesystem::path& file, int error) {
  return {ErrorCode::kIo, "cannot write the journal '" + file.string() +
                              "': " + std::strerror(error) +
                              "; the work is kept in memory: save it elsewhere"};
}

}  // namespace

Result<JournalContent> ReadJournal(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text) return text.error();
  JournalContent content;
  std::size_t at = 0;
  bool has_header = false;
  for (std::size_t end; (end = text->find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string line = text->substr(at, end - at);
    if (!has_header) {
      const nlohmann::json header = nlohmann::json::parse(line, nullptr, false);
      const auto id = TextFromJson(header, "journal"), base = TextFromJson(header, "base");
      if (!id || !base) break;
      content.id = *id;
      content.base = *base;
      has_header = true;
    } else {
      std::optional<JournalRecord> record = RecordOf(line);
      if (!record) break;
      content.records.push_back(std::move(*record));
    }
    content.good_bytes = end + 1;
  }
  if (!has_header) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is not a journal of edits"};
  }
  return content;
}

AnnotationJournal::~AnnotationJournal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Status AnnotationJournal::Open(const std::filesystem::path& file) {
  if (descriptor_ >= 0) ::close(descriptor_);
  file_ = file;
  descriptor_ = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor_ < 0) return IoError(file, errno);
  return {};
}

Status AnnotationJournal::Begin(const std::filesystem::path& file, const std::string& base) {
  id_ = HashHex(base + std::to_string(::getpid()) + std::to_string(SecondsNow()) +
                std::to_string(reinterpret_cast<std::uintptr_t>(this)));
  waiting_.clear();
  num_written_ = 0;
  bytes_ = 0;
  file_ = file;
  const nlohmann::json json = {{"journal", id_}, {"base", base}};
  const std::string header = json.dump() + "\n";
  if (const Status written = WriteFileAtomically(file, header); !written.ok()) {
    // Everything waits, the header first.
    waiting_.push_back(header);
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
    return written;
  }
  bytes_ = header.size();
  return Open(file);
}

Status AnnotationJournal::Continue(const std::filesystem::path& file,
                                   const JournalContent& content) {
  id_ = content.id;
  bytes_ = content.good_bytes;
  num_written_ = content.records.size();
  waiting_.clear();
  if (const Status opened = Open(file); !opened.ok()) return opened;
  // Cuts off a torn last line, which would spoil what is appended.
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) return IoError(file, errno);
  return {};
}

Status AnnotationJournal::Append(const JournalRecord& record) {
  waiting_.push_back(LineOf(record));
  if (descriptor_ < 0) {
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) return IoError(file_, errno);
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) return IoError(file_, errno);
  }
  while (!waiting_.empty()) {
    const std::string& line = waiting_.front();
    std::size_t done = 0;
    while (done < line.size()) {
      const ssize_t written = ::pwrite(descriptor_, line.data() + done, line.size() - done,
                                       static_cast<off_t>(bytes_ + done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        const int error = written < 0 ? errno : ENOSPC;
        // No half line stays behind; if even that fails, readers stop at it.
        static_cast<void>(!::ftruncate(descriptor_, static_cast<off_t>(bytes_)));
        return IoError(file_, error);
      }
      done += static_cast<std::size_t>(written);
    }
    if (::fdatasync(descriptor_) != 0) return IoError(file_, errno);
    const bool header = bytes_ == 0;
    bytes_ += line.size();
    if (!header) ++num_written_;
    waiting_.erase(waiting_.begin());
  }
  return {};
}

}  // namespace plumbline
