// SPDX-License-Identifier: Apache-2.0
#include "app/report/batch_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "app/report/batch_responses.h"
#include "app/report/html_page.h"
#include "app/report/svg_plot.h"
#include "engine/base/files.h"
#include "engine/batch/batch_plan.h"
#include "engine/batch/batch_review.h"

namespace plumbline {
namespace {

constexpr std::size_t kShownMisses = 8, kShownFailures = 20, kLogBytes = 1500;

const BatchFigure& FigureOf(const BatchView& view, int figure) {
  return view.table.figures[static_cast<std::size_t>(figure)];
}

std::string FigureCell(const BatchFigure& figure) {
  const char* arrow = figure.better > 0 ? " &uarr;" : figure.better < 0 ? " &darr;" : "";
  return fmt::format("<td title='{}'>{}{}{}</td>", Escaped(figure.help), Escaped(figure.name),
                     figure.unit.empty() ? "" : " [" + Escaped(figure.unit) + "]", arrow);
}

std::string Signed(double value) { return fmt::format("{:+.2f}", value); }

std::string SignedInterval(const MeanEstimate& mean) {
  if (!mean.low) return Signed(mean.mean);
  return fmt::format("{:+.2f} [{:+.2f}, {:+.2f}]", mean.mean, *mean.low, *mean.high);
}

std::string RunTitle(const BatchTable& table, const BatchRun& run) {
  std::string title = run.sequence + ", " + run.recipe;
  if (!run.point.empty()) title += ", " + PointInWords(table.options, run.point);
  return title + fmt::format(", seed {}", run.seed);
}

/// A file of a run, where it is there.
std::string LinkTo(const BatchReportInputs& inputs, const BatchRun& run, const char* file,
                   const std::string& words) {
  std::error_code error;
  if (!std::filesystem::exists(inputs.folder / run.folder / file, error)) return "";
  std::string address;
  for (const char c : run.folder + "/" + file)
    address += c == '%' ? "%25" : c == '#' ? "%23" : c == '?' ? "%3F" : std::string(1, c);
  return fmt::format("<a href='{}'>{}</a> ", Escaped(address), words);
}

std::string RunLinks(const BatchReportInputs& inputs, const BatchRun& run) {
  return LinkTo(inputs, run, "report.html", "page") + LinkTo(inputs, run, "run.plb", "run") +
         LinkTo(inputs, run, "evaluation.json", "figures") + LinkTo(inputs, run, "log.txt", "log");
}

std::string CardsOfBatch(const BatchView& view) {
  const BatchTable& table = view.table;
  int failed = 0;
  double seconds = 0;
  std::set<std::uint64_t> seeds;
  std::set<std::vector<double>> points;
  for (const BatchRun& run : table.runs) {
    failed += run.status == "ok" ? 0 : 1;
    seconds += run.run_s + run.evaluate_s;
    seeds.insert(run.seed);
    points.insert(run.point);
  }
  std::string html = "<div class='cards'>";
  const auto card = [&](const std::string& value, const std::string& what) {
    html += fmt::format("<div class='card'><b>{}</b><span>{}</span></div>", value, what);
  };
  const auto count = [&](std::size_t number, const std::string& what) {
    card(std::to_string(number), number == 1 ? what : what + "s");
  };
  count(table.runs.size(), "run");
  card(fmt::format("<i style='font-style:normal' class='{}'>{}</i>", failed > 0 ? "bad" : "good",
                   failed),
       "failed");
  count(table.sequences.size(), "sequence");
  count(table.recipes.size(), "recipe");
  if (!table.options.empty()) card(std::to_string(points.size()), "points of the sweep");
  count(seeds.size(), "seed");
  card(seconds < 600 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.1f} h", seconds / 3600),
       "of computing");
  return html + "</div>";
}

std::string WhatIntervalsAre(const BatchView& view) {
  return view.table.sequences.size() > 1
             ? fmt::format(
                   "Means over {} sequences of their means over seeds, and in brackets 95 % "
                   "intervals for sequences like these (Student's t over the sequences).",
                   view.table.sequences.size())
             : "Means over seeds, and in brackets 95 % intervals (Student's t over the seeds): one "
               "sequence says nothing of others.";
}

std::string FigureTable(const BatchView& view) {
  const BatchTable& table = view.table;
  std::string html = "<h2>Figures</h2><div class='scroll'><table><tr><th>figure</th>";
  for (const std::string& recipe : table.recipes)
    html += fmt::format("<th>{}</th>", Escaped(recipe));
  html += "<th>std of seeds</th><th>std of sequences</th></tr>";
  for (int figure = 0; figure < static_cast<int>(table.figures.size()); ++figure) {
    std::string cells;
    double seeds = 0, sequences = 0;
    bool any = false;
    for (const BatchEstimate& estimate : view.means) {
      if (estimate.figure != figure) continue;
      cells += fmt::format("<td>{}</td>", EstimateInWords(estimate.mean));
      if (!estimate.mean) continue;
      any = true;
      seeds = std::max(seeds, estimate.mean->seed_std);
      sequences = std::max(sequences, estimate.mean->sequence_std);
    }
    if (any)
      html += fmt::format("<tr>{}{}<td>{:.2f}</td><td>{:.2f}</td></tr>",
                          FigureCell(FigureOf(view, figure)), cells, seeds, sequences);
  }
  html +=
      "</table></div><p class='legend'>" + WhatIntervalsAre(view) +
      " A failed run has found nothing and counts as such; errors are those of what was found. "
      "The deviations are the largest of the recipes" +
      (table.options.empty() ? "." : "; with a sweep, those of its points are among the seeds'.") +
      "</p>";
  return html;
}

std::string DifferenceCells(const BatchDifference& row) {
  const PairedDifference& difference = row.difference;
  const std::string pairs =
      fmt::format("{} ({} differ{})", difference.mean.values, difference.differing,
                  row.unpaired > 0 ? fmt::format(", {} without one", row.unpaired) : "");
  return fmt::format(
      "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>", SignedInterval(difference.mean),
      ProbabilityInWords(difference.p), ProbabilityInWords(row.p_adjusted),
      difference.detectable ? fmt::format("{:.2f}", *difference.detectable) : "-", pairs);
}

std::string Verdict(const BatchView& view, const BatchDifference& row) {
  const int better = FigureOf(view, row.figure).better;
  if (row.worse) return "<td class='bad'>worse</td>";
  if (row.p_adjusted > 0.05) return "<td>-</td>";
  return better == 0 ? "<td>differs</td>" : "<td class='good'>better</td>";
}

constexpr const char* kDifferenceHeads =
    "<th>difference</th><th>p</th><th>p, Holm</th><th>would be seen</th><th>pairs</th>";
constexpr const char* kDifferenceLegend =
    "<p class='legend'>Runs are paired by sequence, point and seed. In brackets 95 % intervals, of "
    "sequences like these where there are several. p is of these sequences: how often chance "
    "alone, "
    "a sign for each pair, makes a difference as large; Holm: after looking at all rows. Would be "
    "seen: a true difference of this size has p below 0.05 four times of five.</p>";

std::string DifferenceTables(const BatchView& view) {
  if (view.differences.empty()) return "";
  const BatchTable& table = view.table;
  std::string html = fmt::format("<h2>Differences to {}</h2>", Escaped(table.recipes[0]));
  for (int recipe = 1; recipe < static_cast<int>(table.recipes.size()); ++recipe) {
    html += fmt::format("<div class='scroll'><table><tr><th>{}</th>{}<th></th></tr>",
                        Escaped(table.recipes[static_cast<std::size_t>(recipe)]), kDifferenceHeads);
    for (const BatchDifference& row : view.differences) {
      if (row.recipe == recipe)
        html += "<tr>" + FigureCell(FigureOf(view, row.figure)) + DifferenceCells(row) +
                Verdict(view, row) + "</tr>";
    }
    html += "</table></div><br>";
  }
  return html + kDifferenceLegend;
}

std::string GateSection(const BatchView& view, const BatchReportInputs& inputs) {
  if (!inputs.gate) return "";
  const BatchGate& gate = *inputs.gate;
  std::string html = fmt::format(
      "<h2>Against {}: <span class='{}'>{}</span></h2><div "
      "class='scroll'><table><tr><th>figure</th>"
      "<th class='l'>recipe</th><th>before</th><th>now</th>{}<th></th></tr>",
      Escaped(gate.baseline), gate.worse > 0 ? "bad" : "good",
      gate.worse > 0 ? "got worse" : "nothing got significantly worse", kDifferenceHeads);
  std::string examples;
  for (std::size_t i = 0; i < gate.rows.size(); ++i) {
    const BatchDifference& row = gate.rows[i];
    const std::string& recipe = view.table.recipes[static_cast<std::size_t>(row.recipe)];
    html += fmt::format("<tr>{}<td class='l'>{}</td><td>{:.2f}</td><td>{:.2f}</td>{}{}</tr>",
                        FigureCell(FigureOf(view, row.figure)), Escaped(recipe), gate.before[i],
                        gate.after[i], DifferenceCells(row),
                        row.worse ? "<td class='bad'>worse</td>" : "<td>-</td>");
    for (const int at : row.worse ? row.worst_runs : std::vector<int>()) {
      const BatchRun& run = view.table.runs[static_cast<std::size_t>(at)];
      examples += fmt::format("<li>{}: {} {}</li>", Escaped(FigureOf(view, row.figure).name),
                              Escaped(RunTitle(view.table, run)), RunLinks(inputs, run));
    }
  }
  html += "</table></div>" + std::string(kDifferenceLegend);
  html += "<p class='legend'>Here Holm's p is one-sided: that it is no worse.</p>";
  for (const std::string& remark : gate.remarks)
    html += "<p class='legend bad'>" + Escaped(remark) + "</p>";
  if (!examples.empty()) html += "<p>Most worsened:</p><ul>" + examples + "</ul>";
  return html;
}

std::string WorstTable(const BatchView& view, const BatchReportInputs& inputs) {
  std::string html =
      "<h2>Worst runs</h2><div class='scroll'><table><tr><th>run</th><th class='l'>result</th>"
      "<th class='l'>missed, and why</th><th class='l'>files</th></tr>";
  for (const int at : view.worst) {
    const BatchRun& run = view.table.runs[static_cast<std::size_t>(at)];
    std::string result = run.status == "ok" ? "" : "<span class='bad'>" + run.status + "</span>";
    for (std::size_t i = 0; i < view.table.figures.size() && run.status == "ok"; ++i) {
      const BatchFigure& figure = view.table.figures[i];
      const bool told =
          figure.name == "found" || figure.name == "spurious" || figure.name == "translation";
      if (told && run.figures[i])
        result += fmt::format("{} {:.3g}{}{}<br>", figure.name, *run.figures[i],
                              figure.unit.empty() ? "" : " ", figure.unit);
    }
    std::string missed;
    for (std::size_t i = 0; i < std::min(kShownMisses, run.missed.size()); ++i) {
      const BatchMiss& miss = run.missed[i];
      missed += fmt::format("<b>{}</b>: {}<br>", Escaped(miss.truth),
                            Escaped(miss.text.empty() ? miss.cause : miss.text));
    }
    if (run.missed.size() > kShownMisses)
      missed += fmt::format("and {} more", run.missed.size() - kShownMisses);
    html += fmt::format(
        "<tr style='vertical-align:top'><td>{}</td><td class='l'>{}</td>"
        "<td class='l' style='white-space:normal'>{}</td><td class='l'>{}</td></tr>",
        Escaped(RunTitle(view.table, run)), result, missed, RunLinks(inputs, run));
  }
  return html +
         "</table></div><p class='legend'>Open a run, its panel <i>Why missed?</i> and its frames "
         "with <code>plumbline gui FOLDER/run.plb</code>.</p>";
}

std::string CauseTable(const BatchView& view) {
  const auto by_recipe = CausesByRecipe(view.table);
  std::set<std::string> causes;
  for (const auto& counts : by_recipe) {
    for (const auto& [cause, count] : counts) causes.insert(cause);
  }
  if (causes.empty()) return "";
  std::string html = "<h2>Why missed?</h2><div class='scroll'><table><tr><th>cause</th>";
  for (const std::string& recipe : view.table.recipes)
    html += fmt::format("<th>{}</th>", Escaped(recipe));
  html += "</tr>";
  for (const std::string& cause : causes) {
    std::string words = cause.empty() ? "not told" : cause;
    std::replace(words.begin(), words.end(), '_', ' ');
    html += "<tr><td>" + Escaped(words) + "</td>";
    for (const auto& counts : by_recipe) {
      const auto found = counts.find(cause);
      html += fmt::format("<td>{}</td>", found == counts.end() ? 0 : found->second);
    }
    html += "</tr>";
  }
  return html +
         "</table></div><p class='legend'>Missed instances over all runs that went well, by "
         "what kept them out of the map.</p>";
}

std::string Failures(const BatchView& view, const BatchReportInputs& inputs) {
  std::string html;
  std::size_t count = 0;
  for (const BatchRun& run : view.table.runs) {
    if (run.status == "ok" || ++count > kShownFailures) continue;
    const Result<std::string> log = ReadFile(inputs.folder / run.folder / "log.txt");
    std::string tail = log.ok() ? *log : "";
    if (tail.size() > kLogBytes) tail = "...\n" + tail.substr(tail.size() - kLogBytes);
    html += fmt::format(
        "<details><summary><span class='bad'>{}</span>: {}</summary><p>{} {}</p><pre>{}</pre>"
        "</details>",
        run.status, Escaped(RunTitle(view.table, run)), Escaped(run.reason), RunLinks(inputs, run),
        Escaped(tail));
  }
  if (html.empty()) return "";
  if (count > kShownFailures)
    html +=
        fmt::format("<p>and {} more; the table <i>provenance</i> of results.sqlite has all.</p>",
                    count - kShownFailures);
  return fmt::format("<h2>Failures ({})</h2>", count) + html;
}

std::string HowItWasMade(const BatchView& view, const BatchReportInputs& inputs) {
  std::map<std::string, int> hosts, programs;
  for (const BatchRun& run : view.table.runs) {
    if (run.host.empty()) continue;
    ++hosts[run.host];
    ++programs[run.recipe + ": " + run.program_version + ", build " + run.program_hash];
  }
  std::string html = "<h2>How it was made</h2><div class='scroll'><table>";
  const auto rows = [&](const char* what, const std::map<std::string, int>& counts) {
    for (const auto& [name, count] : counts)
      html += fmt::format("<tr><td>{}</td><td class='l'>{}</td><td>{} runs</td></tr>", what,
                          Escaped(name), count);
  };
  rows("host", hosts);
  rows("program", programs);
  return html + "</table></div><details><summary>Plan</summary><pre>" + Escaped(inputs.plan) +
         "</pre></details>";
}

}  // namespace

std::string EstimateInWords(const std::optional<MeanEstimate>& estimate) {
  if (!estimate) return "-";
  if (!estimate->low) return fmt::format("{:.2f}", estimate->mean);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]", estimate->mean, *estimate->low, *estimate->high);
}

std::string ProbabilityInWords(double p) {
  if (p < 0.001) return "< 0.001";
  return p < 0.1 ? fmt::format("{:.3f}", p) : fmt::format("{:.2f}", p);
}

std::string BatchReportHtml(const BatchView& view, const BatchReportInputs& inputs) {
  const std::string body = CardsOfBatch(view) + GateSection(view, inputs) + FigureTable(view) +
                           DifferenceTables(view) + BatchResponsesHtml(view) +
                           WorstTable(view, inputs) + CauseTable(view) + Failures(view, inputs) +
                           HowItWasMade(view, inputs);
  return HtmlPage(view.table.name.empty() ? "Batch" : view.table.name,
                  "A batch of runs of Plumbline", body);
}

}  // namespace plumbline
