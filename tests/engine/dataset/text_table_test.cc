// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/text_table.h"

#include <gmock/gmock.h>

namespace plumbline {
namespace {

using testing::ElementsAre;

TEST(ParseStampNs, KeepsEveryNanosecondOfDecimalSeconds) {
  EXPECT_EQ(ParseStampNs("1403636579.763555584"), 1403636579763555584);
  EXPECT_EQ(ParseStampNs("0.1"), 100000000);
  EXPECT_EQ(ParseStampNs("0"), 0);
  EXPECT_EQ(ParseStampNs("12"), 12000000000);
  EXPECT_EQ(ParseStampNs("-1.5"), -1500000000);
  EXPECT_EQ(ParseStampNs("+.25"), 250000000);
  EXPECT_EQ(ParseStampNs("3."), 3000000000);
}

TEST(ParseStampNs, RoundsDigitsBeyondNanoseconds) {
  EXPECT_EQ(ParseStampNs("0.0333333333333"), 33333333);
  EXPECT_EQ(ParseStampNs("0.0000000005"), 1);
  EXPECT_EQ(ParseStampNs("0.00000000049"), 0);
  EXPECT_EQ(ParseStampNs("1.9999999999"), 2000000000);
}

TEST(ParseStampNs, TakesLongWholeNumbersForNanoseconds) {
  EXPECT_EQ(ParseStampNs("1403636579763555584"), 1403636579763555584);
  EXPECT_EQ(ParseStampNs("1000000000001"), 1000000000001);
  EXPECT_EQ(ParseStampNs("1403636579"), 1403636579000000000);
}

TEST(ParseStampNs, ReadsExponents) {
  EXPECT_EQ(ParseStampNs("1.403636579763555584e+09"), 1403636579763555584);
  EXPECT_EQ(ParseStampNs("5e-3"), 5000000);
  EXPECT_EQ(ParseStampNs("0e30"), 0);
}

TEST(ParseStampNs, RefusesWhatIsNoStamp) {
  for (const char* text :
       {"", "-", ".", "nan", "inf", "1.2.3", "12a", "1e", "1e99", "99999999999.5", "0x10", "1 2"}) {
    EXPECT_EQ(ParseStampNs(text), std::nullopt) << text;
  }
}

TEST(ParseNumber, TakesTheWholeFieldOrNothing) {
  EXPECT_EQ(ParseNumber("-1.5e3"), -1500);
  EXPECT_EQ(ParseNumber("+2"), 2);
  EXPECT_TRUE(std::isnan(*ParseNumber("nan")));
  EXPECT_EQ(ParseNumber("1,5"), std::nullopt);
  EXPECT_EQ(ParseNumber(""), std::nullopt);
  EXPECT_EQ(ParseNumber("1m"), std::nullopt);
}

TEST(SplitLines, TakesAnyLineEndAndNoByteOrderMark) {
  EXPECT_THAT(SplitLines("\xef\xbb\xbf"
                         "a\r\nb\n\nc"),
              ElementsAre("a", "b", "", "c"));
  EXPECT_TRUE(SplitLines("").empty());
}

TEST(SplitFields, TakesCommasAndBlanks) {
  EXPECT_THAT(SplitFields(" 1, 2\t3,,4 "), ElementsAre("1", "2", "3", "4"));
  EXPECT_TRUE(SplitFields("  ").empty());
}

TEST(LineWarnings, SaysEachKindOnce) {
  LineWarnings warnings("f.txt");
  warnings.Add("odd", 3);
  warnings.Add("even", 4);
  warnings.Add("odd", 5);
  EXPECT_THAT(warnings.Sentences(),
              ElementsAre("'f.txt' line 3 (and 1 more): odd", "'f.txt' line 4: even"));
}

}  // namespace
}  // namespace plumbline
