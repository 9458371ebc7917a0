// SPDX-License-Identifier: Apache-2.0
#include "engine/session/run_drafts.h"

#include "engine/annotation/annotation_check.h"
#include "engine/recording/run_summary.h"

namespace plumbline {

Result<std::vector<AnnotatedInstance>> DraftsOfRun(const AnnotationDocument& document,
                                                   const std::filesystem::path& run) {
  const auto estimates = ReadEstimates(run);
  if (!estimates) return estimates.error();
  const Eigen::Isometry3d scan_from_world =
      document.scan_from_world.value_or(Eigen::Isometry3d::Identity());
  std::vector<AnnotatedInstance> drafts;
  AnnotationDocument known = document;
  for (const EstimatedObject& estimate : *estimates) {
    AnnotatedInstance draft;
    for (int i = 0; draft.id.empty() || known.Find(draft.id) != nullptr; ++i) {
      draft.id = estimate.model + "_" + std::to_string(i);
    }
    draft.model = estimate.model;
    draft.category = estimate.category;
    draft.scan_from_object = scan_from_world * estimate.world_from_object;
    draft.scale = estimate.scale;
    draft.fine = false;
    draft.note =
        std::string(kDraftNote) + "object " + estimate.id + " of " + run.filename().string();
    known.instances.push_back(draft);
    drafts.push_back(std::move(draft));
  }
  return drafts;
}

}  // namespace plumbline
