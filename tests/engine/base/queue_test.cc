// SPDX-License-Identifier: Apache-2.0
#include "engine/base/queue.h"

#include <atomic>
#include <chrono>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

using namespace std::chrono_literals;

TEST(BoundedQueue, GivesItemsInOrder) {
  BoundedQueue<std::string> queue(3);
  for (const char* item : {"a", "b", "c"}) EXPECT_TRUE(queue.Push(item));
  EXPECT_EQ(queue.Pop(), "a");
  EXPECT_EQ(queue.TryPop(), "b");
  EXPECT_EQ(queue.Pop(), "c");
  EXPECT_EQ(queue.TryPop(), std::nullopt);
}

TEST(BoundedQueue, HoldsTheProducerBackWhenFull) {
  BoundedQueue<int> queue(1);
  std::atomic<int> pushed = 0;
  std::jthread producer([&] {
    for (int i = 0; i < 3; ++i) {
      queue.Push(i);
      ++pushed;
    }
  });
  while (pushed == 0) std::this_thread::yield();
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(pushed, 1);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.Pop(), i);
}

TEST(BoundedQueue, StillGivesWhatIsInsideAfterClosing) {
  BoundedQueue<int> queue(2);
  queue.Push(1);
  queue.Push(2);
  queue.Close();
  EXPECT_FALSE(queue.Push(3));
  EXPECT_EQ(queue.Pop(), 1);
  EXPECT_EQ(queue.Pop(), 2);
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

TEST(BoundedQueue, WakesThoseWhoWaitWhenItCloses) {
  BoundedQueue<int> empty(1), full(1);
  full.Push(1);
  std::optional<int> popped = 7;
  bool pushed = true;
  {
    std::jthread consumer([&] { popped = empty.Pop(); });
    std::jthread producer([&] { pushed = full.Push(2); });
    std::this_thread::sleep_for(5ms);
    empty.Close();
    full.Close();
  }
  EXPECT_EQ(popped, std::nullopt);
  EXPECT_FALSE(pushed);
}

TEST(BoundedQueue, LosesAndDoublesNothingBetweenManyThreads) {
  constexpr int kThreads = 4, kItems = 2000;
  BoundedQueue<int> queue(8);
  std::atomic<std::int64_t> sum = 0, count = 0;
  {
    std::vector<std::jthread> consumers;
    for (int t = 0; t < kThreads; ++t) {
      consumers.emplace_back([&] {
        while (const std::optional<int> item = queue.Pop()) {
          sum += *item;
          ++count;
        }
      });
    }
    {
      std::vector<std::jthread> producers;
      for (int t = 0; t < kThreads; ++t) {
        producers.emplace_back([&, t] {
          for (int i = 0; i < kItems; ++i) queue.Push(t * kItems + i);
        });
      }
    }
    queue.Close();
  }
  constexpr std::int64_t kAll = kThreads * kItems;
  EXPECT_EQ(count, kAll);
  EXPECT_EQ(sum, kAll * (kAll - 1) / 2);
}

TEST(SnapshotSlot, GivesTheNewestAndKeepsTheOldForWhoHoldsIt) {
  SnapshotSlot<int> slot;
  EXPECT_EQ(slot.Latest(), nullptr);
  slot.Publish(std::make_shared<int>(1));
  const std::shared_ptr<const int> old = slot.Latest();
  slot.Publish(std::make_shared<int>(2));
  EXPECT_EQ(*old, 1);
  EXPECT_EQ(*slot.Latest(), 2);
}

}  // namespace
}  // namespace plumbline
