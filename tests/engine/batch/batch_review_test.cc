// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_review.h"

#include <gmock/gmock.h>

#include "tests/engine/batch/batch_of_tables.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFound = 0, kTranslation = 1;

const BatchDifference& RowOf(const std::vector<BatchDifference>& rows, int figure) {
  return *std::find_if(rows.begin(), rows.end(),
                       [&](const BatchDifference& row) { return row.figure == figure; });
}

TEST(BatchReview, TellsARecipeThatIsWorse) {
  BatchTable table = TableOf({"a", "b", "c"}, {"x", "y"}, 8, {});
  for (BatchRun& run : table.runs) {
    if (run.recipe == "y") *run.figures[kTranslation] += 0.5;
  }
  const BatchView view = ReviewBatch(table);
  const BatchDifference& off = RowOf(view.differences, kTranslation);
  EXPECT_TRUE(off.worse);
  EXPECT_NEAR(off.difference.mean.mean, 0.5, 0.25);  // 0.2 sqrt(2 / 24), four times
  EXPECT_EQ(off.difference.mean.values, 24);
  EXPECT_EQ(off.worst_runs.size(), 5U);
  EXPECT_FALSE(RowOf(view.differences, kFound).worse);
}

TEST(BatchReview, GivesAResponseAtEachPoint) {
  BatchTable table = TableOf({"a", "b"}, {"x"}, 4, {"beta"});
  for (BatchRun& run : table.runs) *run.figures[kTranslation] = run.point[0] * 10;
  const BatchView view = ReviewBatch(table);
  std::vector<double> means;
  for (const BatchEstimate& estimate : view.responses) {
    if (estimate.figure == kTranslation) means.push_back(estimate.mean->mean);
  }
  EXPECT_THAT(means, ElementsAre(10, 20));
}

TEST(BatchReview, PutsFailedRunsFirstAmongTheWorst) {
  BatchTable table = TableOf({"a", "b"}, {"x"}, 4, {});
  table.runs[5].status = "lost";
  EXPECT_EQ(ReviewBatch(table).worst.front(), 5);
}

TEST(BatchGate, IsSilentAboutTheSameAndAboutChance) {
  const BatchTable table = TableOf({"a", "b", "c"}, {"x"}, 8, {});
  const auto same = GateBatch(table, table, {"found", "translation"}).value();
  EXPECT_EQ(same.worse, 0);
  EXPECT_EQ(same.pairs, 24);
  EXPECT_THAT(same.remarks, IsEmpty());
  BatchTable other = table;
  for (std::size_t i = 0; i < other.runs.size(); ++i)
    other.runs[i].figures = table.runs[table.runs.size() - 1 - i].figures;
  EXPECT_EQ(GateBatch(table, other, {"found", "translation"})->worse, 0);
}

TEST(BatchGate, CatchesAFigureThatGotWorseAndNotOneThatGotBetter) {
  const BatchTable before = TableOf({"a", "b", "c"}, {"x"}, 8, {});
  BatchTable now = before;
  Random random({.seed = 3});
  for (BatchRun& run : now.runs) {
    *run.figures[kFound] += 5 + random.Gaussian();
    *run.figures[kTranslation] += 0.2 + 0.1 * random.Gaussian();
  }
  const auto gate = GateBatch(now, before, {"found", "translation"}).value();
  EXPECT_EQ(gate.worse, 1);
  EXPECT_FALSE(RowOf(gate.rows, kFound).worse);
  EXPECT_TRUE(RowOf(gate.rows, kTranslation).worse);
  EXPECT_EQ(GateBatch(before, now, {"found", "translation"})->worse, 1) << "the other way round";
}

TEST(BatchGate, SaysWhereNothingCouldBeSignificant) {
  const BatchTable before = TableOf({"a"}, {"x"}, 3, {});
  BatchTable now = before;
  for (BatchRun& run : now.runs) *run.figures[kTranslation] += 100;
  const auto gate = GateBatch(now, before, {"translation"}).value();
  EXPECT_EQ(gate.worse, 0);
  EXPECT_THAT(gate.remarks, ElementsAre(HasSubstr("so few pairs")));
}

TEST(BatchGate, TellsOfRunsWithoutACounterpart) {
  const BatchTable table = TableOf({"a", "b"}, {"x"}, 8, {});
  const BatchTable shorter = TableOf({"a", "b"}, {"x"}, 6, {});
  const auto gate = GateBatch(table, shorter, {"found"}).value();
  EXPECT_EQ(gate.pairs, 12);
  EXPECT_THAT(gate.remarks, ElementsAre("4 runs are in this batch only"));
  const auto none = GateBatch(table, TableOf({"c"}, {"x"}, 8, {}), {"found"});
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("counterpart"));
  EXPECT_FALSE(GateBatch(table, table, {"fond"}).ok());
}

TEST(BatchGate, RunsThatHaveNoValueAreCounted) {
  const BatchTable before = TableOf({"a", "b"}, {"x"}, 8, {});
  BatchTable now = before;
  now.runs[0].figures[kTranslation] = std::nullopt;
  const auto gate = GateBatch(now, before, {"translation"}).value();
  EXPECT_EQ(gate.rows[0].unpaired, 1);
  EXPECT_EQ(gate.rows[0].difference.mean.values, 15);
  for (BatchRun& run : now.runs) run.figures[kTranslation] = std::nullopt;
  EXPECT_THAT(GateBatch(now, before, {"found", "translation"})->remarks,
              ElementsAre(HasSubstr("'translation' of 'x' is not tested")));
}

}  // namespace
}  // namespace plumbline
