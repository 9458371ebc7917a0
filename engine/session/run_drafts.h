// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "engine/annotation/annotation_document.h"

namespace plumbline {

/// What a run's map holds at its end, as instances to accept or mend: coarse, with ids that are
/// free in the document and a note that says which object of which run, in the scan by the
/// document's scan_from_world. Errors: as of ReadEstimates.
Result<std::vector<AnnotatedInstance>> DraftsOfRun(const AnnotationDocument& document,
                                                   const std::filesystem::path& run);

}  // namespace plumbline
