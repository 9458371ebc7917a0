// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_jobs.h"

#include <cctype>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/batch/batch_figures.h"

namespace plumbline {
namespace {

using nlohmann::json;

/// A name as a part of the name of a folder.
std::string Slug(const std::string& name) {
  std::string slug;
  for (const char c : name)
    slug += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ? c : '_';
  return slug;
}

std::string FolderOf(const BatchPlan& plan, const BatchJob& job, const std::string& hash) {
  std::string folder = "jobs/" + Slug(plan.sequences[static_cast<std::size_t>(job.sequence)].name) +
                       "." + Slug(plan.recipes[static_cast<std::size_t>(job.recipe)].name);
  for (std::size_t i = 0; i < job.point.size(); ++i)
    folder += fmt::format(".{}={:g}", plan.sweep[i].option, job.point[i]);
  return folder + fmt::format(".seed{}-{}", job.seed, hash.substr(0, 8));
}

std::vector<std::optional<double>> FiguresFrom(const json& result) {
  std::vector<std::optional<double>> figures;
  const json given = result.value("figures", json::object());
  for (const BatchFigure& figure : BatchFigures()) {
    const json value = given.is_object() ? given.value(figure.name, json()) : json();
    figures.push_back(value.is_number() ? std::optional(value.get<double>()) : std::nullopt);
  }
  return figures;
}

void Fill(const json& result, BatchRun& run) {
  run.status = result.value("status", "failed");
  run.figures = FiguresFrom(result);
  for (const json& missed : result.value("missed", json::array())) {
    run.missed.push_back({missed.value("truth", ""), missed.value("model", ""),
                          missed.value("cause", ""), missed.value("text", "")});
  }
  run.reason = result.value("reason", "");
  run.host = result.value("host", "");
  run.started = result.value("started", "");
  run.program_version = result.value("program_version", "");
  run.program_hash = result.value("program_hash", "");
  run.frames = result.contains("frames") ? IntFromJson(result["frames"]) : 0;
  run.run_s = result.value("run_s", 0.0);
  run.evaluate_s = result.value("evaluate_s", 0.0);
}

}  // namespace

std::filesystem::path Batch::SequenceFolder(const PlannedSequence& sequence) const {
  return sequence.synth.empty() ? sequence.path : folder / "sequences" / Slug(sequence.name);
}

std::filesystem::path Batch::ResultFile(const BatchJob& job) const {
  return folder / job.folder / "result.json";
}

const std::filesystem::path& Batch::ProgramOf(const BatchJob& job) const {
  const auto& own = plan.recipes[static_cast<std::size_t>(job.recipe)].program;
  return own.empty() ? program : own;
}

std::string Batch::HashOf(const std::filesystem::path& some_program) const {
  const auto found = program_hashes.find(some_program.string());
  return found == program_hashes.end() ? "" : found->second;
}

Result<std::map<std::string, std::string>> HashPrograms(const BatchPlan& plan,
                                                        const std::filesystem::path& program) {
  std::map<std::string, std::string> hashes;
  Result<std::string> own = HashFile(program);
  if (!own.ok()) return own.error();
  hashes[program.string()] = *own;
  for (const PlannedRecipe& recipe : plan.recipes) {
    if (recipe.program.empty() || hashes.contains(recipe.program.string())) continue;
    Result<std::string> hash = HashFile(recipe.program);
    if (!hash.ok())
      return Error{hash.error().code,
                   "the program of recipe '" + recipe.name + "': " + hash.error().message};
    hashes[recipe.program.string()] = *hash;
  }
  return hashes;
}

Batch MakeBatch(const std::filesystem::path& folder, const std::filesystem::path& program,
                BatchPlan plan, std::map<std::string, std::string> program_hashes) {
  Batch batch{folder, program, std::move(plan), {}, std::move(program_hashes)};
  const json planned = BatchPlanToJson(batch.plan);
  BatchJob job;
  for (const std::uint64_t seed : batch.plan.seeds) {
    for (const std::vector<double>& point : PointsOf(batch.plan)) {
      for (std::size_t recipe = 0; recipe < batch.plan.recipes.size(); ++recipe) {
        for (std::size_t sequence = 0; sequence < batch.plan.sequences.size(); ++sequence) {
          job.sequence = static_cast<int>(sequence);
          job.recipe = static_cast<int>(recipe);
          job.point = point;
          job.seed = seed;
          const json everything = {planned["sequences"][sequence],
                                   planned["recipes"][recipe]["arguments"],
                                   planned["evaluate"],
                                   batch.HashOf(batch.ProgramOf(job)),
                                   batch.HashOf(program),
                                   point,
                                   seed};
          job.folder = FolderOf(batch.plan, job, HashHex(JsonText(everything)));
          batch.jobs.push_back(job);
          ++job.number;
        }
      }
    }
  }
  return batch;
}

std::optional<json> ReadJobResult(const Batch& batch, const BatchJob& job) {
  std::error_code error;
  if (!std::filesystem::exists(batch.ResultFile(job), error)) return std::nullopt;
  const Result<json> result = ReadJson(batch.ResultFile(job));
  if (!result.ok() || !result->is_object()) return std::nullopt;
  return *result;
}

BatchTable CollectTable(const Batch& batch) {
  BatchTable table;
  table.name = batch.plan.name;
  for (const auto& sequence : batch.plan.sequences) table.sequences.push_back(sequence.name);
  for (const auto& recipe : batch.plan.recipes) table.recipes.push_back(recipe.name);
  for (const auto& swept : batch.plan.sweep) table.options.push_back(swept.option);
  table.figures.assign(BatchFigures().begin(), BatchFigures().end());
  const bool single_frames = batch.plan.evaluation.single_frames > 0;
  for (const BatchJob& job : batch.jobs) {
    BatchRun run;
    run.number = job.number;
    run.sequence = table.sequences[static_cast<std::size_t>(job.sequence)];
    run.recipe = table.recipes[static_cast<std::size_t>(job.recipe)];
    run.point = job.point;
    run.seed = job.seed;
    run.folder = job.folder;
    run.status = "lost";
    run.figures = FiguresOfFailure();
    run.reason = "no result was left";
    try {
      BatchRun filled = run;
      if (const auto result = ReadJobResult(batch, job)) Fill(*result, filled);
      run = std::move(filled);
    } catch (const std::exception&) {  // of a value of another type, or too large
      run.reason = "its result.json is damaged; remove it, and call the batch again";
    }
    // Nobody asked for it, so that nobody fails in it.
    for (std::size_t i = 0; i < table.figures.size() && !single_frames; ++i) {
      if (table.figures[i].name == "bop_ar") run.figures[i] = std::nullopt;
    }
    table.runs.push_back(std::move(run));
  }
  return table;
}

Status ForgetJob(const Batch& batch, const BatchJob& job) {
  std::error_code error;
  std::filesystem::remove_all(batch.folder / job.folder, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, "cannot remove '" + (batch.folder / job.folder).string() +
                                   "' to do it again: " + error.message()};
}

}  // namespace plumbline
