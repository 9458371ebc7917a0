// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_queue.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "app/verbs/verb.h"
#include "engine/session/annotation_queue.h"

namespace plumbline {
namespace {

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

nlohmann::json ToJson(const QueueEntry& entry) {
  return {{"name", entry.name},           {"path", entry.path},
          {"state", NameOf(entry.stage)}, {"annotators", entry.annotators},
          {"reviewer", entry.reviewer},   {"note", entry.note},
          {"objects", entry.objects},     {"seconds", entry.seconds},
          {"problem", entry.problem}};
}

void Print(const std::vector<QueueEntry>& entries) {
  int width = 4;
  for (const QueueEntry& entry : entries)
    width = std::max(width, static_cast<int>(entry.name.size()));
  std::printf("%-*s  %-9s %7s %7s  %s\n", width, "scan", "state", "objects", "minutes", "who");
  for (const QueueEntry& entry : entries) {
    if (!entry.problem.empty()) {
      std::printf("%-*s  %s\n", width, entry.name.c_str(), entry.problem.c_str());
      continue;
    }
    const char* judged = entry.stage == WorkStage::kDone ? "; reviewed by " : "; sent back by ";
    std::printf("%-*s  %-9s %7zu %7.1f  %s%s%s%s\n", width, entry.name.c_str(),
                std::string(NameOf(entry.stage)).c_str(), entry.objects, entry.seconds / 60,
                Joined(entry.annotators).c_str(), entry.reviewer.empty() ? "" : judged,
                entry.reviewer.c_str(), entry.note.empty() ? "" : (": " + entry.note).c_str());
  }
}

}  // namespace

Status ShowQueue(const std::string& folder, const std::string& json_file) {
  const auto entries = ReadQueue(folder);
  if (!entries) return entries.error();
  if (json_file != "-") Print(*entries);
  if (json_file.empty()) return {};
  nlohmann::json json = nlohmann::json::array();
  for (const QueueEntry& entry : *entries) json.push_back(ToJson(entry));
  return WriteJsonResult(json_file, json);
}

}  // namespace plumbline
