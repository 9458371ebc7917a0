// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/annotation/pose_exchange.h"
#include "engine/base/progress.h"

namespace plumbline {

/// A BOP dataset with one scene (test/000000): scene_gt, scene_camera, scene_gt_info, masks,
/// images, depth where the sequence has it, models with their symmetries, and
/// test_targets_bop19.json. Millimetres; model frames with the origin in the middle of the bounding
/// box; the world of cam_*_w2c is the scan; obj_id is the model's place in the database + 1, and
/// models/plumbline_models.json keeps the names. Masks and counts are those of instance_masks.h.
/// Errors: kInvalidInput (no sequence, no database, an instance of an unknown model), kCorrupt (a
/// depth image), kIo, kCancelled.
Status WriteBop(const AnnotationDocument& document, const ExchangeInputs& inputs,
                const std::filesystem::path& folder, const WorkContext& context);

/// Instances of the first scene of a BOP dataset: each entry of its first image, and what later
/// images add, through cam_*_w2c. Models are named by plumbline_models.json, else obj_000001.
Result<ImportedPoses> ReadBop(const std::filesystem::path& folder);

}  // namespace plumbline
