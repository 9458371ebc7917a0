// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a scene_camera.json beside rgb/ or gray/.
Likeness ProbeBop(const std::filesystem::path& path);

/// Opens a scene of a BOP data set, DATASET/SPLIT/NNNNNN: rgb/ or gray/ (NNNNNN.png or .jpg),
/// depth/ (raw * depth_scale = mm), and scene_camera.json, whose keys are image numbers without
/// leading zeros: cam_K (row by row) and, where they are told, cam_R_w2c (row by row) and cam_t_w2c
/// [mm] as poses. Nothing tells times: images come at 30 Hz by their number. Images with another
/// cam_K or depth of another camera than the first are left out with a warning; cam_model (BOP24)
/// is not read, and is an error beside cam_K. Gravity is not told. Errors: kNotFound, kCorrupt,
/// kInvalidInput, kUnsupported; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenBop(const std::filesystem::path& folder,
                                                const SequenceOptions& options = {});

/// scene_gt.json as ground truth of a scene in which nothing moves: poses of one obj_id that agree
/// to 5 cm over the images are one instance, as the nearest camera saw it. Poses are told in the
/// camera, in mm; images without a pose of the camera are passed over. Models have z up and their
/// origin in the middle of their box; with models_info.json (in models/ or models_eval/ of the data
/// set) `object` stands in the middle of its underside and has `size_m`. `model` and `category` are
/// obj_NNNNNN.
Result<std::optional<GroundTruth>> TruthOfBop(const Sequence& sequence, const ModelFrames& models,
                                              std::vector<std::string>& warnings);

}  // namespace plumbline
