// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/project_state.h"

namespace plumbline {

/// One scan that waits to be annotated, or what somebody made of it.
struct QueueEntry {
  std::string name;  ///< Of the project, or of the scan, within the folder.
  std::string path;  ///< What is to be opened.
  WorkStage stage = WorkStage::kNew;
  std::vector<std::string> annotators;  ///< Of its objects, and who handed it over.
  std::string reviewer, note;
  std::size_t objects = 0;
  double seconds = 0;   ///< That were spent on its objects.
  std::string problem;  ///< Why it cannot be read; "": it can.
};

/// The scans and projects of a folder.
struct AnnotationQueueView {
  std::string folder;
  std::string problem;  ///< Why it cannot be read.
  std::vector<QueueEntry> entries;
  std::optional<std::size_t> open;  ///< The one that is open.
};

}  // namespace plumbline
