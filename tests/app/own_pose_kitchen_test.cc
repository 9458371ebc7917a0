// SPDX-License-Identifier: Apache-2.0
// A real kitchen mapped from its images and an IMU alone. Slow: two minutes a seed.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/support/program_process.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

TEST(OwnPoseKitchen, ItsTableAndChairsAreFound) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  const auto run = [&](std::vector<std::string> arguments) {
    ASSERT_EQ(WaitFor(StartProgram(std::move(arguments), path("output.txt"))), 0)
        << *ReadFile(path("output.txt"));
  };
  // With these seeds chairs or the table were lost when every peak was sought from the highest
  // hypothesis found.
  for (const char* seed : {"1", "5"}) {
    run({"run", *shared / "data/kitchen", "--poses", "vio", "--detector",
         *shared / "models/fastestdet/FastestDet.onnx", "--edges",
         *shared / "models/edge_trial/t0_480x640.onnx", "--seed", seed, "--out", path("run.plb")});
    run({"evaluate", path("run.plb"), "--align", "trajectory", "--single-frames", "0", "--json",
         path("figures.json")});
    if (HasFatalFailure()) return;
    std::vector<std::string> found;
    const auto figures = nlohmann::json::parse(*ReadFile(path("figures.json")));
    for (const nlohmann::json& object : figures["objects"]) {
      if (!object.contains("ground_truth")) continue;
      const std::string name = object["ground_truth"];
      found.push_back(name);
      if (name.starts_with("chair") || name.starts_with("table")) {
        EXPECT_LT(object["translation_m"], 0.08) << name << ", seed " << seed;
        EXPECT_LT(object["rotation_deg"], 5) << name << ", seed " << seed;
      }
    }
    EXPECT_THAT(found, testing::IsSupersetOf({"chair_A", "chair_C", "chair_D", "table_0"}))
        << "seed " << seed;
    std::filesystem::remove(path("run.plb"));
  }
}

}  // namespace
}  // namespace plumbline
