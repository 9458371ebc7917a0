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
  const std::string line = OptionChanges(before, after);
  ASSERT_TRUE(ApplyOptionChanges(line, before).ok()) << line;
  EXPECT_EQ(OptionsToJson(before), OptionsToJson(after)) << line;
  EXPECT_EQ(OptionChanges(before, after), "");
}

TEST(OptionChanges, SayOldAndNew) {
  MapperOptions before, after;
  before.alpha = 2.5;
  after.alpha = 4;
  EXPECT_EQ(OptionChanges(before, after), R"({"alpha":[2.5,4.0]})");
  EXPECT_EQ(DescribeOptionChanges(OptionChanges(before, after)), "alpha 2.5 -> 4.0");
}

TEST(OptionChanges, RefuseWhatTheyDoNotKnow) {
  MapperOptions options;
  for (const char* line :
       {"alpha", "{", "{\"alpha\": 4}", "{\"alpha\": [1]}", "{\"no_such_option\": [1, 2]}"}) {
    EXPECT_FALSE(ApplyOptionChanges(line, options).ok()) << line;
    EXPECT_EQ(OptionsToJson(options), OptionsToJson(MapperOptions())) << line;
  }
}

TEST(MapperOptions, AreKnownByTheirFormerNames) {
  MapperOptions options;
  ASSERT_TRUE(SetOption("infant_particles=700", options).ok());
  ASSERT_TRUE(OptionsFromJson({{"min_birth_score", 0.25}, {"alpha", 3}}, options).ok());
  EXPECT_EQ(options.tentative_particles, 700);
  EXPECT_EQ(options.min_spawn_score, 0.25);
  ASSERT_TRUE(OptionsFromJson({{"birth_particles", 500}, {"spawn_particles", 600}}, options).ok());
  EXPECT_EQ(options.spawn_particles, 600);
}

TEST(OptionChanges, OfFormat1AreReadFromTheirLine) {
  MapperOptions options;
  const auto changes = OptionChangesFromFormat1("alpha 2.5 -> 4.0; floor_prior true -> false");
  ASSERT_TRUE(changes.ok());
  ASSERT_TRUE(ApplyOptionChanges(*changes, options).ok());
  EXPECT_EQ(options.alpha, 4.0);
  EXPECT_FALSE(options.floor_prior);
  for (const char* line : {"alpha", "alpha 1 -> ", "alpha 1 -> x", " -> 2"})
    EXPECT_FALSE(OptionChangesFromFormat1(line).ok()) << line;
}

}  // namespace
}  // namespace plumbline
