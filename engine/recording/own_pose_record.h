// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "engine/base/result.h"
#include "engine/recording/sqlite.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// Puts the poses that the filter found into a run file, inside the caller's transaction.
/// docs/run_file.md explains the table.
Status StoreOwnPoses(sqlite::Database& database, const OwnPoses& poses);

/// Adds what has been found since: poses of a live run grow. Inside of a transaction. Growth from
/// the first image on begins anew.
Status AddOwnPoses(sqlite::Database& database, const OwnPoseGrowth& growth);

/// What a file holds of them.
struct StoredOwnPoses {
  std::size_t images = 0, corrections = 0;
};
Result<StoredOwnPoses> CountOwnPoses(sqlite::Database& database);

/// Null where the file has none. Errors: kCorrupt.
Result<std::shared_ptr<const OwnPoses>> LoadOwnPoses(sqlite::Database& database);

}  // namespace plumbline
