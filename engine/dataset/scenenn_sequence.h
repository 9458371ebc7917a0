// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there are image/imageNNNNN.png and a trajectory.log.
Likeness ProbeSceneNn(const std::filesystem::path& path);

/// Opens a scene of SceneNN as its playback tool extracts one: image/imageNNNNN.png and
/// depth/depthNNNNN.png (mm), both from 1, timestamp.txt (rows `k color_ts depth_ts`, us), and the
/// trajectory.log of Redwood's form (three whole numbers, then a 4x4 matrix, world_from_cam; the
/// k-th pose is that of image k), here or as ../trajectory/NNN_trajectory.log. Without
/// timestamp.txt 30 Hz. Camera: f 544.47329, (320, 240). The scan is NNN.ply, in `world`. Gravity
/// is not told. Errors: kNotFound, kCorrupt, kInvalidInput; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenSceneNn(const std::filesystem::path& folder,
                                                    const SequenceOptions& options = {});

/// An instance in the annotation of a scene.
struct SceneNnLabel {
  int id = 0;             ///< As the mesh's vertices have it in their property `label`.
  std::string nyu_class;  ///< As chair; may be empty.
  std::string text;       ///< What the annotator called it; may be empty.
};
/// The labels of NNN.xml: `<label id=".." nyu_class=".." text="..">` below the root. Errors:
/// kNotFound, kCorrupt, naming the file.
Result<std::vector<SceneNnLabel>> ReadSceneNnLabels(const std::filesystem::path& file);

/// COCO's name for a class of NYU; nothing for walls, floors and what has none.
std::optional<std::string> CategoryOfNyu(const std::string& nyu_class);

/// NNN.xml of a scene; nothing where there is none.
std::optional<std::filesystem::path> SceneNnAnnotation(const std::filesystem::path& folder);

}  // namespace plumbline
