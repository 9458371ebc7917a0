// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// What SQLite's file system does when the time has come. The process ends without a word (as by
/// SIGKILL) or everything from then on fails (as on a full disk).
enum class DiskFailure { kEndBefore, kEndHalfWay, kEndAfter, kFailFromThen };

/// From now on, in this process, SQLite writes through a file system that counts what changes
/// files (writes, truncations, syncs, deletions) and fails at the `at`-th, from 1. Nothing waits
/// for the disk. There is no way back, but other failures may be chosen, in forked children, say.
void InstallFailingVfs(DiskFailure failure, int at);

/// What was counted so far.
int NumDiskChanges();

/// The exit code of a process that was ended so.
inline constexpr int kEndedByVfs = 77;

}  // namespace plumbline
