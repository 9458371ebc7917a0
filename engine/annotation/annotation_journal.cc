// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <iterator>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

constexpr const char* kKinds[] = {"do", "undo", "redo"};

double SecondsNow() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// The line of an edit, with a hash of all the rest of it.
std::string LineOf(const JournalRecord& record, std::size_t number) {
  nlohmann::json json = {{"number", number},
                         {"kind", kKinds[static_cast<int>(record.kind)]},
                         {"label", record.label},
                         {"time_s", SecondsNow()},
                         {"edit", EditToJson(record.edit)}};
  json["check"] = HashHex(JsonText(json));
  return JsonText(json) + "\n";
}

/// Also of a line that is damaged elsewhere.
std::optional<EditKind> KindIn(const std::string& line) {
  std::optional<EditKind> kind;
  for (std::size_t i = 0; i < std::size(kKinds); ++i) {
    if (line.find("\"kind\":\"" + std::string(kKinds[i]) + "\"") != std::string::npos)
      kind = static_cast<EditKind>(i);
  }
  return kind;
}

/// @param number  Of a line that does not say it (of an older version, or damaged).
JournalLine ReadLine(std::string text, std::size_t number) {
  JournalLine line{.number = number, .text = std::move(text)};
  nlohmann::json json = ParseJson(line.text);
  line.kind = KindIn(line.text);
  if (!json.is_object()) {
    line.problem = "it is damaged";
    return line;
  }
  if (const auto check = TextFromJson(json, "check")) {
    json.erase("check");
    if (*check != HashHex(JsonText(json))) {
      line.problem = "it is damaged";
      return line;
    }
  }
  if (json.contains("number") && json["number"].is_number_unsigned()) line.number = json["number"];
  const std::string kind = TextFromJson(json, "kind").value_or(kKinds[0]);
  const auto known = std::find(std::begin(kKinds), std::end(kKinds), kind);
  if (known == std::end(kKinds)) {
    line.problem = "its kind '" + kind + "' is not known to this version";
    return line;
  }
  line.kind = static_cast<EditKind>(known - std::begin(kKinds));
  Result<Edit> edit = EditFromJson(json.value("edit", nlohmann::json()));
  if (!edit) {
    line.problem = edit.error().message;
    return line;
  }
  line.record = {*line.kind, TextFromJson(json, "label").value_or(""), std::move(*edit)};
  return line;
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
  std::size_t at = text->find('\n');
  const nlohmann::json header = ParseJson(std::string_view(*text).substr(0, at));
  const auto id = TextFromJson(header, "journal"), base = TextFromJson(header, "base");
  if (at == std::string::npos || !id || !base) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is not a journal of edits"};
  }
  content.id = *id;
  content.base = *base;
  content.good_bytes = ++at;
  const auto next = [&] { return content.lines.empty() ? 1 : content.lines.back().number + 1; };
  for (std::size_t end; (end = text->find('\n', at)) != std::string::npos; at = end + 1) {
    content.lines.push_back(ReadLine(text->substr(at, end - at), next()));
    content.good_bytes = end + 1;
  }
  // The rest is torn, unless only its end of line is damaged.
  const std::size_t last = text->find_last_of('}');
  if (last != std::string::npos && last >= at) {
    JournalLine line = ReadLine(text->substr(at, last + 1 - at), next());
    content.appendable = !line.record;
    if (line.record) content.lines.push_back(std::move(line));
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

Status AnnotationJournal::Begin(const std::filesystem::path& file, const std::string& base,
                                const std::vector<JournalRecord>& records) {
  id_ = HashHex(base + std::to_string(::getpid()) + std::to_string(SecondsNow()) +
                std::to_string(reinterpret_cast<std::uintptr_t>(this)));
  num_written_ = 0;
  bytes_ = 0;
  file_ = file;
  const nlohmann::json json = {{"journal", id_}, {"base", base}};
  waiting_ = {JsonText(json) + "\n"};
  for (const JournalRecord& record : records) waiting_.push_back(LineOf(record, waiting_.size()));
  std::string text;
  for (const std::string& line : waiting_) text += line;
  if (const Status written = WriteFileAtomically(file, text); !written.ok()) {
    // Everything waits, the header first.
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
    return written;
  }
  bytes_ = text.size();
  num_written_ = records.size();
  waiting_.clear();
  return Open(file);
}

Status AnnotationJournal::Continue(const std::filesystem::path& file,
                                   const JournalContent& content) {
  id_ = content.id;
  bytes_ = content.good_bytes;
  num_written_ = content.lines.empty() ? 0 : content.lines.back().number;
  waiting_.clear();
  if (const Status opened = Open(file); !opened.ok()) return opened;
  // Cuts off a torn last line, which would spoil what is appended.
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) return IoError(file, errno);
  return {};
}

Status AnnotationJournal::Append(const JournalRecord& record) {
  const std::size_t waiting_edits = waiting_.size() - num_waiting_headers();
  waiting_.push_back(LineOf(record, num_written_ + waiting_edits + 1));
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
