// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/requests_ahead.h"

#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/nodes/remote_sequence.h"
#include "engine/transport/node_server.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

/// Notes which frames it was asked for, and answers them.
class NotingNode {
 public:
  explicit NotingNode(const Endpoint& endpoint)
      : server_(NodeServer::Listen(context_, endpoint, [](wire::About&) {}).value()),
        client_(NodeClient::Connect(context_, "noting", endpoint).value()),
        thread_([this](const std::stop_token& stop) {
          while (const auto asked = server_->Next(stop)) {
            const int frame = asked->request.image().frame();
            {
              const std::lock_guard lock(mutex_);
              asked_.push_back(frame);
            }
            wire::Reply reply;
            reply.mutable_image()->set_frame(frame);
            server_->Answer(*asked, std::move(reply));
          }
        }) {}

  NodeClient& client() { return *client_; }
  std::vector<int> asked() {
    const std::lock_guard lock(mutex_);
    return asked_;
  }
  int most() {
    const auto all = asked();
    return all.empty() ? -1 : *std::max_element(all.begin(), all.end());
  }

 private:
  std::shared_ptr<SocketContext> context_ = SocketContext::Create().value();
  std::unique_ptr<NodeServer> server_;
  std::unique_ptr<NodeClient> client_;
  std::mutex mutex_;
  std::vector<int> asked_;
  std::jthread thread_;
};

class RequestsAheadTest : public testing::Test {
 protected:
  int Get(RequestsAhead& requests, int frame) {
    const auto reply = requests.Get(frame, {});
    return reply.ok() ? (*reply)->image().frame() : -1;
  }

  TemporaryFolder folder_;
  NotingNode node_{Endpoint::Parse("ipc://" + (folder_.path() / "node").string()).value()};
};

TEST_F(RequestsAheadTest, AskForEveryFrameOnceAndNeverForMoreThanTheWindow) {
  RequestsAhead requests(node_.client(), {.begin = 2, .end = 20, .step = 3, .window = 3},
                         ImageRequestOf);
  for (int frame = 2; frame < 20; frame += 3) {
    EXPECT_EQ(Get(requests, frame), frame);
    EXPECT_LE(node_.most(), frame + 6);
  }
  EXPECT_EQ(node_.asked(), (std::vector<int>{2, 5, 8, 11, 14, 17}));
}

TEST_F(RequestsAheadTest, GoOnFromAnyFrameAndLookBack) {
  RequestsAhead requests(node_.client(), {.begin = 0, .end = 100, .step = 1, .window = 2},
                         ImageRequestOf);
  EXPECT_EQ(Get(requests, 50), 50);
  EXPECT_EQ(Get(requests, 7), 7) << "a key frame of the past";
  EXPECT_EQ(Get(requests, 51), 51);
  EXPECT_EQ(Get(requests, 60), 60);
  EXPECT_EQ(Get(requests, 61), 61);
  const auto asked = node_.asked();
  EXPECT_EQ(std::count(asked.begin(), asked.end(), 51), 1) << "asked for ahead, and not again";
}

}  // namespace
}  // namespace plumbline
