// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/angle_text.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(NumberText, GivesZeroNoSign) {
  EXPECT_EQ(NumberText(-0.004, 2), "0.00");
  EXPECT_EQ(NumberText(-0.4, 0), "0");
  EXPECT_EQ(NumberText(-0.006, 2), "-0.01");
  EXPECT_EQ(NumberText(-10, 0), "-10");
}

TEST(AngleText, StaysWithinHalfATurn) {
  EXPECT_EQ(AngleText(kRadPerDeg * 190), "-170\u00b0");
  EXPECT_EQ(AngleText(kRadPerDeg * -190), "170\u00b0");
  EXPECT_EQ(AngleText(kRadPerDeg * 725, 1), "5.0\u00b0");
  EXPECT_EQ(AngleText(kRadPerDeg * -179.7), "180\u00b0") << "after rounding, too";
  EXPECT_EQ(AngleText(kRadPerDeg * -0.3), "0\u00b0");
  EXPECT_EQ(AngleText(kRadPerDeg * -179.7, 1), "-179.7\u00b0");
  EXPECT_EQ(AngleText(kRadPerDeg * -18), "-18\u00b0");
}

}  // namespace
}  // namespace plumbline
