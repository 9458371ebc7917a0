// SPDX-License-Identifier: Apache-2.0
#include "engine/models/thing_table.h"

#include <gmock/gmock.h>

#include <string>

namespace plumbline {
namespace {

std::string NameIn(std::string_view name) {
  const Thing* thing = ThingInName(name);
  return thing == nullptr ? "" : std::string(thing->name);
}

TEST(ThingTable, WholeWordsAndSynonymsSayWhatAThingIs) {
  EXPECT_EQ(NameIn("office_chair"), "chair");
  EXPECT_EQ(NameIn("SofaB_01"), "couch");
  EXPECT_EQ(NameIn("kitchenTable-2"), "dining table");
  EXPECT_EQ(NameIn("mug_pattern"), "cup");
  EXPECT_EQ(NameIn("Plant"), "potted plant");
  EXPECT_EQ(NameIn("two chairs"), "chair");
  EXPECT_EQ(NameIn("aws_TV_01_visual"), "tv");
  EXPECT_EQ(NameIn("LGTelevision55"), "tv");
  EXPECT_EQ(NameIn("fridge"), "refrigerator");
  EXPECT_EQ(NameIn("potted_plant"), "potted plant");
}

TEST(ThingTable, TheLastWordThatNamesAThingDecides) {
  EXPECT_EQ(NameIn("TVCabinet_01"), "cabinet");
  EXPECT_EQ(NameIn("tv_stand"), "sideboard");
  EXPECT_EQ(NameIn("NightStand_01"), "nightstand");
  EXPECT_EQ(NameIn("coffee table"), "coffee table");
  EXPECT_EQ(NameIn("wine_glass"), "wine glass");
  EXPECT_EQ(NameIn("laptop_bag"), "") << "a bag, which is none that is known";
  EXPECT_EQ(NameIn("chair_cushion"), "");
}

TEST(ThingTable, WordsWithinWordsSayNothing) {
  EXPECT_EQ(NameIn("BookshelfC_01"), "shelf");
  EXPECT_EQ(NameIn("cupboard"), "cabinet");
  EXPECT_EQ(NameIn("bedroom"), "");
  EXPECT_EQ(NameIn("stable"), "");
  EXPECT_EQ(NameIn("ottavio"), "");
  EXPECT_EQ(NameIn(""), "");
}

TEST(ThingTable, EverySynonymNamesAThingOrNone) {
  // Reached by their words: a name that is misspelt in the table would be nullptr.
  for (const char* word : {"sofa", "mug", "monitor", "barstool", "bookcase", "closet", "drawers",
                           "hob", "dishwasher", "pc", "gamepad", "crate", "carpet", "poster"}) {
    EXPECT_NE(ThingInName(word), nullptr) << word;
  }
}

}  // namespace
}  // namespace plumbline
