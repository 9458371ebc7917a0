// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// How many times as long as the perimeter of the box around it a shape's outline is: the mean over
/// eight directions, 20 degrees from above; at least 1. About 1 for a sideboard or a screen, 1.6
/// for a table, 2 to 3 for chairs. What is drawn beside one line of an outline is not beside the
/// next: errors that all views of an object share average out over its lines.
double OutlineLines(const HypothesisScorer& scorer, const ModelDatabase& database, ModelId label);

}  // namespace plumbline
