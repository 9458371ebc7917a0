// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/mapping/map_object.h"
#include "engine/mapping/mapper_options.h"
#include "engine/render/renderer.h"

namespace plumbline {

/// Which proposal shows which object, one to one: proposals of the object's category whose boxes
/// overlap that of its visible mask, best overlap and score together (Hungarian method); settled
/// objects before tentative ones. Entry i belongs to object i. `maps`: mean states, half size.
std::vector<std::optional<std::size_t>> MatchProposals(std::span<const Detection> proposals,
                                                       std::span<const MapObject> objects,
                                                       const RenderedMaps& maps);

/// What becomes of each proposal. Explained are, besides the matched ones: parts of an object of
/// its category (the visible mask fills more than `explained_overlap` of the box), second boxes of
/// it, boxes about several objects that they are filled with, and boxes of whatever category that
/// nearly coincide with an object's. The fate of the others is kSpawned provisionally where they
/// may spawn.
std::vector<ProposalReport> ExplainProposals(std::span<const Detection> proposals,
                                             std::span<const MapObject> objects,
                                             std::span<const std::optional<std::size_t>> matched,
                                             const RenderedMaps& maps,
                                             const ModelDatabase& database,
                                             const MapperOptions& options);

/// Whether two objects of one category cannot both be there: their footprints overlap by more than
/// 30 % of the smaller one (10 % where both are confirmed, so that their places are known), or they
/// lie within one object's size of each other and explain nearly the same part of the image (the
/// twin of a chair of which only the back rest shows).
bool Compete(const MapObject& a, const MapObject& b, const MapFrame& map);

}  // namespace plumbline
