// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/annotation/annotation_project.h"
#include "engine/base/files.h"

namespace plumbline {

Likeness ProbeProject(const std::filesystem::path& path) {
  if (!HasEnding(path, ".json")) return Likeness::kNone;
  const Result<nlohmann::json> json = ReadJson(path);
  const bool says_so =
      json.ok() && json.value().is_object() && json.value().contains("plumbline_annotation");
  return says_so ? Likeness::kCertain : Likeness::kNone;
}

Result<PathInfo> DescribeProject(const std::filesystem::path& path) {
  const auto opened = AnnotationProject::Open(path, AnnotationProject::Access::kRead);
  if (!opened.ok()) return opened.error();
  const AnnotationProject& project = *opened.value();
  const AnnotationDocument& document = project.document();
  PathInfo info;
  info.title = "annotation project";
  const auto fine = std::count_if(document.instances.begin(), document.instances.end(),
                                  [](const AnnotatedInstance& instance) { return instance.fine; });
  info.lines.push_back(
      {"Instances", Format("%zu, %td of them fine", document.instances.size(), fine)});
  info.lines.push_back({"Floor", document.floor_in_scan ? "known" : "not known"});
  info.json["instances"] = document.instances.size();
  info.json["fine"] = fine;
  info.json["crops"] = document.crops.size();
  info.json["floor"] = document.floor_in_scan.has_value();
  struct Part {
    const char* key;
    const char* label;
    const std::string& file;
  };
  for (const Part& part :
       {Part{"scan", "Scan", document.scan}, Part{"models", "Models", document.models},
        Part{"sequence", "Sequence", document.sequence}}) {
    info.json[part.key] = part.file;
    info.lines.push_back({part.label, part.file.empty() ? "none" : part.file});
    std::error_code ignored;
    if (!part.file.empty() && !std::filesystem::exists(project.Resolve(part.file), ignored))
      info.odd.push_back("'" + project.Resolve(part.file).string() + "' is not there any more.");
  }
  if (project.num_recovered() > 0) {
    info.odd.push_back(Counted(project.num_recovered(), "edit is", "edits are") +
                       " only in the journal: open and save the project.");
  }
  info.odd.insert(info.odd.end(), project.warnings().begin(), project.warnings().end());
  return info;
}

}  // namespace plumbline
