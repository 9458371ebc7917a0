// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "engine/mapping/map_object.h"
#include "engine/mapping/mapper_options.h"
#include "engine/render/renderer.h"

namespace plumbline {

/// Decides which proposals the mean states explain: a proposal is explained if the visible mask of
/// an object of its category covers more than `explained_overlap` of its box, or its box more than
/// that of the mask (so that split and double boxes are explained too), or if box and mask's box
/// nearly coincide whatever the category. `maps`: mean states, half size. The fate of the others is
/// kSpawned provisionally where they may give birth.
std::vector<ProposalReport> ExplainProposals(std::span<const Detection> proposals,
                                             std::span<const MapObject> objects,
                                             const RenderedMaps& maps,
                                             const ModelDatabase& database,
                                             const MapperOptions& options);

/// Whether two objects of one category cannot both be there: their footprints overlap by more than
/// 30 % of the smaller one, or they lie within one object's size of each other and explain nearly
/// the same part of the image (the twin of a chair of which only the back rest shows).
bool Compete(const MapObject& a, const MapObject& b, const MapFrame& map);

}  // namespace plumbline
