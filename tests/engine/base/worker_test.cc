// SPDX-License-Identifier: Apache-2.0
#include "engine/base/worker.h"

#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Worker, DoesAllInOrderOnOneOtherThread) {
  std::vector<int> done;
  std::thread::id other;
  {
    Worker worker;
    for (int i = 0; i < 200; ++i) worker.Do([&done, i] { done.push_back(i); });
    other = worker.Do([] { return std::this_thread::get_id(); }).get();
    worker.Do([&done] { done.push_back(200); });
  }
  ASSERT_EQ(done.size(), 201u) << "the destructor waits for what was given";
  for (int i = 0; i <= 200; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  EXPECT_NE(other, std::this_thread::get_id());
}

TEST(Worker, HandsOnWhatATaskThrowsAndGoesOn) {
  Worker worker;
  auto broken = worker.Do([]() -> int { throw std::runtime_error("no"); });
  EXPECT_THROW(broken.get(), std::runtime_error);
  EXPECT_EQ(worker.Do([] { return 7; }).get(), 7);
}

}  // namespace
}  // namespace plumbline
