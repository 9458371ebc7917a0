// SPDX-License-Identifier: Apache-2.0
// A server and its clients, in one program.
#include <chrono>
#include <thread>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include <gmock/gmock.h>

#include "engine/transport/message_checks.h"
#include "engine/transport/node_client.h"
#include "engine/transport/node_server.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using std::chrono::milliseconds;

wire::Request AskForImage(int frame) {
  wire::Request request;
  request.mutable_image()->set_frame(frame);
  return request;
}

/// Answers every image with its frame and nothing else.
class EchoNode {
 public:
  EchoNode(const std::shared_ptr<SocketContext>& context, const Endpoint& endpoint,
           const NodeServerOptions& options = {})
      : server_(NodeServer::Listen(
                    context, endpoint, [](wire::About& about) { about.set_name("echo"); }, options)
                    .value()),
        thread_([this](const std::stop_token& stop) {
          while (const auto asked = server_->Next(stop)) {
            wire::Reply reply;
            reply.mutable_image()->set_frame(asked->request.image().frame());
            server_->Answer(*asked, std::move(reply));
          }
        }) {}

 private:
  std::unique_ptr<NodeServer> server_;
  std::jthread thread_;
};

class NodeSockets : public testing::Test {
 protected:
  Endpoint Place(const std::string& name = "echo") const {
    return Endpoint::Parse("ipc://" + (folder_.path() / name).string()).value();
  }
  std::unique_ptr<NodeClient> Client() const {
    return NodeClient::Connect(context_, "echo", Place()).value();
  }
  /// A peer that sends what it likes.
  std::string AskRaw(const std::vector<std::string>& parts) const {
    zmq::socket_t socket(context_->zmq(), zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::rcvtimeo, 5000);
    socket.connect(Place().text());
    for (std::size_t i = 0; i < parts.size(); ++i)
      socket.send(zmq::buffer(parts[i]),
                  i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    std::vector<zmq::message_t> reply;
    if (!zmq::recv_multipart(socket, std::back_inserter(reply))) return "";
    return reply.back().to_string();
  }

  TemporaryFolder folder_;
  std::shared_ptr<SocketContext> context_ = SocketContext::Create().value();
};

TEST_F(NodeSockets, AskedBeforeTheNodeIsThereTheyWaitForIt) {
  const auto client = Client();
  auto early = client->Ask(AskForImage(3));
  EXPECT_EQ(early.wait_for(milliseconds(100)), std::future_status::timeout);
  const EchoNode node(context_, Place());
  const auto reply = WaitFor(early, {});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ((*reply)->image().frame(), 3);
  EXPECT_TRUE(client->health().connected());
}

TEST_F(NodeSockets, WhatANodeDiedOverIsAskedAgain) {
  const auto client = Client();
  std::vector<std::future<Result<SharedReply>>> replies;
  {
    const auto mute = NodeServer::Listen(context_, Place(), [](wire::About&) {}).value();
    for (int i = 0; i < 5; ++i) replies.push_back(client->Ask(AskForImage(i)));
    std::stop_source never;
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(mute->Next(never.get_token()).has_value());
  }
  const EchoNode node(context_, Place());
  for (int i = 0; i < 5; ++i) {
    const auto reply = WaitFor(replies[static_cast<std::size_t>(i)], {});
    ASSERT_TRUE(reply.ok());
    EXPECT_EQ((*reply)->image().frame(), i);
  }
  EXPECT_EQ(client->health().asked_again(), 5u);
  EXPECT_EQ(client->health().connections(), 2u);
}

TEST_F(NodeSockets, WhoStopsWaitingIsTold) {
  const auto client = Client();
  std::stop_source stop;
  std::jthread later([&] {
    std::this_thread::sleep_for(milliseconds(80));
    stop.request_stop();
  });
  EXPECT_EQ(client->AskAndWait(AskForImage(1), stop.get_token()).error().code,
            ErrorCode::kCancelled);
}

TEST_F(NodeSockets, ABusyNodeStillSaysHowItIs) {
  const auto busy = NodeServer::Listen(context_, Place(), [](wire::About& about) {
                      about.set_state("busy");
                    }).value();
  const auto client = Client();
  auto waits = client->Ask(AskForImage(1));
  wire::Request request;
  request.mutable_about();
  const auto reply = client->AskAndWait(request, {});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ((*reply)->about().state(), "busy");
  EXPECT_EQ((*reply)->about().served().waiting(), 1u);
}

TEST_F(NodeSockets, MalformedOldFutureAndHugeMessagesAreRefusedAndCounted) {
  const EchoNode node(context_, Place());
  wire::Request future;
  future.set_version(kWireVersion + 1);
  future.set_id(11);
  future.mutable_image();
  const auto refusal_of = [&](const std::vector<std::string>& parts) {
    const auto reply = ParseReply(AskRaw(parts));
    return reply.ok() && reply->has_refusal() ? reply->refusal().sentence() : std::string();
  };
  EXPECT_THAT(refusal_of({"", "no message"}), testing::HasSubstr("plumbline.proto"));
  EXPECT_THAT(refusal_of({"no envelope"}), testing::HasSubstr("other parts"));
  EXPECT_THAT(refusal_of({"", "a", "b"}), testing::HasSubstr("other parts"));
  EXPECT_THAT(refusal_of({"", future.SerializeAsString()}), testing::HasSubstr("version 2"));
  EXPECT_THAT(refusal_of({"", std::string(kMostRequestBytes + 1, 'x')}),
              testing::HasSubstr("are taken at most"));
  EXPECT_EQ(AskRaw({"", std::string(std::size_t{65} << 20, 'x')}), "") << "the connection ends";
  const auto client = Client();
  wire::Request request;
  request.mutable_about();
  const auto reply = client->AskAndWait(request, {});
  ASSERT_TRUE(reply.ok()) << "the node goes on";
  const wire::Served& served = (*reply)->about().served();
  EXPECT_EQ(served.refused_malformed(), 3u);
  EXPECT_EQ(served.refused_version(), 1u);
  EXPECT_EQ(served.refused_size(), 1u);
}

TEST_F(NodeSockets, TooManyRequestsOfOnePeerAreRefusedAndOthersAreServed) {
  const auto mute =
      NodeServer::Listen(context_, Place(), [](wire::About&) {}, {.most_open = 4}).value();
  const auto greedy = Client(), modest = Client();
  std::vector<std::future<Result<SharedReply>>> replies;
  for (int i = 0; i < 6; ++i) replies.push_back(greedy->Ask(AskForImage(i)));
  for (int i = 4; i < 6; ++i) {
    const auto refused = WaitFor(replies[static_cast<std::size_t>(i)], {});
    ASSERT_FALSE(refused.ok());
    EXPECT_THAT(refused.error().message, testing::HasSubstr("too many requests"));
  }
  wire::Request request;
  request.mutable_about();
  const auto reply = modest->AskAndWait(request, {});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ((*reply)->about().served().refused_rate(), 2u);
}

TEST_F(NodeSockets, APeerThatNeverReadsCostsNothingMore) {
  const EchoNode node(context_, Place());
  zmq::socket_t deaf(context_->zmq(), zmq::socket_type::dealer);
  deaf.set(zmq::sockopt::linger, 100);  // 0 may abort: socket_context.cc
  deaf.set(zmq::sockopt::rcvhwm, 1);
  deaf.connect(Place().text());
  wire::Request request = AskForImage(1);
  request.set_version(kWireVersion);
  for (int i = 0; i < 20000; ++i) {
    request.set_id(static_cast<std::uint64_t>(i));
    deaf.send(zmq::const_buffer(), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
    deaf.send(zmq::buffer(request.SerializeAsString()), zmq::send_flags::dontwait);
  }
  const auto client = Client();
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(client->AskAndWait(AskForImage(i), {}).ok());
}

TEST_F(NodeSockets, AnotherMachinesSocketNeedsKeys) {
  const auto open = Endpoint::Parse("tcp://0.0.0.0:47117").value();
  const auto server = NodeServer::Listen(context_, open, [](wire::About&) {});
  ASSERT_FALSE(server.ok());
  EXPECT_THAT(server.error().message, testing::HasSubstr("plumbline keys"));
  const auto client =
      NodeClient::Connect(context_, "echo", Endpoint::Parse("tcp://192.0.2.1:7000").value());
  ASSERT_FALSE(client.ok());
  EXPECT_THAT(client.error().message, testing::HasSubstr("plumbline keys"));
}

TEST_F(NodeSockets, WithKeysOnlyPeersWhoseKeyIsKnownAreLetIn) {
  const auto keys = folder_.path() / "keys", strangers = folder_.path() / "strangers";
  for (const char* name : {"echo", "mapper"}) ASSERT_TRUE(MakeCurveKeys(keys, name).ok());
  ASSERT_TRUE(MakeCurveKeys(strangers, "mapper").ok());
  std::filesystem::copy(keys / "echo.public", strangers / "echo.public");
  const auto echo_context = SocketContext::Create(ReadCurveKeys(keys, "echo").value()).value();
  const auto friend_context = SocketContext::Create(ReadCurveKeys(keys, "mapper").value()).value();
  const auto stranger_context =
      SocketContext::Create(ReadCurveKeys(strangers, "mapper").value()).value();
  const auto place = Endpoint::Parse("tcp://0.0.0.0:47118").value();
  const auto reached = Endpoint::Parse("tcp://127.0.0.1:47118").value();
  const EchoNode node(echo_context, place);
  const auto let_in = NodeClient::Connect(friend_context, "echo", reached).value();
  EXPECT_TRUE(let_in->AskAndWait(AskForImage(1), {}).ok());
  const auto stranger = NodeClient::Connect(stranger_context, "echo", reached).value();
  const auto keyless = NodeClient::Connect(context_, "echo", reached).value();
  auto never = stranger->Ask(AskForImage(1)), nor_this = keyless->Ask(AskForImage(1));
  EXPECT_EQ(never.wait_for(milliseconds(400)), std::future_status::timeout);
  EXPECT_EQ(nor_this.wait_for(milliseconds(0)), std::future_status::timeout);
  EXPECT_GE(echo_context->refused_peers(), 1u);
  const auto nobody = NodeClient::Connect(friend_context, "nobody", reached);
  ASSERT_FALSE(nobody.ok());
  EXPECT_THAT(nobody.error().message, testing::HasSubstr("nobody.public"));
}

TEST_F(NodeSockets, WhoWasRefusedCanBeStoppedAndIsLetInOnceItsKeyIsKnown) {
  const auto keys = folder_.path() / "keys", before = folder_.path() / "before";
  for (const char* name : {"echo", "late"}) ASSERT_TRUE(MakeCurveKeys(keys, name).ok());
  std::filesystem::create_directory(before);
  for (const char* name : {"echo.public", "echo.secret"})
    std::filesystem::copy(keys / name, before / name);
  const auto late_context = SocketContext::Create(ReadCurveKeys(keys, "late").value()).value();
  const auto place = Endpoint::Parse("tcp://0.0.0.0:47119").value();
  const auto reached = Endpoint::Parse("tcp://127.0.0.1:47119").value();
  const auto late = NodeClient::Connect(late_context, "echo", reached).value();
  std::future<Result<SharedReply>> asked;
  {
    const auto ignorant = SocketContext::Create(ReadCurveKeys(before, "echo").value()).value();
    const EchoNode node(ignorant, place);
    for (int i = 0; i < 200 && ignorant->refused_peers() == 0; ++i)
      std::this_thread::sleep_for(milliseconds(20));
    ASSERT_GE(ignorant->refused_peers(), 1u);
    std::this_thread::sleep_for(milliseconds(100));
    // Nobody is connected: what is asked now must neither be lost nor keep its thread.
    asked = late->Ask(AskForImage(5));
    const auto keyless = NodeClient::Connect(context_, "echo", reached).value();
    std::this_thread::sleep_for(milliseconds(200));
    auto never = keyless->Ask(AskForImage(6));
    EXPECT_EQ(never.wait_for(milliseconds(100)), std::future_status::timeout);
  }  // the keyless one ends here
  const EchoNode node(SocketContext::Create(ReadCurveKeys(keys, "echo").value()).value(), place);
  ASSERT_EQ(asked.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  const auto reply = asked.get();
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ((*reply)->image().frame(), 5);
}

}  // namespace
}  // namespace plumbline
