// SPDX-License-Identifier: Apache-2.0
// The commands `align` and `gravity` as a script meets them.

#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_file.h"
#include "engine/session/annotation_session.h"
#include "tests/support/annotation_scene.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class AlignVerb : public testing::Test {
 protected:
  /// An armchair on a floor that is the plane x = 0: up is +x.
  void SetUp() override {
    TriangleMesh scan = MakeParallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
    Append(Transformed(MakeChair(true), world_from_chair_), scan);
    const auto samples = SampleSurface(scan, 60000, 1).value();
    TriangleMesh points;
    for (const Eigen::Vector3d& point : samples.points) {
      points.vertices.push_back((scan_from_world_ * point).cast<float>());
    }
    ASSERT_TRUE(WritePly(folder_.path() / "scan.ply", points).ok());
    ASSERT_TRUE(WritePly(folder_.path() / "chair.ply", MakeChair(true)).ok());
  }

  int Run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path().string() + "' && '" +
                                ProgramFile().string() + "' " + arguments + " > out.txt 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string Output() const { return ReadFile(folder_.path() / "out.txt").value(); }

  TemporaryFolder folder_;
  Eigen::Isometry3d world_from_chair_{Eigen::Translation3d(0.5, -0.3, 0) *
                                      Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ())};
  Eigen::Isometry3d scan_from_world_{
      Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY())};
};

TEST_F(AlignVerb, GravityThenAlignFindTheChair) {
  ASSERT_EQ(Run("gravity scan.ply --json gravity.json"), 0) << Output();
  const nlohmann::json gravity = ReadJson(folder_.path() / "gravity.json").value();
  EXPECT_NEAR(gravity["gravity"][0].get<double>(), -1, 1e-4);
  EXPECT_NEAR(gravity["floor"][3].get<double>(), 0, 1e-3);
  ASSERT_EQ(Run("align --scan scan.ply --model chair.ply --init 0.05,-0.25,-0.45,100 "
                "--gravity=-1,0,0 --json align.json"),
            0)
      << Output();
  const nlohmann::json align = ReadJson(folder_.path() / "align.json").value();
  const Eigen::Isometry3d truth = scan_from_world_ * world_from_chair_;
  Eigen::Isometry3d found;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) found.matrix()(r, c) = align["scan_from_model"][r][c];
  }
  EXPECT_THAT(found, IsometryNear(truth, 0.1, 0.001));
  EXPECT_EQ(align["candidates"][0]["covariance"].size(), 4u);
  EXPECT_LT(align["tilt_deg"].get<double>(), 1e-7);
}

