// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/run_recipe.h"

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

RunRecipe Recipe() {
  RunRecipe recipe;
  recipe.sequence = "/data/kitchen";
  recipe.models = "/data/models";
  recipe.poses = {PoseSource::kTrajectory, "/data/poses.txt", "0a"};
  recipe.detector = DetectorChoice{DetectorSource::kNetwork, "/nets/detector.onnx", "0b"};
  recipe.edges = EdgeChoice{EdgeSource::kGradient, {}, {}};
  recipe.scorer = ScorerKind::kRendered;
  recipe.options.alpha = 0.1 + 0.2;
  recipe.seed = 0xFFFFFFFFFFFFFFFFull;
  recipe.frames = {3, 600, 2};
  return recipe;
}

TEST(RunRecipe, IsTheSameAfterJson) {
  const nlohmann::json json = RecipeToJson(Recipe());
  const auto back = RecipeFromJson(nlohmann::json::parse(json.dump()));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(RecipeToJson(*back), json);
  EXPECT_EQ(back->options.alpha, 0.1 + 0.2);
  EXPECT_EQ(back->seed, 0xFFFFFFFFFFFFFFFFull);
  EXPECT_EQ(back->frames, (FrameRange{3, 600, 2}));
  EXPECT_TRUE(back->detector.value().SameContent(*Recipe().detector));

  RunRecipe own = Recipe();
  own.poses = ParsePoses("vio");
  own.own_poses.filter.pixel_noise_px = 1.5;
  own.own_poses.ready_tilt_deg = 0.4;
  const auto own_back = RecipeFromJson(RecipeToJson(own));
  ASSERT_TRUE(own_back.ok()) << own_back.error().message;
  EXPECT_EQ(own_back->poses.source, PoseSource::kVio);
  EXPECT_EQ(HashOf(own_back->own_poses), HashOf(own.own_poses));
  EXPECT_NE(HashOf(own_back->own_poses), HashOf(OwnPoseOptions()));

  RunRecipe least;
  least.sequence = "/data/kitchen";
  const auto least_back = RecipeFromJson(RecipeToJson(least));
  ASSERT_TRUE(least_back.ok());
  EXPECT_FALSE(least_back->edges.has_value());
  EXPECT_TRUE(least_back->models.empty());
  EXPECT_FALSE(least_back->live_speed.has_value());

  RunRecipe live = Recipe();
  live.live_speed = 0.5;
  EXPECT_EQ(RecipeFromJson(RecipeToJson(live))->live_speed, 0.5);
}

TEST(RunRecipe, TellsOfTheAuthorsFilterAndAllItsSettings) {
  RunRecipe recipe = Recipe();
  recipe.options.filter = FilterKind::kPaper;
  recipe.options.paper.depth_m = 3.5;
  const nlohmann::json json = RecipeToJson(recipe);
  EXPECT_EQ(json.at("options").at("filter"), "paper");
  EXPECT_EQ(json.at("options").at("paper_edge_weight"), 200);
  const auto back = RecipeFromJson(json);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->options.filter, FilterKind::kPaper);
  EXPECT_EQ(back->options.paper.depth_m, 3.5);
}

TEST(RunRecipe, OfANewerVersionIsRefusedWithASentence) {
  nlohmann::json json = RecipeToJson(Recipe());
  json["version"] = 99;
  const auto refused = RecipeFromJson(json);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("update this program"));
}

TEST(RunRecipe, ThatIsDamagedIsAnError) {
  const nlohmann::json whole = RecipeToJson(Recipe());
  for (const auto& [key, value] : whole.items()) {
    if (key == "models" || key == "edges" || key == "detector") continue;
    nlohmann::json json = whole;
    json.erase(key);
    EXPECT_FALSE(RecipeFromJson(json).ok()) << key;
  }
  nlohmann::json json = whole;
  json["detector"]["source"] = "crystal ball";
  EXPECT_FALSE(RecipeFromJson(json).ok());
}

TEST(RunRecipe, KeepsTheOptionsThatItKnows) {
  const MapperOptions options = KnownOptions({{"alpha", 7}, {"of_the_future", 1}});
  EXPECT_EQ(options.alpha, 7);
}

TEST(RunRecipe, TakesTheSequencesOwnEdgesAndBoxesElseNetworks) {
  const TemporaryFolder folder;
  setenv("XDG_DATA_HOME", (folder.path() / "data").c_str(), 1);
  WriteTinySequence(folder.path() / "whole", {.edges = true, .proposals = true});
  const auto whole = OpenSequence(folder.path() / "whole").value();
  EXPECT_EQ(DefaultEdges(*whole).source, EdgeSource::kDataset);
  EXPECT_EQ(DefaultDetector(*whole).source, DetectorSource::kDataset);
  WriteTinySequence(folder.path() / "bare", {});
  const auto bare = OpenSequence(folder.path() / "bare").value();
  EXPECT_EQ(DefaultEdges(*bare).source, EdgeSource::kBuiltin);
  EXPECT_EQ(DefaultDetector(*bare).source, DetectorSource::kBuiltin);
  // Of what was fetched, the first of the list.
  for (const char* name : {"yolox_nano", "yolox_s"}) {
    const auto file = folder.path() / "data/plumbline/networks" / (std::string(name) + ".onnx");
    std::filesystem::create_directories(file.parent_path());
    WriteText(file, "any");
    const DetectorChoice found = DefaultDetector(*bare);
    EXPECT_EQ(found.source, DetectorSource::kNetwork);
    EXPECT_EQ(found.file, file);
  }
}

TEST(InputChoice, IsReadAsTheCommandLineWritesIt) {
  EXPECT_EQ(ParseEdges("builtin-half").source, EdgeSource::kBuiltinHalf);
  EXPECT_TRUE(ParseEdges("builtin").file.empty());
  EXPECT_EQ(ParseEdges("gradient").source, EdgeSource::kGradient);
  EXPECT_EQ(ParseEdges("dataset").source, EdgeSource::kDataset);
  EXPECT_EQ(ParseEdges("./gradient").source, EdgeSource::kNetwork);
  EXPECT_EQ(ParseDetector("a b.onnx").file, "a b.onnx");
  EXPECT_EQ(ParsePoses("poses.txt").source, PoseSource::kTrajectory);
  for (const char* text : {"gradient", "dataset", "folder/net.onnx"})
    EXPECT_EQ(ToText(ParseEdges(text)), text);
}

}  // namespace
}  // namespace plumbline
