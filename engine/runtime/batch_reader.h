// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "engine/base/queue.h"
#include "engine/base/worker.h"
#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// Whether this is the folder of a batch or its results.
bool IsBatch(const std::filesystem::path& path);

/// Reads the results of a batch and what they say on a thread of its own.
class BatchReader {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  explicit BatchReader(std::function<void()> on_publish) : on_publish_(std::move(on_publish)) {}
  BatchReader(const BatchReader&) = delete;
  BatchReader& operator=(const BatchReader&) = delete;

  /// @param path  A folder or its results.sqlite. Returns at once.
  void Read(const std::filesystem::path& path);
  /// Null before the first answer.
  std::shared_ptr<const ShownBatch> View() const { return view_.Latest(); }

 private:
  std::function<void()> on_publish_;
  SnapshotSlot<ShownBatch> view_;
  Worker worker_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