TEST_F(AlignVerb, AsksTheListOfModelsWhatItStandsOn) {
  const std::string command =
      "align --scan scan.ply --model chair.ply --init 0.05,-0.25,-0.45,100 --gravity=-1,0,0 "
      "--json align.json";
  const auto standing = [&](const std::string& more) {
    EXPECT_EQ(Run(command + more), 0) << Output();
    return ReadJson(folder_.path() / "align.json").value()["standing"].get<std::string>();
  };
  EXPECT_EQ(standing(""), "anywhere") << "no list beside it";
  const auto list = [&](const char* support) {
    const std::string text =
        R"({"units": "m", "models": [{"name": "other", "file": "other.ply", "support": "any"},
            {"name": "chair", "file": "chair.ply", "support": ")" +
        std::string(support) + "\"}]}";
    ASSERT_TRUE(WriteFileAtomically(folder_.path() / "models.json", text).ok());
  };
  list("floor");
  EXPECT_EQ(standing(""), "on_support");
  EXPECT_THAT(Output(), testing::HasSubstr("--anywhere"));
  const nlohmann::json floor = ReadJson(folder_.path() / "align.json").value()["floor"];
  EXPECT_NEAR(floor[0].get<double>(), 1, 1e-12) << "level, whatever the scan's";
  EXPECT_NEAR(floor[3].get<double>(), 0, 2e-3) << "found, because none was given";
  EXPECT_EQ(standing(" --anywhere"), "anywhere");
  list("any");
  EXPECT_EQ(standing(""), "anywhere");
  EXPECT_EQ(standing(" --on-support"), "on_support");
  EXPECT_EQ(Run(command + " --on-support --anywhere"), 2);
}

TEST_F(AlignVerb, RefusesWhatTheScanSaysNothingOf) {
  const std::string command =
      "align --scan scan.ply --model chair.ply --init 0.05,-0.25,-0.45,100 --gravity=-1,0,0";
  EXPECT_EQ(Run(command + " --min-fitness 1"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("of the model's surface meets the scan"));
  EXPECT_THAT(Output(), testing::HasSubstr("--min-fitness"));
  // On bare floor, and nowhere near the chair.
  EXPECT_EQ(Run("align --scan scan.ply --model chair.ply --init 0,1.5,1.5 --gravity=-1,0,0 "
                "--search 0.05 --starts 1"),
            1)
      << Output();
}

TEST_F(AlignVerb, MistakesAreSentencesAndExitCodes) {
  EXPECT_EQ(Run("align --scan scan.ply --model chair.ply --init 1,2 --gravity 0,0,-1"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("--init takes 3 to 4 numbers"));
  EXPECT_EQ(Run("align --scan none.ply --model chair.ply --init 1,2,3 --gravity 0,0,-1"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("none.ply"));
  EXPECT_EQ(Run("align --scan scan.ply --model chair.ply --init 9,9,9 --gravity 0,0,-1"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("start nearer"));
  EXPECT_EQ(Run("align --scan scan.ply --model chair.ply --init 1,2,3 --gravity 0,0,-1 --dof 5"),
            2);
  for (const char* floor : {"0,0,0,0", "1,0,0,0", "0,0,-1,0"}) {
    EXPECT_EQ(Run(std::string("align --scan scan.ply --model chair.ply --init 1,2,3 --gravity "
                              "0,0,-1 --floor ") +
                  floor),
              1);
    EXPECT_THAT(Output(), testing::HasSubstr("is not level")) << floor;
  }
  EXPECT_EQ(Run("gravity scan.ply --near 0,7,7"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("scan.ply"));
}

Eigen::Isometry3d PoseFrom(const nlohmann::json& rows) {
  Eigen::Isometry3d pose;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) pose.matrix()(r, c) = rows[r][c];
  }
  return pose;
}

/// A click in the window, and the command for the same place: one alignment, bit for bit.
TEST(AlignVerbAndWindow, GiveTheSameCandidates) {
  const TemporaryFolder folder;
  const Eigen::Isometry3d scan_from_level(Eigen::Translation3d(0.3, -0.2, 0.7));
  const AnnotationScene scene = MakeAnnotationScene(folder.path(), scan_from_level);
  AnnotationChoice choice;
  choice.path = scene.scan;
  auto session = AnnotationSession::Open(
                     choice, [] { return 0.0; }, 0)
                     .value();
  const auto apply = [&](const AnnotationCommand& command) {
    session->Apply(command);
    while (auto job = session->TakeJob()) job->run({}, [](const auto&) {})(*session);
  };
  // The scan's floor is at 0.7; the one that counts is a centimetre higher.
  apply(TypeGravityCommand{{0, 0, 1}, -0.71});
  apply(AcceptProposalCommand{});
  apply(PlaceModelCommand{"armchair", {0.75, 0.05, 1.1}});
  const AnnotationSnapshot snapshot = session->Snapshot();
  ASSERT_TRUE(snapshot.placement.has_value()) << snapshot.answer;
  const std::string command =
      "'" + ProgramFile().string() + "' align --scan '" + scene.scan.string() + "' --model '" +
      (scene.models / "armchair.ply").string() +
      "' --init 0.75,0.05,0.71 --gravity 0,0,-1 --on-support --floor 0,0,1,-0.71 --json '" +
      (folder.path() / "align.json").string() + "' > /dev/null";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
  const nlohmann::json align = ReadJson(folder.path() / "align.json").value();
  const auto& candidates = snapshot.placement->candidates;
  ASSERT_EQ(align["candidates"].size(), candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    EXPECT_EQ(PoseFrom(align["candidates"][i]["scan_from_model"]).matrix(),
              candidates[i].scan_from_object.matrix())
        << "candidate " << i;
  }
  EXPECT_NEAR(candidates[0].scan_from_object.translation().z(), 0.71, 1e-12);
}

}  // namespace
}  // namespace plumbline
