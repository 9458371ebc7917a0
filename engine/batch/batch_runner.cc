// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_runner.h"

#include <algorithm>
#include <thread>

#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

constexpr const char* kPlanFile = "plan.json";
constexpr const char* kProgramsFile = "programs.json";

Result<BatchPlan> StoredPlan(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder / kPlanFile, error)) return ReadBatchPlan(folder / kPlanFile);
  return Error{ErrorCode::kNotFound,
               "'" + folder.string() + "' is no folder of a batch; name a plan as well"};
}

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
  Result<BatchPlan> plan = StoredPlan(folder);
  if (!plan.ok()) return plan.error();
  auto hashes = HashPrograms(*plan, program);
  if (!hashes.ok()) return hashes.error();
  return MakeBatch(folder, program, std::move(*plan), std::move(*hashes));
}

Result<Batch> OpenBatchAsItIs(const std::filesystem::path& folder) {
  Result<BatchPlan> plan = StoredPlan(folder);
  if (!plan.ok()) return plan.error();
  const auto stored = ReadJson(folder / kProgramsFile);
  if (!stored.ok()) return stored.error();
  std::map<std::string, std::string> hashes;
  const auto damaged = [&] {
    return Error{ErrorCode::kCorrupt, "'" + (folder / kProgramsFile).string() +
                                          "' is damaged; call the batch without --collect"};
  };
  const auto program = TextFromJson(*stored, "program");
  if (!program || !stored->contains("hashes")) return damaged();
  for (const auto& [path, hash] : (*stored)["hashes"].items()) {
    if (!hash.is_string()) return damaged();
    hashes[path] = hash.get<std::string>();
  }
  return MakeBatch(folder, *program, std::move(*plan), std::move(hashes));
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
  const nlohmann::json programs = {{"program", batch.program.string()},
                                   {"hashes", batch.program_hashes}};
  if (Status status = WriteJson(batch.folder / kProgramsFile, programs); !status.ok())
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
