// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/report/batch_report.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/batch/batch_results.h"
#include "engine/batch/batch_review.h"
#include "engine/batch/batch_runner.h"
#include "engine/batch/child_process.h"

namespace plumbline {
namespace {

struct BatchArguments {
  std::string plan, out, engine = "local", against;
  int at_once = 0, pages = 3;
  bool retry = false, collect = false;
  std::optional<int> task;  ///< Of a cluster; the program calls itself with it.
};

Result<Batch> BatchOf(const BatchArguments& arguments) {
  const auto program = ThisProgram();
  if (!program.ok()) return program.error();
  std::error_code error;
  std::filesystem::path folder = std::filesystem::absolute(arguments.out, error).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  if (arguments.collect) return OpenBatchAsItIs(folder);
  if (arguments.plan.empty()) return OpenBatch(folder, *program);
  auto plan = ReadBatchPlan(arguments.plan);
  if (!plan.ok()) return plan.error();
  auto hashes = HashPrograms(*plan, *program);
  if (!hashes.ok()) return hashes.error();
  return MakeBatch(folder, *program, std::move(*plan), std::move(*hashes));
}

Result<BatchRunOptions> RunOptionsOf(const BatchArguments& arguments, const Batch& batch) {
  BatchRunOptions options;
  options.at_once = arguments.at_once;
  options.retry = arguments.retry;
  if (arguments.engine == "slurm") options.cluster = SlurmCommands(batch.plan.slurm);
  if (arguments.engine == "slurm" || arguments.engine == "local") return options;
  std::error_code error;
  if (!std::filesystem::exists(arguments.engine, error))
    return Error{ErrorCode::kNotFound,
                 "--engine is local, slurm or a file that describes another "
                 "batch system; there is no file '" +
                     arguments.engine + "'"};
  auto commands = ReadClusterCommands(arguments.engine);
  if (!commands.ok()) return commands.error();
  options.cluster = std::move(*commands);
  return options;
}

/// A figure by row, a recipe by column.
void PrintFigures(const BatchView& view) {
  std::printf("\n%-20s", "");
  for (const std::string& recipe : view.table.recipes) std::printf("  %26s", recipe.c_str());
  std::printf("\n");
  for (std::size_t figure = 0; figure < view.table.figures.size(); ++figure) {
    const BatchFigure& of = view.table.figures[figure];
    std::string line;
    bool any = false;
    for (const BatchEstimate& estimate : view.means) {
      if (estimate.figure != static_cast<int>(figure)) continue;
      any |= estimate.mean.has_value();
      line += fmt::format("  {:>26}", EstimateInWords(estimate.mean));
    }
    const std::string name = of.name + (of.unit.empty() ? "" : " [" + of.unit + "]");
    if (any) std::printf("%-20s%s\n", name.c_str(), line.c_str());
  }
}

void PrintRows(const BatchView& view, const std::vector<BatchDifference>& rows,
               bool only_significant) {
  const bool none = std::none_of(rows.begin(), rows.end(),
                                 [](const auto& row) { return row.p_adjusted <= 0.05; });
  if (only_significant && none) std::printf("  none\n");
  for (const BatchDifference& row : rows) {
    if (only_significant && row.p_adjusted > 0.05) continue;
    const PairedDifference& difference = row.difference;
    const std::string seen =
        difference.detectable ? fmt::format("{:.2f}", *difference.detectable) : "-";
    const BatchFigure& figure = view.table.figures[static_cast<std::size_t>(row.figure)];
    std::printf("  %-14s %-24s %+9.2f %-3s p %-7s (Holm %s; %d pairs, %s would be seen)%s\n",
                figure.name.c_str(),
                view.table.recipes[static_cast<std::size_t>(row.recipe)].c_str(),
                difference.mean.mean, figure.unit.c_str(), ProbabilityInWords(difference.p).c_str(),
                ProbabilityInWords(row.p_adjusted).c_str(), difference.mean.values, seen.c_str(),
                row.worse ? "  WORSE" : "");
  }
}

void PrintBatch(const BatchView& view, const std::optional<BatchGate>& gate) {
  PrintFigures(view);
  if (view.table.recipes.size() > 1) {
    std::printf("\nsignificant differences to '%s'\n", view.table.recipes[0].c_str());
    PrintRows(view, view.differences, true);
  }
  if (!gate) return;
  std::printf("\nagainst %s, %d pairs of runs\n", gate->baseline.c_str(), gate->pairs);
  PrintRows(view, gate->rows, false);
  for (const std::string& remark : gate->remarks) std::printf("  %s\n", remark.c_str());
}

/// Pages of the worst runs, as 'plumbline report' makes them, where they are not there yet.
Status WriteRunPages(const Batch& batch, const BatchView& view, int count,
                     const WorkContext& work) {
  const int pages = std::min(count, static_cast<int>(view.worst.size()));
  for (int i = 0; i < pages; ++i) {
    work.report({"pages of the worst runs", i, pages});
    const BatchRun& run =
        view.table.runs[static_cast<std::size_t>(view.worst[static_cast<std::size_t>(i)])];
    const std::filesystem::path folder = batch.folder / run.folder;
    std::error_code error;
    if (run.status != "ok" || std::filesystem::exists(folder / "report.html", error)) continue;
    const auto end = RunChild({batch.program.string(), "report", "run.plb", "--out", "report.html"},
                              {folder, folder / "report.log.txt", std::nullopt}, work.stop);
    if (!end.ok() && end.error().code == ErrorCode::kCancelled) return end.error();
    if (!end.ok() || !end->ok())
      log::warn("no page of a run: '{}' says why", (folder / "report.log.txt").string());
  }
  return {};
}

/// What is there now as results.sqlite and report.html.
Status TellBatch(const BatchArguments& arguments, const Batch& batch, const WorkContext& work) {
  const BatchTable table = CollectTable(batch);
  if (Status status = WriteBatchResults(batch.folder / kBatchResults, table); !status.ok())
    return status;
  const BatchView view = ReviewBatch(table);
  if (Status status = WriteRunPages(batch, view, arguments.pages, work); !status.ok())
    return status;
  BatchReportInputs inputs{batch.folder, std::nullopt, BatchPlanToJson(batch.plan).dump(1)};
  if (!arguments.against.empty()) {
    const auto baseline = ReadBatchResults(arguments.against);
    if (!baseline.ok()) return baseline.error();
    auto gate = GateBatch(table, *baseline, batch.plan.gate);
    if (!gate.ok()) return gate.error();
    gate->baseline = arguments.against;
    inputs.gate = std::move(*gate);
  }
  const std::filesystem::path page = batch.folder / "report.html";
  if (Status status = WriteFileAtomically(page, BatchReportHtml(view, inputs)); !status.ok())
    return status;
  int failed = 0;
  for (const BatchRun& run : table.runs) failed += run.status == "ok" ? 0 : 1;
  PrintBatch(view, inputs.gate);
  std::printf("\n%zu runs, %d failed; wrote %s and %s\n", table.runs.size(), failed,
              (batch.folder / kBatchResults).c_str(), page.c_str());
  if (inputs.gate && inputs.gate->worse > 0)
    return Error{ErrorCode::kInvalidInput,
                 fmt::format("{} figures got significantly worse than in '{}'", inputs.gate->worse,
                             arguments.against)};
  if (inputs.gate || failed == 0) return {};
  return Error{ErrorCode::kInvalidInput,
               fmt::format("{} of {} runs failed; '{}' has their logs, --retry does them again",
                           failed, table.runs.size(), page.string())};
}

Status DoBatch(const BatchArguments& arguments) {
  if (!arguments.against.empty() && !arguments.collect) {
    // Not after hours of runs.
    if (const auto baseline = ReadBatchResults(arguments.against); !baseline.ok())
      return baseline.error();
  }
  const auto batch = BatchOf(arguments);
  if (!batch.ok()) return batch.error();
  std::error_code error;
  for (const std::filesystem::path& own : {batch->folder, batch->folder / kBatchResults}) {
    if (!arguments.against.empty() && std::filesystem::equivalent(own, arguments.against, error))
      return InvalidInput(
          "--against names this batch itself; name an earlier one in another folder");
  }
  ConsoleWork console;
  const WorkContext work = console.context();
  if (arguments.task) return RunTask(*batch, *arguments.task, work);
  if (arguments.collect) return TellBatch(arguments, *batch, work);
  const auto options = RunOptionsOf(arguments, *batch);
  if (!options.ok()) return options.error();
  const std::size_t pending = PendingJobsOf(*batch).size(), all = batch->jobs.size();
  std::fprintf(stderr, "%zu of %zu runs are done\n", all - pending, all);
  const Status status = RunBatch(*batch, *options, work);
  if (status.ok()) return TellBatch(arguments, *batch, work);
  if (status.error().code != ErrorCode::kCancelled) return status;
  return Error{ErrorCode::kCancelled,
               fmt::format("stopped; {} of {} runs are done, the same command goes on",
                           all - PendingJobsOf(*batch).size(), all)};
}

}  // namespace

void AddBatchVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<BatchArguments>();
  CLI::App* verb = app.add_subcommand(
      "batch",
      "Many runs: sequences, recipes, swept options and seeds, here or on a cluster; a table, a "
      "report with intervals and differences, and a gate against an earlier batch");
  verb->add_option("plan", arguments->plan,
                   "What to run (docs/batch.md); without it the batch in --out goes on")
      ->type_name("PLAN.json");
  verb->add_option("--out", arguments->out,
                   "Folder of the batch: runs, results.sqlite, report.html. What is done there is "
                   "not done again")
      ->required()
      ->type_name("DIR");
  verb->add_option("--jobs", arguments->at_once,
                   "Runs at the same time (default: as many as there are cores; on a cluster, as "
                   "there is room for)")
      ->check(CLI::Range(1, 10'000))
      ->type_name("N");
  verb->add_option("--engine", arguments->engine,
                   "What does the runs: local (this machine), slurm (job arrays), or a JSON file "
                   "that describes another batch system")
      ->type_name("local|slurm|FILE.json")
      ->capture_default_str();
  verb->add_option("--against", arguments->against,
                   "An earlier batch, or its results.sqlite: fail if a figure got significantly "
                   "worse")
      ->type_name("DIR|FILE");
  verb->add_option("--pages", arguments->pages,
                   "Of so many of the worst runs, a page each as 'report' makes it")
      ->check(CLI::Range(0, 1000))
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* collect = verb->add_flag(
      "--collect", arguments->collect,
      "Run nothing: only make table and report of what the last call left, also while it is at "
      "work");
  verb->add_flag("--retry", arguments->retry, "Do failed runs again")->excludes(collect);
  verb->add_option("--task", arguments->task, "Do one task of a cluster (called by the batch)")
      ->group("");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return DoBatch(*arguments); }; });
}

}  // namespace plumbline
