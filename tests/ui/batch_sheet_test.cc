// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/batch_sheet.h"

#include <gtest/gtest.h>

#include "tests/engine/batch/batch_of_tables.h"
#include "tests/ui/panel_harness.h"
#include "ui/inspect/compare/batch_plot.h"

namespace plumbline {
namespace {

/// The sheet as something that the harness can draw.
class BatchSheetPanel : public Panel {
 public:
  BatchSheetPanel() { sheet.Open(true); }
  void Draw(const FrameContext& context, CommandSink& sink) override {
    sheet.Draw(context, batch ? &*batch : nullptr, sink);
  }
  BatchSheet sheet;
  std::optional<ShownBatch> batch;
};

/// Figures of its recipes by hand.
ShownBatch BatchOfTwo(std::vector<std::string> options) {
  ShownBatch batch;
  batch.folder = "/batch";
  batch.view.table = TableOf({"a"}, {"x", "y"}, 2, std::move(options));
  const std::vector<std::vector<double>> points = {{1}, {2}};
  for (int recipe = 0; recipe < 2; ++recipe) {
    for (int figure = 0; figure < 2; ++figure) {
      MeanEstimate mean;
      mean.mean = 10 * recipe + figure;
      mean.low = mean.mean - 1;
      mean.high = mean.mean + 1;
      batch.view.means.push_back({recipe, figure, {}, mean});
      for (const auto& point : points) {
        mean.mean += 100;
        if (!batch.view.table.options.empty())
          batch.view.responses.push_back({recipe, figure, point, mean});
      }
    }
  }
  batch.view.worst = {2, 0};
  batch.view.table.runs[2].status = "failed";
  return batch;
}

TEST(BatchSheet, OpensARunThatWentWellAndNoOther) {
  PanelHarness harness;
  harness.ShowFrame(0);
  BatchSheetPanel panel;
  panel.batch = BatchOfTwo({});
  harness.Draw(panel, 3);
  harness.Click(panel, "batch.worst.0");
  EXPECT_EQ(harness.sink.Last<OpenCommand>(), nullptr) << "it has failed";
  harness.Click(panel, "batch.worst.1");
  const OpenCommand* open = harness.sink.Last<OpenCommand>();
  ASSERT_NE(open, nullptr);
  EXPECT_EQ(open->path, "/batch/jobs/0/run.plb");
  EXPECT_FALSE(panel.sheet.is_open());
}

TEST(BatchSheet, SaysWhatItCannotReadAndCloses) {
  PanelHarness harness;
  harness.ShowFrame(0);
  BatchSheetPanel panel;
  harness.Draw(panel, 3);
  EXPECT_EQ(harness.widgets.Find("batch.plot"), nullptr) << "it is being read";
  panel.batch.emplace();
  panel.batch->problem = "There is no such batch.";
  harness.Draw(panel, 3);
  EXPECT_NE(harness.widgets.Find("batch.problem"), nullptr);
  harness.Click(panel, "batch.close");
  EXPECT_FALSE(panel.sheet.is_open());
}

TEST(BatchPlot, ShowsRecipesSideBySide) {
  const IntervalPlot plot = PlotOf(BatchOfTwo({}).view, 1);
  EXPECT_EQ(plot.places, (std::vector<std::string>{"x", "y"}));
  ASSERT_EQ(plot.series.size(), 1U);
  EXPECT_EQ(plot.series[0].at[1]->mean, 11);
  EXPECT_EQ(plot.unit, "cm");
  EXPECT_EQ(plot.across, "");
}

TEST(BatchPlot, ShowsALineForEachRecipeOverWhatWasSwept) {
  const IntervalPlot plot = PlotOf(BatchOfTwo({"beta"}).view, 0);
  EXPECT_EQ(plot.across, "beta");
  EXPECT_EQ(plot.places, (std::vector<std::string>{"1", "2"}));
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_EQ(plot.series[1].name, "y");
  EXPECT_EQ(plot.series[1].at[0]->mean, 110);
  EXPECT_EQ(plot.series[1].at[1]->mean, 210);
  EXPECT_TRUE(PlotOf(BatchOfTwo({}).view, 99).series.empty());
}

}  // namespace
}  // namespace plumbline
