// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_results.h"

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/engine/batch/batch_of_tables.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

TEST(BatchResults, WhatIsWrittenIsReadAgain) {
  const TemporaryFolder folder;
  BatchTable table = TableOf({"a", "b"}, {"x", "y"}, 2, {"beta"});
  table.runs[1].status = "failed";
  table.runs[1].reason = "it's \"wrong\"";
  table.runs[2].figures[1] = std::nullopt;
  table.runs[2].missed = {{"chair-1", "chair", "never_boxed", "No box."}};
  table.runs[3].run_s = 1.5;
  ASSERT_TRUE(WriteBatchResults(folder.path() / kBatchResults, table).ok());
  const BatchTable read = ReadBatchResults(folder.path()).value();
  EXPECT_EQ(read.sequences, table.sequences);
  EXPECT_EQ(read.recipes, table.recipes);
  EXPECT_EQ(read.options, table.options);
  ASSERT_EQ(read.figures.size(), table.figures.size());
  EXPECT_EQ(read.figures[1].better, table.figures[1].better);
  ASSERT_EQ(read.runs.size(), table.runs.size());
  for (std::size_t i = 0; i < read.runs.size(); ++i) {
    EXPECT_EQ(read.runs[i].sequence, table.runs[i].sequence);
    EXPECT_EQ(read.runs[i].recipe, table.runs[i].recipe);
    EXPECT_EQ(read.runs[i].point, table.runs[i].point);
    EXPECT_EQ(read.runs[i].seed, table.runs[i].seed);
    EXPECT_EQ(read.runs[i].status, table.runs[i].status);
    EXPECT_EQ(read.runs[i].figures, table.runs[i].figures);
    EXPECT_EQ(read.runs[i].folder, table.runs[i].folder);
    EXPECT_EQ(read.runs[i].run_s, table.runs[i].run_s);
  }
  EXPECT_EQ(read.runs[1].reason, "it's \"wrong\"");
  ASSERT_EQ(read.runs[2].missed.size(), 1U);
  EXPECT_EQ(read.runs[2].missed[0].text, "No box.");
}

TEST(BatchResults, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  const auto nothing = ReadBatchResults(folder.path());
  ASSERT_FALSE(nothing.ok());
  EXPECT_EQ(nothing.error().code, ErrorCode::kNotFound);
  const std::filesystem::path file = folder.path() / "x.sqlite";
  ASSERT_TRUE(WriteFileAtomically(file, "this is a text and no table at all, of some length").ok());
  const auto text = ReadBatchResults(file);
  ASSERT_FALSE(text.ok());
  EXPECT_THAT(text.error().message, HasSubstr("holds no results of a batch"));
}

TEST(BatchResults, ATruncatedFileIsAnError) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / kBatchResults;
  ASSERT_TRUE(WriteBatchResults(file, TableOf({"a", "b"}, {"x"}, 30, {})).ok());
  const std::string whole = ReadFile(file).value();
  ASSERT_TRUE(WriteFileAtomically(file, whole.substr(0, whole.size() / 2)).ok());
  EXPECT_FALSE(ReadBatchResults(file).ok());
}

}  // namespace
}  // namespace plumbline
