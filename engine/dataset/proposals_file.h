// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// `{image, boxes: [{x0, y0, x1, y1, category, score}]}`: what `plumbline detect` writes for one
/// image.
nlohmann::json ProposalsToJson(const std::string& image, std::span<const Detection> proposals);

/// Reads the boxes of one image: `{boxes: [..]}`, a list with one such entry (as `detect` writes
/// it), or the bare list of boxes. Errors: kNotFound, kCorrupt (naming the file and the box).
Result<std::vector<Detection>> ReadProposalsFile(const std::filesystem::path& file);

}  // namespace plumbline
