// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/option_changes.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(OptionChanges, AreReadBackBitForBit) {
  MapperOptions before, after;
  after.alpha = 0.1 + 0.2;
  after.particles = 321;
  after.floor_prior = !before.floor_prior;
  after.prior = static_cast<decltype(after.prior)>(1 - static_cast<int>(before.prior));
  const std::string line = DescribeOptionChanges(before, after);
  ASSERT_TRUE(ApplyOptionChanges(line, before).ok()) << line;
  EXPECT_EQ(OptionsToJson(before), OptionsToJson(after)) << line;
  EXPECT_EQ(DescribeOptionChanges(before, after), "");
}

TEST(OptionChanges, SayOldAndNew) {
  MapperOptions before, after;
  before.alpha = 2.5;
  after.alpha = 4;
  EXPECT_EQ(DescribeOptionChanges(before, after), "alpha 2.5 -> 4.0");
}

TEST(OptionChanges, RefuseWhatTheyDoNotKnow) {
  MapperOptions options;
  for (const char* line : {"alpha", "alpha 1 -> ", "alpha 1 -> x", "no_such_option 1 -> 2"}) {
    EXPECT_FALSE(ApplyOptionChanges(line, options).ok()) << line;
    EXPECT_EQ(OptionsToJson(options), OptionsToJson(MapperOptions())) << line;
  }
}

}  // namespace
}  // namespace plumbline
