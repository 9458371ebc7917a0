// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/running_graph.h"

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/nodes/our_nodes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

/// A graph as `up` leaves it, and what its recorder writes.
class RunningGraphTest : public testing::Test {
 protected:
  RunningGraphTest() {
    ::setenv("XDG_RUNTIME_DIR", folder_.path().c_str(), 1);
    std::filesystem::create_directories(graph_);
    GraphPlan plan = ReadGraph(SourceDirectory() / "assets/graphs/paper.json").value();
    plan.out = run_;
    EXPECT_TRUE(ResolveGraph(graph_, plan).ok());
    Write(plan);
  }
  ~RunningGraphTest() override { ::unsetenv("XDG_RUNTIME_DIR"); }

  void Write(const GraphPlan& plan) const {
    EXPECT_TRUE(WriteJson(graph_ / "graph.json", GraphToJson(plan)).ok());
  }
  void Begin() const {
    std::ofstream(graph_ / kRunBegun) << run_.string();
    std::ofstream(run_) << "a run";
  }
  std::string Refused(const std::filesystem::path& place) const {
    const auto found = FindRunningGraph(place, kViewerName);
    return found.ok() ? "" : found.error().message;
  }

  TemporaryFolder folder_;
  std::filesystem::path graph_ = folder_.path() / "plumbline-a1B2c3",
                        run_ = folder_.path() / "walk.plb";
};

TEST_F(RunningGraphTest, IsFoundByItsFolderAndByItsFileOnceItsRunHasBegun) {
  EXPECT_TRUE(NamesGraph(graph_));
  EXPECT_TRUE(NamesGraph(graph_ / "graph.json"));
  EXPECT_FALSE(NamesGraph(folder_.path()));
  EXPECT_FALSE(NamesGraph(run_));
  EXPECT_THAT(Refused(graph_), testing::HasSubstr("has not begun its run yet"));
  EXPECT_TRUE(GraphsOfThisMachine().empty());
  Begin();
  for (const auto& place : {graph_, graph_ / "graph.json"}) {
    const auto found = FindRunningGraph(place, kViewerName);
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_EQ(found->run, run_);
    EXPECT_EQ(found->graph.name, place);
  }
  EXPECT_TRUE(GraphsOfThisMachine().empty()) << "nobody writes it";
  const auto recorder = FileLock::Acquire(run_).value();
  const auto running = GraphsOfThisMachine();
  ASSERT_EQ(running.size(), 1u);
  EXPECT_EQ(running[0].graph.name, graph_);
}

TEST_F(RunningGraphTest, OfAnotherMachineOrNotStartedIsSaid) {
  Begin();
  GraphPlan plan = ReadGraph(graph_ / "graph.json").value();
  for (GraphNode& node : plan.nodes)
    if (node.kind == NodeKind::kRecorder) node.endpoint = "tcp://127.0.0.1:5000";
  Write(plan);
  EXPECT_THAT(Refused(graph_), testing::HasSubstr("gui --attach"));
  plan.folder.clear();
  Write(plan);
  EXPECT_THAT(Refused(graph_), testing::HasSubstr("is not running"));
  std::ofstream(graph_ / "graph.json") << "{";
  EXPECT_THAT(Refused(graph_), testing::HasSubstr("graph.json"));
}

}  // namespace
}  // namespace plumbline
