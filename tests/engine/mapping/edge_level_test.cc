// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/edge_level.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

void Look(EdgeLevel& level, const std::string& category, double surplus, int looks) {
  for (int i = 0; i < looks; ++i) level.Add(category, surplus, 1);
}

TEST(EdgeLevel, IsTheUsualOneBeforeAnythingIsSettled) {
  const EdgeLevel level;
  EXPECT_EQ(level.Of("chair"), EdgeLevel::kUsual);
}

TEST(EdgeLevel, FollowsWhatSettledObjectsHave) {
  EdgeLevel level;
  Look(level, "couch", 0.6, 100);
  EXPECT_NEAR(level.Of("couch"), 0.6, 1e-3);
  EXPECT_NEAR(level.Of("chair"), 0.6, 1e-3) << "no chair is settled: as all others";
  Look(level, "couch", 0.1, 100);
  EXPECT_EQ(level.Of("couch"), EdgeLevel::kUsual) << "never less";
}

TEST(EdgeLevel, ChairsAreMeasuredByChairsWhereTheyHaveLess) {
  EdgeLevel level;
  for (int i = 0; i < 100; ++i) {
    level.Add("cabinet", 0.7, 0.5);
    level.Add("chair", 0.3, 0.5);
  }
  EXPECT_NEAR(level.Of("chair"), 0.3, 0.02);
  EXPECT_GT(level.Of("cabinet"), 0.4) << "of all, not more";
  EXPECT_LT(level.Of("cabinet"), 0.6);
}

TEST(EdgeLevel, GoesOnFromWhatWasKept) {
  EdgeLevel level;
  Look(level, "dining table", 0.5, 7);
  Look(level, "chair", 0.3, 3);
  ByteWriter out;
  level.Save(out);
  const std::string bytes = out.Take();
  ByteReader in(bytes);
  EdgeLevel again;
  again.Restore(in);
  EXPECT_TRUE(in.ok());
  EXPECT_TRUE(in.rest().empty());
  for (const char* category : {"dining table", "chair", "couch"})
    EXPECT_EQ(again.Of(category), level.Of(category)) << category;
  ByteReader cut(std::string_view(bytes).substr(0, bytes.size() - 3));
  again.Restore(cut);
  EXPECT_FALSE(cut.ok());
}

}  // namespace
}  // namespace plumbline
