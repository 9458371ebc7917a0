// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/stamp_watch.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

using Verdict = StampWatch::Verdict;

TEST(StampWatch, ALateStampIsNoJump) {
  StampWatch watch(3);
  EXPECT_EQ(watch.Add(10), Verdict::kRises);
  EXPECT_EQ(watch.Add(20), Verdict::kRises);
  for (int twice = 0; twice < 5; ++twice) EXPECT_EQ(watch.Add(20), Verdict::kLate);
  EXPECT_EQ(watch.Add(15), Verdict::kLate);
  EXPECT_EQ(watch.Add(30), Verdict::kRises);
}

TEST(StampWatch, LateStampsThatRiseAreAClockThatWasSetBack) {
  StampWatch watch(3);
  for (int k = 0; k < 10; ++k) watch.Add(100 + 10 * k);  // the next would be 200
  EXPECT_EQ(watch.Add(150), Verdict::kLate);
  EXPECT_EQ(watch.Add(160), Verdict::kLate);
  EXPECT_EQ(watch.Add(170), Verdict::kJumpedBack);
  EXPECT_EQ(watch.jump_ns(), 50);
  EXPECT_EQ(watch.Add(180), Verdict::kRises);
}

}  // namespace
}  // namespace plumbline
