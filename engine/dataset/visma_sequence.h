// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a file `dataset` beside images STAMP.png.
Likeness ProbeVisma(const std::filesystem::path& path);

/// Opens a sequence of VISMA: images STAMP.png, the protobuf file `dataset` with camera, poses and
/// gravity, and the boxes of STAMP.bbox as proposals. Packet i belongs to the i-th image in time
/// order, never by stamp; boxes belong to the image of their name. Images are ordered by the whole
/// number in their name (STAMP may be 1234567.000000), whose unit, ns to s, is taken from the step
/// between them. `world` is that of the recording (SLAM), gravity that of the last packet that
/// tells one (exp([wx, wy, 0]) (0, 0, -1)). The four first parameters of the camera are fx, fy, cx,
/// cy. Errors: kNotFound, kCorrupt, kInvalidInput; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenVisma(const std::filesystem::path& folder,
                                                  const SequenceOptions& options = {});

/// The truth of fragments/objects.json and alignment.json (12 numbers, model to the scan's frame,
/// metres) of RGBD/SEQUENCE, which lies in the sequence itself, beside it or beside the folder it
/// is in. result_alignment.json (T_ef_corvis, SLAM to scan) beside them takes it into `world`;
/// without it the truth stays in the frame of the scan, with a warning. The poses are
/// those of the mesh files, which have y up: without the frame that a model was built into,
/// `object` is that of the file turned upright, (x, y, z) -> (x, -z, y). The model's name is what
/// stands before the last underscore of an entry.
Result<std::optional<GroundTruth>> TruthOfVisma(const Sequence& sequence, const ModelFrames& models,
                                                std::vector<std::string>& warnings);

/// As above, of a folder fragments. Errors: kNotFound, kCorrupt, kInvalidInput.
Result<GroundTruth> ReadVismaTruth(const std::filesystem::path& fragments,
                                   const ModelFrames& models, std::vector<std::string>& warnings);

}  // namespace plumbline
