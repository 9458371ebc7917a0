// SPDX-License-Identifier: Apache-2.0
// Whole synthetic rooms: filmed, mapped from their images, compared with the truth. One room, or as
// many as PLUMBLINE_TEST_SEEDS says.

#include <cstdlib>
#include <iostream>

#include <gmock/gmock.h>

#include "tests/support/room_run.h"

namespace plumbline {
namespace {

/// Seeds that nothing was tuned to.
constexpr int kFirstSeed = 31;

int NumSeeds() {
  const char* text = std::getenv("PLUMBLINE_TEST_SEEDS");
  return text == nullptr ? 1 : std::max(1, std::atoi(text));
}

void ExpectFindsTheFurniture(const std::string& edges, double mean_m, double mean_deg) {
  RoomFigures all;
  int clean_rooms = 0;
  for (int seed = kFirstSeed; seed < kFirstSeed + NumSeeds(); ++seed) {
    const RoomFigures room =
        Judge(MapRoom(QuicklyLit(SyntheticScene::kRoom, static_cast<std::uint64_t>(seed)), edges));
    std::cout << "room " << seed << ": " << room.right << " of " << room.instances << " right, "
              << room.spurious << " spurious, " << 100 * room.sum_m / std::max(1, room.found)
              << " cm, " << room.sum_deg / std::max(1, room.found) << " deg\n"
              << room.text;
    all.instances += room.instances;
    all.right += room.right;
    all.found += room.found;
    all.sum_m += room.sum_m;
    all.sum_deg += room.sum_deg;
    clean_rooms += room.spurious == 0 ? 1 : 0;
  }
  ASSERT_GT(all.found, 0);
  EXPECT_GE(all.right, 0.9 * all.instances - (NumSeeds() == 1 ? 1 : 0));
  EXPECT_LT(all.sum_m / all.found, mean_m);
  EXPECT_LT(all.sum_deg / all.found, mean_deg);
  EXPECT_GE(clean_rooms, NumSeeds() == 1 ? 0 : 0.8 * NumSeeds());
}

TEST(Room, ItsFurnitureIsFoundFromEdgesOfTheImages) {
  ExpectFindsTheFurniture("gradient", 0.03, 3);
}

TEST(Room, ItsFurnitureIsFoundFromGivenEdges) { ExpectFindsTheFurniture("dataset", 0.015, 1.5); }

}  // namespace
}  // namespace plumbline
