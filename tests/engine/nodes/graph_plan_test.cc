// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/graph_plan.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

nlohmann::json Paper() { return ReadJson(SourceDirectory() / "assets/graphs/paper.json").value(); }

/// What is said of the paper's graph once `change` was at it.
template <typename Change>
std::string Refused(Change change) {
  nlohmann::json json = Paper();
  change(json);
  const auto plan = GraphFromJson(json);
  return plan.ok() ? "" : plan.error().message;
}

TEST(GraphPlan, OfThePaperIsReadAndWritten) {
  const auto plan = ReadGraph(SourceDirectory() / "assets/graphs/paper.json");
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  EXPECT_EQ(plan->nodes.size(), 5u);
  EXPECT_EQ(plan->FirstOf(NodeKind::kMapper)->proposals, "detector");
  const auto again = GraphFromJson(GraphToJson(*plan));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(GraphToJson(*again), GraphToJson(*plan));
}

TEST(GraphPlan, WithANodeThatFindsPosesIsReadAndWritten) {
  const auto plan = ReadGraph(SourceDirectory() / "assets/graphs/paper_vio.json");
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  EXPECT_EQ(plan->FirstOf(NodeKind::kMapper)->poses, "vio");
  EXPECT_EQ(plan->Find("vio")->kind, NodeKind::kVio);
  EXPECT_EQ(GraphToJson(GraphFromJson(GraphToJson(*plan)).value()), GraphToJson(*plan));
}

TEST(GraphPlan, WithACameraAndAnImuIsReadAndWritten) {
  auto plan = ReadGraph(SourceDirectory() / "assets/graphs/live.json").value();
  EXPECT_EQ(plan.Find("imu")->kind, NodeKind::kImu);
  plan.nodes[0].source = "/dev/video0";
  plan.recording = {123456789012, 7.5, true, 12.5};
  const auto again = GraphFromJson(GraphToJson(plan)).value();
  EXPECT_EQ(again.FirstOf(NodeKind::kCamera)->source, "/dev/video0");
  EXPECT_EQ(again.recording.began_ns, 123456789012);
  EXPECT_EQ(again.recording.seconds, 7.5);
  EXPECT_TRUE(again.recording.lossless);
  EXPECT_EQ(again.recording.exposure_ms, 12.5);
}

TEST(GraphPlan, SaysWhatIsWrongWithAGraph) {
  using testing::HasSubstr;
  EXPECT_THAT(Refused([](auto& json) { json["version"] = 2; }), HasSubstr("version 2"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][0]["kind"] = "lidar"; }),
              HasSubstr("'lidar' is no kind of node"));
  EXPECT_THAT(Refused([](auto& json) {
                json["nodes"].push_back({{"name", "imu"}, {"kind", "imu"}});
              }),
              HasSubstr("of kind imu, and none of kind camera"));
  EXPECT_THAT(Refused([](auto& json) {
                json["nodes"].push_back({{"name", "left"}, {"kind", "camera"}});
                json["nodes"].push_back({{"name", "right"}, {"kind", "camera"}});
              }),
              HasSubstr("two nodes of kind camera"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][1]["image"] = "player"; }),
              HasSubstr("did you mean 'images'?"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][1]["images"] = "nobody"; }),
              HasSubstr("names the node 'nobody', which is not there"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][1]["images"] = "mapper"; }),
              HasSubstr("a mapper, which has none"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][1]["name"] = "player"; }),
              HasSubstr("two nodes are named 'player'"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][1]["name"] = "../player"; }),
              HasSubstr("is no name of a node"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"].erase(4); }), HasSubstr("'recorder'"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][3].erase("recorder"); }),
              HasSubstr("needs \"recorder\""));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][0]["endpoint"] = "player"; }),
              HasSubstr("tcp://HOST:PORT"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][2]["kind"] = "other"; }),
              HasSubstr("no \"command\""));
  EXPECT_THAT(Refused([](auto& json) { json = {1, 2}; }), HasSubstr("no graph"));
  EXPECT_THAT(Refused([](auto& json) { json["nodes"][3]["poses"] = "player"; }),
              HasSubstr("names 'player', a player"));
  EXPECT_THAT(Refused([](auto& json) {
                json["nodes"].push_back({{"name", "vio"}, {"kind", "vio"}, {"images", "player"}});
                json["nodes"][3]["poses"] = "vio";
              }),
              HasSubstr("the same \"poses\""));
}

TEST(GraphPlan, GivesEveryNodeASocketOfItsOwn) {
  GraphPlan plan = GraphFromJson(Paper()).value();
  plan.nodes[0].endpoint = "tcp://127.0.0.1:7000";
  ASSERT_TRUE(ResolveGraph("graph", plan).ok());
  EXPECT_EQ(plan.nodes[0].endpoint, "tcp://127.0.0.1:7000");
  EXPECT_EQ(plan.nodes[1].endpoint, "ipc://graph/edges");
  GraphPlan deep = GraphFromJson(Paper()).value();
  EXPECT_FALSE(ResolveGraph(std::string(150, 'd'), deep).ok());
}

}  // namespace
}  // namespace plumbline
