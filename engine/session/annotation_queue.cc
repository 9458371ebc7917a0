// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_queue.h"

#include <algorithm>
#include <array>
#include <set>

#include "engine/annotation/annotation_project.h"
#include "engine/session/annotation_opening.h"

namespace plumbline {
namespace {

using std::filesystem::path;

bool Has(const path& folder, const char* file) {
  std::error_code ignored;
  return std::filesystem::exists(folder / file, ignored);
}

/// Meshes that are no scans: those of a model database and of what was exported.
bool HoldsNoScans(const path& folder) {
  const std::string name = folder.filename().string();
  return name.starts_with(".") || Has(folder, "models.json") || Has(folder, "models_info.json") ||
         Has(folder, "objects.json") || Has(folder, "scene_gt.json") ||
         Has(folder, "fragments/objects.json") || Has(folder, "object_data.yaml") ||
         Has(folder, "full_annotations.json");
}

struct Found {
  std::vector<path> scans, projects;
};

void Look(const path& folder, bool deeper, Found& found) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(
           folder, std::filesystem::directory_options::skip_permission_denied, error)) {
    std::error_code ignored;
    const path file = entry.path();
    if (entry.is_directory(ignored)) {
      if (deeper && !HoldsNoScans(file)) Look(file, false, found);
    } else if (!file.filename().string().starts_with(".") && IsForAnnotation(file)) {
      (file.extension() == ".json" ? found.projects : found.scans).push_back(file);
    }
  }
}

Found Look(const path& folder) {
  Found found;
  const bool deeper = !Has(folder, "camera.json");  // a sequence has thousands of files
  Look(folder, deeper, found);
  std::sort(found.scans.begin(), found.scans.end());
  std::sort(found.projects.begin(), found.projects.end());
  return found;
}

path Canonical(const path& file) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(file, ignored);
}

/// Without a look into any file: the window asks this for whatever is dropped onto it.
bool HoldsScan(const path& folder, bool deeper) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(
           folder, std::filesystem::directory_options::skip_permission_denied, error)) {
    std::error_code ignored;
    const path file = entry.path();
    if (entry.is_directory(ignored)) {
      if (deeper && !HoldsNoScans(file) && HoldsScan(file, false)) return true;
    } else if (file.extension() != ".json" && !file.filename().string().starts_with(".") &&
               IsForAnnotation(file)) {
      return true;
    }
  }
  return false;
}

std::string NameWithin(const path& file, const path& folder) {
  const path relative = Canonical(file).lexically_relative(Canonical(folder));
  const bool within = !relative.empty() && *relative.begin() != "..";
  return within ? relative.string() : file.filename().string();
}

QueueEntry Read(const path& project, const path& folder, std::set<path>& begun) {
  QueueEntry entry;
  entry.name = NameWithin(project, folder);
  entry.path = project.string();
  const auto opened = AnnotationProject::Open(project, AnnotationProject::Access::kRead);
  if (!opened) {
    entry.problem = opened.error().message;
    return entry;
  }
  const AnnotationDocument& document = (*opened)->document();
  if (!document.scan.empty()) begun.insert(Canonical((*opened)->Resolve(document.scan)));
  DescribeWork(document, entry);
  return entry;
}

}  // namespace

void DescribeWork(const AnnotationDocument& document, QueueEntry& entry) {
  entry.stage = document.Stage();
  entry.objects = document.instances.size();
  entry.seconds = 0;
  entry.annotators.clear();
  const auto add = [&](const std::string& name) {
    const auto end = entry.annotators.end();
    if (!name.empty() && std::find(entry.annotators.begin(), end, name) == end)
      entry.annotators.push_back(name);
  };
  for (const AnnotatedInstance& instance : document.instances) {
    entry.seconds += instance.seconds_spent;
    add(instance.annotator);
  }
  const ProjectState state = document.state.value_or(ProjectState());
  add(state.annotator);
  entry.reviewer = state.reviewer;
  entry.note = state.note;
}

Result<std::vector<QueueEntry>> ReadQueue(const path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    return Error{ErrorCode::kNotFound, "there is no folder '" + folder.string() + "'"};
  const std::filesystem::directory_iterator readable(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "cannot read the folder '" + folder.string() + "': " + error.message()};
  }
  const Found found = Look(folder);
  std::vector<QueueEntry> entries;
  std::set<path> begun;
  for (const path& project : found.projects) entries.push_back(Read(project, folder, begun));
  for (const path& scan : found.scans) {
    if (begun.contains(Canonical(scan))) continue;
    const path project = ExistingProjectOf(scan);
    if (std::find(found.projects.begin(), found.projects.end(), project) != found.projects.end())
      continue;              // it is over a copy of this scan
    if (!project.empty()) {  // the folder of the scan cannot be written
      QueueEntry entry = Read(project, folder, begun);
      entry.name = NameWithin(scan, folder);
      entries.push_back(std::move(entry));
      continue;
    }
    QueueEntry entry;
    entry.name = NameWithin(scan, folder);
    entry.path = scan.string();
    entries.push_back(std::move(entry));
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const QueueEntry& a, const QueueEntry& b) { return a.name < b.name; });
  return entries;
}

bool IsQueue(const path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error) || error) return false;
  for (const char* other : {"camera.json", "mav0", "cam0", "models.json"}) {
    if (Has(folder, other)) return false;  // a sequence (EuRoC's may hold a scan), or models
  }
  return HoldsScan(folder, true) || !Look(folder).projects.empty();
}

std::optional<std::size_t> FirstToDo(const std::vector<QueueEntry>& entries) {
  for (const WorkStage stage : {WorkStage::kInWork, WorkStage::kNew, WorkStage::kToReview}) {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (entries[i].problem.empty() && entries[i].stage == stage) return i;
    }
  }
  return entries.empty() ? std::nullopt : std::optional<std::size_t>(0);
}

}  // namespace plumbline
