// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/live_pace.h"

#include <thread>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using Time = LivePace::Clock::time_point;

constexpr Time At(int ms) { return Time(milliseconds(ms)); }

TEST(LivePace, TakesTheFirstImageAtOnce) {
  LivePace pace;
  EXPECT_TRUE(pace.WaitToTake({}));
}

TEST(LivePace, HasTheImageReadyWhenItsConsumerIsDone) {
  LivePace pace;
  pace.Asked(At(0));
  pace.Made(milliseconds(20));
  pace.Given(At(20));
  EXPECT_EQ(pace.TakeAt(), At(20)) << "nobody knows yet how long the consumer takes";
  pace.Asked(At(120));
  pace.Given(At(121));
  EXPECT_EQ(pace.TakeAt(), At(121 + 100 - 20));
  pace.Made(milliseconds(150));
  EXPECT_EQ(pace.TakeAt(), At(121)) << "making it takes longer than using it";
}

TEST(LivePace, DoesNotKeepAWaitingConsumerWaiting) {
  LivePace pace;
  pace.Given(LivePace::Clock::now() - hours(1));
  pace.Asked();  // an hour, this time
  pace.Given();
  std::jthread consumer([&] { pace.Asked(); });
  EXPECT_TRUE(pace.WaitToTake({})) << "within the hour";
}

TEST(LivePace, MakesNoSecondImageReadyWhileOneIsUnused) {
  LivePace pace;
  pace.Asked();
  pace.Made(milliseconds(1));
  bool used = false;
  std::jthread consumer([&] {
    std::this_thread::sleep_for(milliseconds(5));
    used = true;
    pace.Given();
  });
  EXPECT_TRUE(pace.WaitToTake({}));
  EXPECT_TRUE(used);
  pace.Made(milliseconds(1));
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_FALSE(pace.WaitToTake(stop.get_token())) << "nobody uses it any more";
}

TEST(LivePace, StopsWaitingWhenAskedTo) {
  LivePace pace;
  pace.Given(LivePace::Clock::now() - hours(1));
  pace.Asked();
  pace.Given();
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_FALSE(pace.WaitToTake(stop.get_token()));
}

}  // namespace
}  // namespace plumbline
