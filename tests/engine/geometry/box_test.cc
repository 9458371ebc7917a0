// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/box.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Box2, IsEmptyByDefaultAndHasNoArea) {
  EXPECT_TRUE(Box2().empty());
  EXPECT_EQ(Box2().area(), 0);
  EXPECT_TRUE((Box2{3, 3, 3, 9}).empty());
}

TEST(Iou, ComparesSharedAreaWithAllArea) {
  const Box2 a{0, 0, 10, 10}, b{5, 0, 15, 10}, far{20, 20, 30, 30};
  EXPECT_FLOAT_EQ(Iou(a, a), 1);
  EXPECT_FLOAT_EQ(Iou(a, b), 50.0f / 150.0f);
  EXPECT_EQ(Iou(a, far), 0);
  EXPECT_EQ(Iou(a, Box2()), 0);
  EXPECT_EQ(Iou(Box2(), Box2()), 0);
  EXPECT_EQ(Intersection(a, b), (Box2{5, 0, 10, 10}));
  EXPECT_TRUE(Intersection(a, far).empty());
}

}  // namespace
}  // namespace plumbline
