// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/evaluate_runs.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/analysis/missed_table.h"
#include "engine/analysis/missed_truths.h"
#include "engine/base/log.h"

namespace plumbline {
namespace {

/// The run files of a folder by name; a file itself.
Result<std::vector<std::filesystem::path>> RunFiles(const std::vector<std::string>& named) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : named) {
    std::error_code error;
    if (!std::filesystem::exists(name, error))
      return Error{ErrorCode::kNotFound, "there is no run or folder '" + name + "'"};
    if (!std::filesystem::is_directory(name, error)) {
      files.emplace_back(name);
      continue;
    }
    std::vector<std::filesystem::path> there;
    for (const auto& entry : std::filesystem::directory_iterator(name, error)) {
      if (entry.path().extension() == ".plb") there.push_back(entry.path());
    }
    if (there.empty())
      return Error{ErrorCode::kNotFound, "the folder '" + name + "' has no run (.plb)"};
    std::sort(there.begin(), there.end());
    files.insert(files.end(), there.begin(), there.end());
  }
  return files;
}

Result<JudgedRun> JudgeRun(const std::filesystem::path& file,
                           const EvaluateRunsArguments& arguments, const WorkContext& work) {
  Result<RunReview> review = ReviewRun({file, {}, arguments.models}, arguments.ground_truth, work);
  if (!review) return review.error();
  LeaveOut(arguments.ignored_categories, *review);
  if (review->view.truth.empty()) {
    return Error{ErrorCode::kNotFound,
                 file.string() + " has no ground truth; name one with --ground-truth"};
  }
  std::filesystem::path scene = review->header.recipe.sequence;
  if (!scene.has_filename()) scene = scene.parent_path();
  return JudgedRun{file.stem().string(), scene.filename().string(), TruthsOf(*review)};
}

/// Two runs of one name are told apart by their folders.
void TellApart(const std::vector<std::filesystem::path>& files, std::vector<JudgedRun>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool twice = std::any_of(runs.begin(), runs.end(), [&](const JudgedRun& other) {
      return &other != &runs[i] && other.name == runs[i].name;
    });
    if (!twice) continue;
    std::filesystem::path file = files[i];
    runs[i].name = file.replace_extension("").generic_string();
  }
}

std::string InTable(const TruthView* truth) {
  if (truth == nullptr) return "";
  return truth->found ? "found" : InWords(NameOf(truth->cause));
}

void PrintRow(const std::string& first, const std::vector<std::string>& cells,
              const std::vector<std::size_t>& widths) {
  std::printf("%-22s", first.c_str());
  for (std::size_t i = 0; i < cells.size(); ++i)
    std::printf("  %-*s", static_cast<int>(widths[i]), cells[i].c_str());
  std::printf("\n");
}

void PrintTable(const MissedTable& table) {
  std::vector<std::string> heads, sums;
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < table.runs.size(); ++i) {
    heads.push_back(table.runs[i]->name);
    const TruthsView& truths = table.runs[i]->truths;
    sums.push_back(std::to_string(truths.found) + " of " + std::to_string(truths.truths.size()));
    std::size_t width = std::max(heads.back().size(), sums.back().size());
    for (const MissedTable::Row& row : table.rows)
      width = std::max(width, InTable(row.by_run[i]).size());
    widths.push_back(width);
  }
  heads.emplace_back("found in");
  widths.push_back(0);
  PrintRow(table.scene, heads, widths);
  for (const MissedTable::Row& row : table.rows) {
    std::vector<std::string> cells;
    for (const TruthView* truth : row.by_run) cells.push_back(InTable(truth));
    cells.push_back(std::to_string(row.found));
    PrintRow(row.truth, cells, widths);
  }
  PrintRow("found", sums, widths);
  std::printf("\n");
}

void Print(const std::vector<JudgedRun>& runs) {
  for (const MissedTable& table : MissedTables(runs)) PrintTable(table);
  int missed = 0;
  for (const JudgedRun& run : runs) missed += run.truths.missed;
  std::printf("%d runs, %d instances missed\n", static_cast<int>(runs.size()), missed);
  for (const auto& [cause, count] : CausesOf(runs))
    std::printf("  %5d  %s\n", count, InWords(NameOf(cause)).c_str());
}

}  // namespace

Status EvaluateRuns(const EvaluateRunsArguments& arguments) {
  const auto files = RunFiles(arguments.runs);
  if (!files.ok()) return files.error();
  ConsoleWork console;
  std::vector<JudgedRun> runs;
  std::vector<std::filesystem::path> judged;
  for (const std::filesystem::path& file : *files) {
    Result<JudgedRun> run = JudgeRun(file, arguments, console.context());
    if (!run && run.error().code == ErrorCode::kCancelled) return run.error();
    if (!run) {
      log::warn("left out: {}", run.error().message);
      continue;
    }
    runs.push_back(std::move(*run));
    judged.push_back(file);
  }
  if (runs.empty())
    return Error{ErrorCode::kInvalidInput, "none of the runs can be judged; see above"};
  TellApart(judged, runs);
  if (arguments.json != "-") Print(runs);
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, MissedTablesToJson(runs));
}

}  // namespace plumbline
