// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/annotation/annotation_project.h"
#include "engine/base/result.h"

namespace plumbline {

/// What the Annotate workspace is to open.
struct AnnotationChoice {
  std::filesystem::path path;              ///< A scan, a project (.json), or a folder of them.
  std::filesystem::path models, sequence;  ///< Empty: as the project says, or beside the scan.
  std::string annotator;
  std::filesystem::path queue;  ///< The folder whose scans are annotated one after the other.
};

/// Whether a path is for the Annotate workspace: a mesh or point cloud, or a project's file.
bool IsForAnnotation(const std::filesystem::path& path);

/// Where the project of a scan is kept: SCAN.annotation.json beside it.
std::filesystem::path ProjectFileOf(const std::filesystem::path& scan);

/// The project of a scan, there or in the user's own data folder; empty: nobody has begun it.
std::filesystem::path ExistingProjectOf(const std::filesystem::path& scan);

/// A file as a project names it: relative where that is short, so that the folder can be moved.
std::string NameInProject(const std::filesystem::path& file, const std::filesystem::path& project);

struct OpenedAnnotation {
  std::unique_ptr<AnnotationProject> project;
  std::vector<std::string> notices;  ///< What the user must know: recovered edits, a lock.
  bool read_only = false;
};

/// Opens the project, of a folder the first one that is to be done, or the one beside the scan,
/// which is made if there is none; where the folder cannot be written, it is made in the user's own
/// data folder. A project that another window has open is opened for reading. A new project takes
/// gravity and floor from the sequence, if it knows them. Errors: kNotFound, kCorrupt, kIo,
/// kInvalidInput, naming the file.
Result<OpenedAnnotation> OpenAnnotation(const AnnotationChoice& choice);

}  // namespace plumbline
