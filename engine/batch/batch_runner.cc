// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_runner.h"

#include <algorithm>
#include <thread>

#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"

namespace plumbline {
namespace {

constexpr const char* kPlanFile = "plan.json";

Status MakeSequences(const Batch& batch, const WorkContext& work) {
  const int total = static_cast<int>(batch.plan.sequences.size());
  for (int i = 0; i < total; ++i) {
    work.report({"making sequences", i, total});
    if (Status status =
            MakeSequence(batch, batch.plan.sequences[static_cast<std::size_t>(i)], work.stop);
        !status.ok())
      return status;
  }
  work.report({"making sequences", total, total});
  return {};
}

/// Of the first runs of all sequences and recipes: the others have the same inputs.
Status CheckInputs(const Batch& batch, const WorkContext& work) {
  const std::size_t different = batch.plan.sequences.size() * batch.plan.recipes.size();
  for (std::size_t i = 0; i < std::min(different, batch.jobs.size()); ++i) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    if (Status status = CheckJobInputs(batch, batch.jobs[i]); !status.ok()) return status;
  }
  return {};
}

Status ForgetFailed(const Batch& batch) {
  for (const BatchJob& job : batch.jobs) {
    const auto result = ReadJobResult(batch, job);
    if (!result || result->value("status", nlohmann::json()) == "ok") continue;
    if (Status status = ForgetJob(batch, job); !status.ok()) return status;
  }
  return {};
}

}  // namespace

Result<Batch> OpenBatch(const std::filesystem::path& folder, const std::filesystem::path& program) {
  std::error_code error;
  if (!std::filesystem::exists(folder / kPlanFile, error))
    return Error{ErrorCode::kNotFound,
                 "'" + folder.string() + "' is no folder of a batch; name a plan as well"};
  Result<BatchPlan> plan = ReadBatchPlan(folder / kPlanFile);
  if (!plan.ok()) return plan.error();
  return MakeBatch(folder, program, std::move(*plan));
}

Status RunBatch(const Batch& batch, const BatchRunOptions& options, const WorkContext& work) {
  std::error_code error;
  std::filesystem::create_directories(batch.folder / "jobs", error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + batch.folder.string() + "': " + error.message()};
  const auto lock = FileLock::Acquire(batch.folder / kPlanFile);
  if (!lock.ok()) return lock.error();
  if (Status status = WriteJson(batch.folder / kPlanFile, BatchPlanToJson(batch.plan));
      !status.ok())
    return status;
  if (options.retry) {
    if (Status status = ForgetFailed(batch); !status.ok()) return status;
  }
  if (Status status = MakeSequences(batch, work); !status.ok()) return status;
  if (Status status = CheckInputs(batch, work); !status.ok()) return status;
  if (options.cluster) return RunOnCluster(batch, *options.cluster, options.at_once, work);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return RunHere(batch, PendingJobsOf(batch), options.at_once > 0 ? options.at_once : cores, work);
}

}  // namespace plumbline
