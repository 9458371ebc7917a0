// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_opening.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/sequence.h"
#include "engine/session/annotation_queue.h"

namespace plumbline {
namespace {

using std::filesystem::path;

constexpr std::array kScanEndings = {".ply", ".pcd", ".obj", ".glb", ".gltf",
                                     ".stl", ".dae", ".fbx", ".off"};

std::string Ending(const path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

path FolderOf(const path& file) {
  std::error_code ignored;
  return std::filesystem::absolute(file, ignored).lexically_normal().parent_path();
}

/// Files that cannot be kept beside the scan.
path DataFolder() {
  const char* data = std::getenv("XDG_DATA_HOME");
  const char* home = std::getenv("HOME");
  const path base = data != nullptr && *data != '\0'   ? path(data)
                    : home != nullptr && *home != '\0' ? path(home) / ".local" / "share"
                                                       : std::filesystem::temp_directory_path();
  return base / "plumbline" / "annotations";
}

/// Where it is kept if it cannot be beside its scan.
path ElsewhereOf(const path& scan) {
  return DataFolder() / (scan.stem().string() + "-" +
                         HashHex(FolderOf(scan).string()).substr(0, 8) + ".annotation.json");
}

std::string Counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

Result<OpenedAnnotation> OpenExisting(const path& file) {
  OpenedAnnotation opened;
  auto project = AnnotationProject::Open(file);
  if (!project) {
    const Error why = project.error();
    project = AnnotationProject::Open(file, AnnotationProject::Access::kRead);
    if (!project) return why;
    opened.read_only = true;
    opened.notices.push_back("Opened for reading only: " + why.message +
                             ". Save as makes a copy that you can edit.");
  }
  opened.project = std::move(*project);
  for (const std::string& warning : opened.project->warnings()) opened.notices.push_back(warning);
  if (const std::size_t count = opened.project->num_recovered(); count > 0) {
    opened.notices.push_back(Counted(count, "edit", "edits") +
                             " recovered that had not been saved. Save keeps them, Undo takes them "
                             "back one by one.");
  }
  return opened;
}

/// Gravity, floor, models: what the sequence knows, if it is in the frame of the scan.
void TakeFromSequence(const path& folder, AnnotationDocument& document) {
  const auto sequence = OpenSequence(folder);
  if (!sequence) return;
  if (const auto gravity = (*sequence)->gravity_in_world()) {
    document.gravity_in_scan = gravity->normalized();
  }
  document.floor_in_scan = (*sequence)->floor_in_world();
}

path IfExists(const path& file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored) ? file : path();
}

/// Whether nobody is meant to write here. An administrator could all the same, and must not: the
/// data is somebody's original.
bool IsMeantReadOnly(const path& folder) {
  using std::filesystem::perms;
  std::error_code error;
  const perms all = std::filesystem::status(folder, error).permissions();
  return !error &&
         (all & (perms::owner_write | perms::group_write | perms::others_write)) == perms::none;
}

Result<OpenedAnnotation> Make(const AnnotationChoice& choice, const path& file) {
  const path folder = FolderOf(choice.path);
  path sequence = choice.sequence, models = choice.models;
  if (sequence.empty() && !IfExists(folder / "camera.json").empty() &&
      !IfExists(folder / "color").empty()) {
    sequence = folder;
  }
  if (models.empty()) models = IfExists(folder / "models").empty() ? path() : folder / "models";
  AnnotationDocument document;
  document.scan = NameInProject(choice.path, file);
  document.models = NameInProject(models, file);
  document.sequence = NameInProject(sequence, file);
  if (!sequence.empty()) TakeFromSequence(sequence, document);
  auto project = AnnotationProject::Create(file, std::move(document));
  if (!project) return project.error();
  OpenedAnnotation opened;
  opened.project = std::move(*project);
  return opened;
}

Status TakeChoices(const AnnotationChoice& choice, OpenedAnnotation& opened) {
  if (opened.read_only) return {};
  const AnnotationDocument& document = opened.project->document();
  const path& file = opened.project->file();
  SetInputs inputs{document.scan, document.models, document.sequence};
  if (!choice.models.empty()) inputs.models = NameInProject(choice.models, file);
  if (!choice.sequence.empty()) inputs.sequence = NameInProject(choice.sequence, file);
  if (inputs.scan.empty() && Ending(choice.path) != ".json") {
    inputs.scan = NameInProject(choice.path, file);
  }
  const bool same = inputs.scan == document.scan && inputs.models == document.models &&
                    inputs.sequence == document.sequence;
  return same ? Status() : opened.project->Apply(inputs);
}

}  // namespace

bool IsForAnnotation(const path& file) {
  const std::string ending = Ending(file);
  if (std::find(kScanEndings.begin(), kScanEndings.end(), ending) != kScanEndings.end())
    return true;
  if (ending != ".json") return false;
  const auto json = ReadJson(file);
  return json.ok() && json->is_object() && json->contains("plumbline_annotation");
}

std::string NameInProject(const path& file, const path& project) {
  if (file.empty()) return "";
  std::error_code error;
  const path absolute = std::filesystem::absolute(file, error).lexically_normal();
  const path relative = absolute.lexically_relative(FolderOf(project));
  const bool near = !relative.empty() && *relative.begin() != "..";
  return near ? relative.string() : absolute.string();
}

path ProjectFileOf(const path& scan) {
  return FolderOf(scan) / (scan.stem().string() + ".annotation.json");
}

path ExistingProjectOf(const path& scan) {
  const path beside = IfExists(ProjectFileOf(scan));
  return beside.empty() ? IfExists(ElsewhereOf(scan)) : beside;
}

Result<OpenedAnnotation> OpenAnnotation(const AnnotationChoice& choice) {
  std::error_code ignored;
  if (std::filesystem::is_directory(choice.path, ignored)) {
    const auto entries = ReadQueue(choice.path);
    if (!entries) return entries.error();
    const auto first = FirstToDo(*entries);
    if (!first) {
      return Error{ErrorCode::kNotFound, "the folder '" + choice.path.string() +
                                             "' holds no scans and no annotation projects"};
    }
    AnnotationChoice chosen = choice;
    chosen.path = (*entries)[*first].path;
    return OpenAnnotation(chosen);
  }
  if (!std::filesystem::exists(choice.path, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no '" + choice.path.string() + "'"};
  }
  if (Ending(choice.path) == ".json") {
    auto opened = OpenExisting(choice.path);
    if (!opened) return opened;
    if (const Status taken = TakeChoices(choice, *opened); !taken.ok()) return taken.error();
    return opened;
  }
  const path beside = ProjectFileOf(choice.path);
  const path elsewhere = ElsewhereOf(choice.path);
  if (const path file = ExistingProjectOf(choice.path); !file.empty()) {
    auto opened = OpenExisting(file);
    if (!opened) return opened;
    if (const Status taken = TakeChoices(choice, *opened); !taken.ok()) return taken.error();
    return opened;
  }
  if (!IsMeantReadOnly(FolderOf(choice.path))) {
    auto made = Make(choice, beside);
    if (made || made.error().code != ErrorCode::kIo) return made;
  }
  std::filesystem::create_directories(elsewhere.parent_path(), ignored);
  auto made = Make(choice, elsewhere);
  if (made) {
    made->notices.push_back("The folder of the scan cannot be written, so the project is kept as " +
                            elsewhere.string() + ". Save as puts it elsewhere.");
  }
  return made;
}

}  // namespace plumbline
