// SPDX-License-Identifier: Apache-2.0
// What describes a batch system; tests/app speaks to systems by it.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/batch/batch_engines.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const json kSystem = {{"submit", "qsub {script}"},
                      {"left", "qstat"},
                      {"cancel", "qdel {id}"},
                      {"script", {"exec {command} $ID"}}};

Result<ClusterCommands> Read(const json& system) {
  const TemporaryFolder folder;
  EXPECT_TRUE(WriteJson(folder.path() / "system.json", system).ok());
  return ReadClusterCommands(folder.path() / "system.json");
}

std::string WhatIsWrongWith(const std::function<void(json&)>& change) {
  json system = kSystem;
  change(system);
  const auto read = Read(system);
  return read.ok() ? "" : read.error().message;
}

TEST(ClusterCommands, AreRead) {
  const ClusterCommands commands = Read(kSystem).value();
  EXPECT_EQ(commands.submit, "qsub {script}");
  EXPECT_EQ(commands.cancel, "qdel {id}");
  EXPECT_EQ(commands.most_tasks, 1000);
}

TEST(ClusterCommands, ThatCannotWorkAreRefused) {
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s.erase("left"); }), HasSubstr("'left' is missing"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s["lift"] = ""; }), HasSubstr("did you mean 'left'"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s["script"] = {"exit 0"}; }), HasSubstr("{command}"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s["script"] = 1; }), HasSubstr("list of lines"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s["submit"] = 1; }), HasSubstr("must be a text"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s["most_tasks"] = 0; }), HasSubstr("from 1"));
  EXPECT_THAT(WhatIsWrongWith([](json& s) { s = json::array(); }), HasSubstr("JSON object"));
}

TEST(ClusterCommands, OfSlurmCarryTheWordsOfThePlan) {
  const ClusterCommands commands = SlurmCommands({"--mem=2G", "--comment=a b"});
  EXPECT_THAT(commands.submit, HasSubstr("--mem=2G '--comment=a b' {script}"));
}

}  // namespace
}  // namespace plumbline
