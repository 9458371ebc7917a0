// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// The protocol of the paper for SceneNN: each annotated instance of a category that COCO has is
/// cut out of the scan as a model of its own. Finds floor and gravity in the scan, and writes
/// models/, ground_truth.json and gravity.json into the folder of the converted sequence. Does
/// nothing for a sequence that is no scene of SceneNN or has no annotation (NNN.xml) or scan.
/// Errors: those of the files; kDegenerate where there is no floor.
Status CropSceneNnModels(const Sequence& sequence, const std::filesystem::path& folder,
                         std::vector<std::string>& warnings);

}  // namespace plumbline
