// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain for a file NAME.sens, a folder NAME with NAME.sens in it, and a folder with color/,
/// pose/ and intrinsic/intrinsic_color.txt, as ScanNet's SensReader extracts one.
Likeness ProbeScanNet(const std::filesystem::path& path);

/// Opens a scan of ScanNet, from its .sens file or extracted: color/N.jpg, depth/N.png (mm),
/// pose/N.txt (4x4, world_from_cam) and intrinsic/intrinsic_{color,depth}.txt. Depth, of a smaller
/// camera at the same place, is brought into the colour camera (nearest pixel). Poses of -inf,
/// where tracking was lost, are none. Extracted frames, and those of files whose stamps do not
/// rise, come at 30 Hz. `world` is z up. NAME_vh_clean_2.ply is the scan. Errors: kNotFound,
/// kCorrupt, kInvalidInput, kUnsupported.
Result<std::shared_ptr<const Sequence>> OpenScanNet(const std::filesystem::path& path,
                                                    const SequenceOptions& options = {});

/// The alignments that Scan2CAD's full_annotations.json, in the scan's folder or one of the two
/// above it, gives for this scan (by its name, scene0000_00): `model` is id_cad, `category` COCO's
/// name for ShapeNet's catid_cad where there is one. A model's `trs` (T R S, from the CAD model to
/// Scan2CAD's world) is taken back by the scan's `trs` into `world`. ShapeNet's models have y up
/// and their front along -z; `object` is ours, and stands in the middle of the model's underside.
/// `scale` is the geometric mean of the three; `size_m` the box as they stretch it. (Layout as of
/// skanti/Scan2CAD, README.md and Annotation2Mesh.py.)
Result<std::optional<GroundTruth>> TruthOfScanNet(const Sequence& sequence,
                                                  const ModelFrames& models,
                                                  std::vector<std::string>& warnings);

/// What full_annotations.json says of one scan; nothing where it has none of that name. Errors:
/// kNotFound, kCorrupt, kInvalidInput.
Result<std::optional<GroundTruth>> ReadScan2Cad(const std::filesystem::path& file,
                                                const ModelFrames& models, const std::string& scan,
                                                std::vector<std::string>& warnings);

}  // namespace plumbline
