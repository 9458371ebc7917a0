// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "engine/base/queue.h"
#include "engine/base/worker.h"
#include "engine/snapshot/folder_view.h"

namespace plumbline {

/// Reads a folder, which may take long on a network drive.
/// @param given_up  Looked at before each entry: whether nobody wants the answer any more.
FolderView ReadFolder(const std::filesystem::path& folder, const std::function<bool()>& given_up);

/// Reads folders for the window on a thread of its own.
class FolderReader {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  explicit FolderReader(std::function<void()> on_publish) : on_publish_(std::move(on_publish)) {}
  ~FolderReader() { ++asked_; }
  FolderReader(const FolderReader&) = delete;
  FolderReader& operator=(const FolderReader&) = delete;

  /// Instead of what was asked for before. Returns at once.
  void Read(const std::filesystem::path& folder);
  /// Null before the first answer.
  std::shared_ptr<const FolderView> View() const { return view_.Latest(); }

 private:
  std::function<void()> on_publish_;
  std::atomic<std::uint64_t> asked_ = 0;
  SnapshotSlot<FolderView> view_;
  Worker worker_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
