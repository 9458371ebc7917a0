// SPDX-License-Identifier: Apache-2.0
#pragma once

// Many runs as a table and what it says. engine/batch works it out (docs/batch.md).

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumbline {

/// A figure by which runs are judged.
struct BatchFigure {
  std::string name, unit;  ///< "" where it has no unit.
  std::string help;
  int better = 0;  ///< 1: more is better; -1: less is; 0: neither.
};

/// A true instance that a run missed.
struct BatchMiss {
  std::string truth, model, cause, text;  ///< Cause by its name; the text says it with figures.
};

/// One run of a batch.
struct BatchRun {
  int number = 0;  ///< Its place in the plan.
  std::string sequence, recipe;
  std::vector<double> point;  ///< Values of the swept options.
  std::uint64_t seed = 0;
  std::string status;                          ///< "ok", "failed" or "lost": no result was left.
  std::vector<std::optional<double>> figures;  ///< As BatchTable::figures.
  std::vector<BatchMiss> missed;
  std::string folder;                         ///< Of its files, below that of the batch.
  std::string reason;                         ///< Why it failed; "" otherwise.
  std::string host, started;                  ///< Time in UTC.
  std::string program_version, program_hash;  ///< That mapped; the hash of its content.
  int frames = 0;
  double run_s = 0, evaluate_s = 0;
};

/// All runs of a batch, in the order of its plan.
struct BatchTable {
  std::string name;
  std::vector<std::string> sequences, recipes, options;  ///< Options: those that are swept.
  std::vector<BatchFigure> figures;
  std::vector<BatchRun> runs;
};

/// A mean with its confidence interval.
struct MeanEstimate {
  double mean = 0;
  std::optional<double> low, high;  ///< Nothing where one value alone says nothing of spread.
  int values = 0, sequences = 0;
  bool over_sequences = false;  ///< The interval is of sequences like these; else of seeds alone.
  double seed_std = 0;          ///< Of the seeds within a sequence; 0 with one seed.
  double sequence_std = 0;      ///< Of the means of the sequences; 0 with one.
};

/// How much more one has of a figure than another has, pair by pair.
struct PairedDifference {
  MeanEstimate mean;
  double p = 1;                      ///< That chance alone makes so large a difference, two-sided.
  double p_more = 1, p_less = 1;     ///< One-sided.
  double p_least = 1;                ///< The smallest two-sided p that so many pairs can give.
  std::optional<double> detectable;  ///< Would be found 4 times of 5; nothing with one pair.
  int differing = 0;                 ///< Pairs that differ at all.
};

/// A figure of one recipe, or of it at one point of a sweep.
struct BatchEstimate {
  int recipe = 0, figure = 0;
  std::vector<double> point;         ///< Empty: over all points.
  std::optional<MeanEstimate> mean;  ///< Nothing where no run has a value.
};

/// A recipe against the first one, or against the same of an earlier batch.
struct BatchDifference {
  int recipe = 0, figure = 0;
  PairedDifference difference;  ///< This one less the other.
  double p_adjusted = 1;        ///< After Holm, over all rows of its list.
  int unpaired = 0;             ///< Runs of which one of the two has no value.
  bool worse = false;           ///< Significantly, at 5 %, after Holm.
  std::vector<int> worst_runs;  ///< Places in BatchTable::runs, most worsened first; at most 5.
};

/// What a batch says.
struct BatchView {
  BatchTable table;
  std::vector<BatchEstimate> means;          ///< By recipe, then figure.
  std::vector<BatchEstimate> responses;      ///< By recipe, figure, point; empty without a sweep.
  std::vector<BatchDifference> differences;  ///< Two-sided; of each recipe to the first.
  std::vector<int> worst;                    ///< Places in table.runs, worst first.
};

/// A batch as the window has it.
struct ShownBatch {
  std::string folder;   ///< Runs lie below it.
  std::string problem;  ///< Why it could not be read; "": it could.
  BatchView view;
};

/// A batch against an earlier one.
struct BatchGate {
  std::string baseline;               ///< As it was named.
  std::vector<BatchDifference> rows;  ///< p_adjusted: one-sided, that it is no worse.
  std::vector<double> before, after;  ///< As rows: means over the pairs.
  int pairs = 0;                      ///< Runs that both have.
  std::vector<std::string> remarks;   ///< What does not fit.
  int worse = 0;
};

}  // namespace plumbline
