// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/result.h"
#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// The name of the results in the folder of a batch.
inline constexpr const char* kBatchResults = "results.sqlite";

/// Writes a table as an SQLite file (docs/formats.md#batch-results), whole or not at all. `results`
/// and `missed` hold nothing that depends on where and when the runs were made. Errors: kIo.
Status WriteBatchResults(const std::filesystem::path& file, const BatchTable& table);

/// Reads one, or that of the folder of a batch. Figures that this program does not know are left
/// out, those that the file has not are nothing.
/// Errors: kNotFound, kInvalidInput (something else, a newer format), kCorrupt, kIo.
Result<BatchTable> ReadBatchResults(const std::filesystem::path& file_or_folder);

}  // namespace plumbline
