// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "engine/annotation/pose_exchange.h"
#include "engine/base/progress.h"

namespace plumbline {

/// A BOP dataset with one scene (test/000000): scene_gt, scene_camera, scene_gt_info, masks,
/// images, models and models_info with symmetries. Millimetres; model frames with the origin in the
/// middle of the bounding box; the world of cam_*_w2c is the scan; obj_id is the model's place in
/// the database + 1, and models/plumbline_models.json keeps the names. Errors: kInvalidInput (no
/// sequence, no database, an instance of an unknown model), kIo, kCancelled.
Status WriteBop(const AnnotationDocument& document, const ExchangeInputs& inputs,
                const std::filesystem::path& folder, const WorkContext& context);

/// Which instance shows at each pixel of a frame, as the visible masks of WriteBop have it: CV_16U,
/// its place in the document + 1; 0: none. Errors: those of WriteBop, and kNotFound for a frame
/// without a pose.
Result<cv::Mat> VisibleInstances(const AnnotationDocument& document, const ExchangeInputs& inputs,
                                 int frame);

/// Instances of the first scene of a BOP dataset: each entry of its first image, and what later
/// images add, through cam_*_w2c. Models are named by plumbline_models.json, else obj_000001.
Result<ImportedPoses> ReadBop(const std::filesystem::path& folder);

}  // namespace plumbline
