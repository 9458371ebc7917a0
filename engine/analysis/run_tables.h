// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/analysis/run_review.h"

namespace plumbline {

// A run as tables for spreadsheets and scripts (CSV, RFC 4180; lengths in metres, angles in
// degrees, as the headings say). docs/formats.md lists the columns.

std::string ObjectsCsv(const RunReview& review);  ///< One row per object of the last frame.
std::string FramesCsv(const RunReview& review);   ///< One row per frame and object.
std::string EventsCsv(const RunReview& review);   ///< One row per life event.
std::string TimingsCsv(const RunReview& review);  ///< One row per frame, a column per stage.

/// Writes objects.csv, frames.csv, events.csv and timings.csv into `folder`, which is made if it is
/// missing. Errors: kIo.
Status WriteRunTables(const std::filesystem::path& folder, const RunReview& review);

}  // namespace plumbline
