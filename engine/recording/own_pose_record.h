// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/result.h"
#include "engine/recording/sqlite.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// Puts the poses that the filter found into a run file, inside the caller's transaction.
/// docs/run_file.md explains the table.
Status StoreOwnPoses(sqlite::Database& database, const OwnPoses& poses);

/// Adds what has been found since: poses of a live run grow. Inside of a transaction.
/// @param stored  Frames of `poses` that are there already; 0 begins the tables.
Status AddOwnPoses(sqlite::Database& database, const OwnPoses& poses, std::size_t stored);

/// Null where the file has none. Errors: kCorrupt.
Result<std::shared_ptr<const OwnPoses>> LoadOwnPoses(sqlite::Database& database);

}  // namespace plumbline
