// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/batch/batch_plan.h"
#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// One run of a plan.
struct BatchJob {
  int number = 0;  ///< Its place in the plan, from 0.
  int sequence = 0, recipe = 0;
  std::vector<double> point;
  std::uint64_t seed = 0;
  /// Of its files, below that of the batch; its end is a hash of everything that the run depends
  /// on, the program included, so that no result is taken for one of something else.
  std::string folder;
};

/// A batch in its folder.
struct Batch {
  std::filesystem::path folder;   ///< Absolute.
  std::filesystem::path program;  ///< This one: it evaluates, and maps where a recipe names none.
  BatchPlan plan;
  std::vector<BatchJob> jobs;  ///< By seed, point, recipe, sequence: early results tell of all.
  std::map<std::string, std::string> program_hashes;  ///< By path.

  std::filesystem::path SequenceFolder(const PlannedSequence& sequence) const;
  std::filesystem::path ResultFile(const BatchJob& job) const;
  /// "" of one that is not known.
  std::string HashOf(const std::filesystem::path& some_program) const;
  /// That maps.
  const std::filesystem::path& ProgramOf(const BatchJob& job) const;
};

/// The content of this program and of those that recipes name, by their paths. Errors: kNotFound,
/// kIo: a program that cannot be read.
Result<std::map<std::string, std::string>> HashPrograms(const BatchPlan& plan,
                                                        const std::filesystem::path& program);

/// Takes a plan apart. @param program_hashes  As of HashPrograms, now or when its runs were made.
Batch MakeBatch(const std::filesystem::path& folder, const std::filesystem::path& program,
                BatchPlan plan, std::map<std::string, std::string> program_hashes);

/// What a finished run left; nothing where it left nothing that can be read.
std::optional<nlohmann::json> ReadJobResult(const Batch& batch, const BatchJob& job);

/// The results of a batch as they are now; a run without one is "lost".
BatchTable CollectTable(const Batch& batch);

/// Does one run: `plumbline run`, `plumbline evaluate`, each a process of its own whose output is
/// kept in log.txt, then writes result.json, at once or not at all. A run that fails leaves a
/// result, too. One that was interrupted goes on where it was.
/// Errors: kCancelled; kInvalidInput: somebody is at it already; kIo.
Status RunJob(const Batch& batch, const BatchJob& job, const std::stop_token& stop);

/// Removes what a failed run left, so that it is done again. Errors: kIo.
Status ForgetJob(const Batch& batch, const BatchJob& job);

/// Whether its sequence opens, and has truth and models. Errors: those of OpenSequence;
/// kInvalidInput, naming what is missing.
Status CheckJobInputs(const Batch& batch, const BatchJob& job);

/// Makes a synthetic sequence, unless it is there. Errors: kCancelled; kInvalidInput with what
/// `synth` said.
Status MakeSequence(const Batch& batch, const PlannedSequence& sequence,
                    const std::stop_token& stop);

}  // namespace plumbline
