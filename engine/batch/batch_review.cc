// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_review.h"

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "engine/base/options.h"
#include "engine/batch/batch_statistics.h"

namespace plumbline {
namespace {

constexpr double kSignificant = 0.05;
constexpr std::size_t kWorstRuns = 12, kWorstOfRecipe = 3, kWorstPairs = 5;

/// What two runs must share to be a pair.
using PairKey = std::tuple<std::string, std::vector<double>, std::uint64_t>;
using RunsByKey = std::map<PairKey, std::size_t>;

int IndexOf(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

RunsByKey RunsOf(const BatchTable& table, const std::string& recipe) {
  RunsByKey runs;
  for (std::size_t i = 0; i < table.runs.size(); ++i) {
    const BatchRun& run = table.runs[i];
    if (run.recipe == recipe) runs[{run.sequence, run.point, run.seed}] = i;
  }
  return runs;
}

std::optional<double> FigureAt(const BatchRun& run, int figure) {
  const auto at = static_cast<std::size_t>(figure);
  return figure >= 0 && at < run.figures.size() ? run.figures[at] : std::nullopt;
}

int ColumnIn(const BatchTable& table, const std::string& name) {
  for (std::size_t i = 0; i < table.figures.size(); ++i) {
    if (table.figures[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::optional<MeanEstimate> MeanOver(const BatchTable& table, const BatchEstimate& of) {
  std::vector<SequenceValue> values;
  for (const BatchRun& run : table.runs) {
    if (run.recipe != table.recipes[static_cast<std::size_t>(of.recipe)]) continue;
    if (!of.point.empty() && run.point != of.point) continue;
    if (const auto value = FigureAt(run, of.figure))
      values.push_back({IndexOf(table.sequences, run.sequence), *value});
  }
  std::optional<MeanEstimate> estimate = EstimateMean(values);
  // No figure is negative, and Student does not know of shares that they end at 100.
  const bool share = table.figures[static_cast<std::size_t>(of.figure)].unit == "%";
  const double most = share ? 100 : std::numeric_limits<double>::infinity();
  if (estimate && estimate->low) {
    estimate->low = std::clamp(*estimate->low, 0.0, most);
    estimate->high = std::clamp(*estimate->high, 0.0, most);
  }
  return estimate;
}

std::set<std::vector<double>> PointsIn(const BatchTable& table) {
  std::set<std::vector<double>> points;
  for (const BatchRun& run : table.runs) points.insert(run.point);
  return points;
}

/// Figures of runs in `table` less those of their counterparts.
class Pairing {
 public:
  Pairing(const BatchTable& table, const RunsByKey& runs, const BatchTable& other_table,
          const RunsByKey& others)
      : table_(table), other_table_(other_table) {
    for (const auto& [key, run] : runs) {
      if (const auto found = others.find(key); found != others.end())
        pairs_.push_back({run, found->second});
    }
  }

  int pairs() const { return static_cast<int>(pairs_.size()); }

  /// @param figure, other_figure  Its column in each of the tables.
  /// @return Nothing where no pair has both values.
  std::optional<BatchDifference> Compare(int figure, int other_figure) const {
    std::vector<SequenceValue> differences;
    std::vector<std::pair<double, int>> worsened;
    BatchDifference row;
    const int better = table_.figures[static_cast<std::size_t>(figure)].better;
    for (const auto& [run, other] : pairs_) {
      const auto value = FigureAt(table_.runs[run], figure);
      const auto before = FigureAt(other_table_.runs[other], other_figure);
      if (!value || !before) {
        row.unpaired += value || before ? 1 : 0;
        continue;
      }
      differences.push_back(
          {IndexOf(table_.sequences, table_.runs[run].sequence), *value - *before});
      const double loss = better * (*before - *value);
      if (loss > 0) worsened.emplace_back(-loss, static_cast<int>(run));
    }
    const auto difference = ComparePairs(differences);
    if (!difference) return std::nullopt;
    row.figure = figure;
    row.difference = *difference;
    std::sort(worsened.begin(), worsened.end());
    for (std::size_t i = 0; i < std::min(kWorstPairs, worsened.size()); ++i)
      row.worst_runs.push_back(worsened[i].second);
    return row;
  }

  /// Means of both over the pairs that have both values, sequences weighing the same.
  std::pair<double, double> Means(int figure, int other_figure) const {
    std::vector<SequenceValue> now, then;
    for (const auto& [run, other] : pairs_) {
      const auto value = FigureAt(table_.runs[run], figure);
      const auto before = FigureAt(other_table_.runs[other], other_figure);
      if (!value || !before) continue;
      const int sequence = IndexOf(table_.sequences, table_.runs[run].sequence);
      now.push_back({sequence, *value});
      then.push_back({sequence, *before});
    }
    const auto after = EstimateMean(now), earlier = EstimateMean(then);
    return {earlier ? earlier->mean : 0, after ? after->mean : 0};
  }

 private:
  const BatchTable& table_;
  const BatchTable& other_table_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
};

std::vector<BatchDifference> DifferencesToFirst(const BatchTable& table) {
  std::vector<BatchDifference> rows;
  std::vector<double> p;
  const RunsByKey first = table.recipes.empty() ? RunsByKey() : RunsOf(table, table.recipes[0]);
  for (std::size_t recipe = 1; recipe < table.recipes.size(); ++recipe) {
    const Pairing pairing(table, RunsOf(table, table.recipes[recipe]), table, first);
    for (int figure = 0; figure < static_cast<int>(table.figures.size()); ++figure) {
      auto row = pairing.Compare(figure, figure);
      if (!row) continue;
      row->recipe = static_cast<int>(recipe);
      p.push_back(row->difference.p);
      rows.push_back(std::move(*row));
    }
  }
  const std::vector<double> adjusted = HolmAdjusted(p);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].p_adjusted = adjusted[i];
    const int better = table.figures[static_cast<std::size_t>(rows[i].figure)].better;
    rows[i].worse = adjusted[i] <= kSignificant && better * rows[i].difference.mean.mean < 0;
  }
  return rows;
}

/// Failed ones first, then those that found least, then those that are farthest off; the worst of
/// every recipe.
std::vector<int> WorstRuns(const BatchTable& table) {
  const int f1 = ColumnIn(table, "f1"), translation = ColumnIn(table, "translation");
  std::vector<int> order;
  for (std::size_t i = 0; i < table.runs.size(); ++i) order.push_back(static_cast<int>(i));
  const auto badness = [&](int i) {
    const BatchRun& run = table.runs[static_cast<std::size_t>(i)];
    return std::tuple(run.status == "ok", FigureAt(run, f1).value_or(0),
                      -FigureAt(run, translation).value_or(0));
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return badness(a) < badness(b); });
  // Of each recipe some: a bad one would hide what is wrong with the others.
  const std::size_t most =
      std::max(kWorstOfRecipe, kWorstRuns / std::max<std::size_t>(1, table.recipes.size()));
  std::map<std::string, std::size_t> taken;
  std::erase_if(
      order, [&](int i) { return ++taken[table.runs[static_cast<std::size_t>(i)].recipe] > most; });
  return order;
}

/// The columns that are tested.
Result<std::vector<int>> GatedFigures(const BatchTable& table,
                                      const std::vector<std::string>& figures) {
  static const std::vector<std::string> usual = {"failed", "found", "spurious", "translation",
                                                 "rotation"};
  std::vector<std::string> known;
  for (const BatchFigure& figure : table.figures) {
    if (figure.better != 0) known.push_back(figure.name);
  }
  std::vector<int> columns;
  for (const std::string& name : figures.empty() ? usual : figures) {
    for (std::size_t i = 0; i < table.figures.size(); ++i) {
      if (table.figures[i].name == name && table.figures[i].better != 0)
        columns.push_back(static_cast<int>(i));
    }
    if (std::find(known.begin(), known.end(), name) == known.end())
      return InvalidInput("'" + name +
                          "' is no figure that can be better or worse; did you mean '" +
                          NearestName(name, known) + "'?");
  }
  return columns;
}

void JudgeGate(const BatchTable& table, BatchGate& gate) {
  std::vector<double> p;
  for (const BatchDifference& row : gate.rows) {
    const int better = table.figures[static_cast<std::size_t>(row.figure)].better;
    p.push_back(better > 0 ? row.difference.p_less : row.difference.p_more);
  }
  const std::vector<double> adjusted = HolmAdjusted(p);
  bool any_can = false;
  for (std::size_t i = 0; i < p.size(); ++i) {
    BatchDifference& row = gate.rows[i];
    row.p_adjusted = adjusted[i];
    row.worse = adjusted[i] <= kSignificant;
    gate.worse += row.worse ? 1 : 0;
    // One-sided, and the first that Holm looks at.
    any_can |= static_cast<double>(p.size()) * row.difference.p_least / 2 <= kSignificant;
  }
  const bool all_same = std::all_of(gate.rows.begin(), gate.rows.end(),
                                    [](const auto& row) { return row.difference.differing == 0; });
  if (!any_can && !all_same)
    gate.remarks.emplace_back(
        "so few pairs differ that nothing can be significant; give the plan more seeds or "
        "sequences, or its gate fewer figures");
}

}  // namespace

BatchView ReviewBatch(BatchTable table) {
  BatchView view;
  view.table = std::move(table);
  const std::set<std::vector<double>> points = PointsIn(view.table);
  for (int recipe = 0; recipe < static_cast<int>(view.table.recipes.size()); ++recipe) {
    for (int figure = 0; figure < static_cast<int>(view.table.figures.size()); ++figure) {
      BatchEstimate estimate{recipe, figure, {}, {}};
      estimate.mean = MeanOver(view.table, estimate);
      view.means.push_back(estimate);
      if (view.table.options.empty()) continue;
      for (const std::vector<double>& point : points) {
        estimate.point = point;
        estimate.mean = MeanOver(view.table, estimate);
        view.responses.push_back(estimate);
      }
    }
  }
  view.differences = DifferencesToFirst(view.table);
  view.worst = WorstRuns(view.table);
  return view;
}

Result<BatchGate> GateBatch(const BatchTable& now, const BatchTable& baseline,
                            const std::vector<std::string>& figures) {
  const auto columns = GatedFigures(now, figures);
  if (!columns.ok()) return columns.error();
  BatchGate gate;
  for (std::size_t recipe = 0; recipe < now.recipes.size(); ++recipe) {
    const Pairing pairing(now, RunsOf(now, now.recipes[recipe]), baseline,
                          RunsOf(baseline, now.recipes[recipe]));
    gate.pairs += pairing.pairs();
    for (const int column : *columns) {
      const int before = ColumnIn(baseline, now.figures[static_cast<std::size_t>(column)].name);
      auto row = pairing.Compare(column, before);
      if (!row) {
        if (pairing.pairs() > 0)
          gate.remarks.push_back(
              fmt::format("'{}' of '{}' is not tested: no pair of runs has it on both sides",
                          now.figures[static_cast<std::size_t>(column)].name, now.recipes[recipe]));
        continue;
      }
      row->recipe = static_cast<int>(recipe);
      const auto [then, after] = pairing.Means(column, before);
      gate.before.push_back(then);
      gate.after.push_back(after);
      gate.rows.push_back(std::move(*row));
    }
  }
  if (gate.pairs == 0)
    return InvalidInput(
        "no run has a counterpart in the baseline: sequences, recipes, swept values and seeds have "
        "to be the same");
  const auto missing = [&](const BatchTable& table, const char* where) {
    const int count = static_cast<int>(table.runs.size()) - gate.pairs;
    if (count > 0) gate.remarks.push_back(fmt::format("{} runs are in {} only", count, where));
  };
  missing(now, "this batch");
  missing(baseline, "the baseline");
  JudgeGate(now, gate);
  return gate;
}

std::vector<std::map<std::string, int>> CausesByRecipe(const BatchTable& table) {
  std::vector<std::map<std::string, int>> causes(table.recipes.size());
  for (const BatchRun& run : table.runs) {
    const auto recipe = static_cast<std::size_t>(IndexOf(table.recipes, run.recipe));
    if (recipe >= causes.size()) continue;
    for (const BatchMiss& miss : run.missed) ++causes[recipe][miss.cause];
  }
  return causes;
}

}  // namespace plumbline
