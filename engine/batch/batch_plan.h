// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// A sequence of a batch: one that is there, or one that `synth` makes.
struct PlannedSequence {
  std::string name;                ///< Unique, and good as the name of a folder.
  std::filesystem::path path;      ///< Absolute; empty: made below the folder of the batch.
  std::vector<std::string> synth;  ///< Words for `plumbline synth`; empty: it is there.
  std::filesystem::path ground_truth, models, scene;  ///< Absolute; empty: the sequence's own.
};

/// How sequences are mapped.
struct PlannedRecipe {
  std::string name;                ///< Unique, and good as a part of the name of a folder.
  std::filesystem::path program;   ///< Of another commit, absolute; empty: this one.
  std::vector<std::string> words;  ///< For `plumbline run`.
};

/// An option of the filter (`run --set`) over a range.
struct SweptOption {
  std::string option;
  std::vector<double> values;  ///< Rising.
};

/// How runs are judged: options of `plumbline evaluate`.
struct PlannedEvaluation {
  int samples = 100'000;
  int single_frames = 0;
  std::string align;  ///< Empty: as evaluate does it.
  std::vector<std::string> ignored_categories;
};

/// Sequences x recipes x points of a sweep x seeds (docs/formats.md#batch-plan).
struct BatchPlan {
  std::string name;
  std::vector<PlannedSequence> sequences;
  std::vector<PlannedRecipe> recipes;
  std::vector<std::uint64_t> seeds;
  std::vector<SweptOption> sweep;  ///< None, one or two.
  PlannedEvaluation evaluation;
  std::optional<double> timeout_s;  ///< Of one run; then it has failed.
  std::vector<std::string> gate;    ///< Figures that may not get worse; empty: all.
  std::vector<std::string> slurm;   ///< More words for `sbatch`.
};

/// Reads and checks a plan. Paths in it are relative to its folder.
/// Errors: kNotFound, kCorrupt, kInvalidInput, naming the file and the key.
Result<BatchPlan> ReadBatchPlan(const std::filesystem::path& file);

/// As ReadBatchPlan; `folder` is where relative paths start.
Result<BatchPlan> BatchPlanFromJson(const nlohmann::json& json,
                                    const std::filesystem::path& folder);

/// In the form that BatchPlanFromJson reads, nothing left to defaults.
nlohmann::json BatchPlanToJson(const BatchPlan& plan);

/// Every point of the sweep, the last option changing first; one empty point without a sweep.
std::vector<std::vector<double>> PointsOf(const BatchPlan& plan);

/// "beta=0.5 alpha=2"; "" without a sweep.
std::string PointInWords(const std::vector<std::string>& options, const std::vector<double>& point);

}  // namespace plumbline
