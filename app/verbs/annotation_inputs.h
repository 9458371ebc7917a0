// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/annotation/annotation_project.h"
#include "engine/annotation/pose_exchange.h"

namespace plumbline {

/// What a project names, opened; null where it names nothing.
struct OpenedInputs {
  std::shared_ptr<const ModelDatabase> models;
  std::shared_ptr<const Sequence> sequence;

  ExchangeInputs View(std::vector<int> frames) const {
    return {models.get(), sequence.get(), std::move(frames)};
  }
};

Result<OpenedInputs> OpenInputs(const AnnotationProject& project);

/// Opens a project, or with `create` begins one where there is none. Says what was odd about it.
Result<std::unique_ptr<AnnotationProject>> OpenProject(const std::string& file,
                                                       AnnotationProject::Access access,
                                                       bool create = false);

/// Saves and prints a line: "room.json: 3 edits applied, 11 instances".
Status SaveAndSay(AnnotationProject& project, const char* what, std::size_t count);

}  // namespace plumbline
