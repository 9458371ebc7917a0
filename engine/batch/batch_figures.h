// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// What every run of a batch is judged by, in the order of the columns.
std::span<const BatchFigure> BatchFigures();

/// The figures of a run that went well, from what `plumbline evaluate --json` wrote; nothing for
/// those that this run has no value of (the error of objects where none was found).
std::vector<std::optional<double>> FiguresOf(const nlohmann::json& evaluation);

/// Those of a run that failed: it found nothing. Errors of what was not found have no value.
std::vector<std::optional<double>> FiguresOfFailure();

/// What such a run missed, and why.
std::vector<BatchMiss> MissesOf(const nlohmann::json& evaluation);

}  // namespace plumbline
