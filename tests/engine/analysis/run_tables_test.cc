// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/run_tables.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(RunTables, NameEveryKindOfEvent) {
  RunReview review;
  review.events = {{0, 3, {EventKind::kSpawned, {1}, {}, "proposal 0.8"}},
                   {0, 4, {EventKind::kFrameSkipped, {}, {}, "no pose"}},
                   {1, 5, {EventKind::kOptionsChanged, {}, {}, "alpha 1 -> 2"}}};
  EXPECT_EQ(EventsCsv(review),
            "frame,event,id,other_id,text\n"
            "3,spawned,1,,proposal 0.8\n"
            "4,frame_skipped,,,no pose\n"
            "5,options_changed,,,alpha 1 -> 2\n");
}

}  // namespace
}  // namespace plumbline
