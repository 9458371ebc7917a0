// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/endpoint.h"

#include <string>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Endpoint, KnowsWhatThisMachineAloneCanReach) {
  for (const char* local : {"ipc://graph/player", "ipc://my graph/player", "tcp://127.0.0.1:7000",
                            "tcp://127.9.8.7:1", "tcp://localhost:65535", "tcp://[::1]:7000"}) {
    const auto endpoint = Endpoint::Parse(local);
    ASSERT_TRUE(endpoint.ok()) << local;
    EXPECT_TRUE(endpoint->is_local()) << local;
  }
  for (const char* open :
       {"tcp://*:7000", "tcp://0.0.0.0:7000", "tcp://10.0.0.2:7000", "tcp://127.evil.example:7000",
        "tcp://[::]:7000", "tcp://127.0.0.1.example.org:80", "tcp://localhost.example.org:80"}) {
    const auto endpoint = Endpoint::Parse(open);
    ASSERT_TRUE(endpoint.ok()) << open;
    EXPECT_FALSE(endpoint->is_local()) << open;
  }
}

TEST(Endpoint, RefusesWhatIsNone) {
  for (const std::string& wrong :
       {std::string(""), std::string("player"), std::string("ipc://"), std::string("ipc://@hidden"),
        "ipc://" + std::string(200, 'a'), std::string("tcp://127.0.0.1"),
        std::string("tcp://127.0.0.1:0"), std::string("tcp://127.0.0.1:70000"),
        std::string("tcp://127.0.0.1:7x"), std::string("tcp://:7000"),
        std::string("udp://127.0.0.1:7000"), std::string("inproc://zeromq.zap.01"),
        std::string("tcp://a;b:1"), std::string("tcp://a b:1"),
        std::string("tcp://127.0.0.1:1\n")}) {
    const auto endpoint = Endpoint::Parse(wrong);
    ASSERT_FALSE(endpoint.ok()) << wrong;
    EXPECT_NE(endpoint.error().message.find("tcp://HOST:PORT"), std::string::npos);
  }
}

}  // namespace
}  // namespace plumbline
