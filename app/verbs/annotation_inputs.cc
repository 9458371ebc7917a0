// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotation_inputs.h"

#include <cstdio>

#include "app/verbs/verb.h"
#include "engine/base/log.h"

namespace plumbline {

Result<OpenedInputs> OpenInputs(const AnnotationProject& project) {
  OpenedInputs opened;
  const AnnotationDocument& document = project.document();
  if (!document.models.empty()) {
    auto models = ModelDatabase::Load(project.Resolve(document.models));
    if (!models) return models.error();
    opened.models = std::move(*models);
  }
  if (!document.sequence.empty()) {
    auto sequence = OpenSequence(project.Resolve(document.sequence));
    if (!sequence) return sequence.error();
    opened.sequence = std::move(*sequence);
  }
  return opened;
}

Result<std::unique_ptr<AnnotationProject>> OpenProject(const std::string& file,
                                                       AnnotationProject::Access access,
                                                       bool create) {
  std::error_code ignored;
  if (create && !std::filesystem::exists(file, ignored)) {
    return AnnotationProject::Create(file, {});
  }
  auto project = AnnotationProject::Open(file, access);
  if (!project) return project.error();
  Warn((*project)->warnings());
  if ((*project)->num_recovered() > 0) {
    log::info("{}: took {} unsaved edits from the journal", file, (*project)->num_recovered());
  }
  return project;
}

Status SaveAndSay(AnnotationProject& project, const char* what, std::size_t count) {
  if (const Status saved = project.Save(); !saved.ok()) return saved;
  std::printf("%s: %zu %s, %zu instances\n", project.file().c_str(), count, what,
              project.document().instances.size());
  return {};
}

}  // namespace plumbline
