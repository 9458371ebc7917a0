// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/progress.h"
#include "engine/batch/batch_engines.h"

namespace plumbline {

/// How a batch is done.
struct BatchRunOptions {
  int at_once = 0;  ///< Runs at the same time; 0: as many as there are cores, or room on a cluster.
  bool retry = false;                        ///< Do failed runs again.
  std::optional<ClusterCommands> cluster{};  ///< Nothing: this machine.
};

/// Opens the batch in `folder` as it was last called, to go on with it by the programs as they are
/// now. Errors: kNotFound, kCorrupt, kInvalidInput, kIo.
Result<Batch> OpenBatch(const std::filesystem::path& folder, const std::filesystem::path& program);

/// Opens it to look at what is there: the runs that the last call made or wanted to make, whatever
/// has become of the programs. Errors: as OpenBatch.
Result<Batch> OpenBatchAsItIs(const std::filesystem::path& folder);

/// Does what is not done yet and keeps every result at once: killed or stopped, it goes on where it
/// was when it is called again.
/// Errors: kInvalidInput (a sequence that cannot be used; another process is at the batch),
/// kCancelled, kIo.
Status RunBatch(const Batch& batch, const BatchRunOptions& options, const WorkContext& work);

}  // namespace plumbline
