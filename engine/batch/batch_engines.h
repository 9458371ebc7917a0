// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "engine/batch/batch_jobs.h"

namespace plumbline {

/// Runs that are still to be done; they point into a batch.
using PendingJobs = std::vector<const BatchJob*>;

/// Those without a result.
PendingJobs PendingJobsOf(const Batch& batch);

/// Does runs on this machine, `at_once` at the same time. Errors: kCancelled, kIo; what is done is
/// kept.
Status RunHere(const Batch& batch, const PendingJobs& jobs, int at_once, const WorkContext& work);

/// How a batch system is spoken to: lines for /bin/sh with {name}, {tasks} (how many), {at_once},
/// {log}, {script} and {id} (what `submit` printed) in them. docs/batch.md has examples.
struct ClusterCommands {
  std::string submit;  ///< An array of tasks that are numbered from 1.
  std::string left;    ///< Prints a line for each task that has not ended; nothing when all have.
  std::string cancel;
  std::vector<std::string> script;  ///< What a task runs: {command} and its number.
  int most_tasks = 1000;            ///< In one array; more runs than that share tasks.
};

/// Slurm's job arrays. @param options  More words for sbatch.
ClusterCommands SlurmCommands(const std::vector<std::string>& options);

/// Errors: kNotFound, kCorrupt, kInvalidInput, naming the key.
Result<ClusterCommands> ReadClusterCommands(const std::filesystem::path& file);

/// Does runs as an array of tasks on a cluster that sees the batch's folder and program, and waits
/// for them. An array that an earlier call left there is waited for first.
/// @param at_once  Tasks at the same time; 0: as many as there is room for.
/// Errors: kCancelled (the array is, too); kIo with what the batch system said.
Status RunOnCluster(const Batch& batch, const ClusterCommands& commands, int at_once,
                    const WorkContext& work);

/// What such a task does. @param task  From 1.
/// Errors: kInvalidInput if there is no such task; those of RunJob.
Status RunTask(const Batch& batch, int task, const WorkContext& work);

}  // namespace plumbline
