// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/annotation/annotation_document.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// A folder as Scan2CAD's scripts read it: full_annotations.json with one scan, named `id_scan`,
/// cad_appearances.json, and shapenet/CATEGORY/MODEL/models/model_normalized.obj (metres, turned y
/// up). Its world is the level scan turned y up; catid_cad is our category and id_cad our model.
/// There are no keypoints. `scan` (may be null) becomes scannet/ID/ID_vh_clean_2.ply. Errors:
/// kInvalidInput (no models, an instance of an unknown model), kIo.
Status WriteScan2Cad(const AnnotationDocument& document, const ModelDatabase* models,
                     const TriangleMesh* scan, const std::string& id_scan,
                     const std::filesystem::path& folder);

}  // namespace plumbline
