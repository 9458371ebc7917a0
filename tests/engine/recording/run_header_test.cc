// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline {
namespace {

/// As version 0.1.0 wrote it before there were recipes.
nlohmann::json HeaderOfFormat1() {
  return nlohmann::json::parse(R"({
    "options": {"alpha": 4.0, "particles": 300}, "seed": 7, "program_version": "0.1.0",
    "sequence": {"path": "/data/a folder", "hash": "01"},
    "database": {"path": "/data/models", "hash": "02",
                 "models": [{"name": "chair", "category": "chair"}]},
    "detector": "fastestdet /nets/Fastest Det.onnx 00ff", "edges": "edge network /nets/t0.onnx 11",
    "poses": "dataset", "gravity": [0, 0, -1],
    "camera": {"width": 640, "height": 480, "fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5,
               "rate_hz": 30},
    "frames": {"first": 2, "end": 90, "step": 3}, "started": "2026-11-01T00:00:00Z"})");
}

TEST(RunHeader, OfFormat1BecomesARecipe) {
  const auto header = HeaderFromJson(HeaderOfFormat1());
  ASSERT_TRUE(header.ok()) << header.error().message;
  const RunRecipe& recipe = header->recipe;
  EXPECT_EQ(recipe.sequence, "/data/a folder");
  EXPECT_EQ(recipe.models, "/data/models");
  EXPECT_EQ(recipe.detector->source, DetectorSource::kNetwork);
  EXPECT_EQ(recipe.detector->file, "/nets/Fastest Det.onnx");
  ASSERT_TRUE(recipe.edges.has_value());
  EXPECT_EQ(recipe.edges->source, EdgeSource::kNetwork);
  EXPECT_EQ(recipe.edges->file, "/nets/t0.onnx");
  EXPECT_EQ(recipe.poses.source, PoseSource::kDataset);
  EXPECT_EQ(recipe.options.alpha, 4);
  EXPECT_EQ(recipe.seed, 7u);
  EXPECT_EQ(recipe.frames, (FrameRange{2, 90, 3}));
  EXPECT_EQ(header->end_frame, 90);

  nlohmann::json given = HeaderOfFormat1();
  given["detector"] = "dataset /data/a folder/proposals";
  given["edges"] = "gradient, 3 scales";
  const auto of_given = HeaderFromJson(given);
  ASSERT_TRUE(of_given.ok());
  EXPECT_EQ(of_given->recipe.detector->source, DetectorSource::kDataset);
  EXPECT_EQ(of_given->recipe.edges->source, EdgeSource::kGradient);
}

TEST(RunHeader, OfFormat1WithAnUnknownDetectorIsRefusedInsteadOfGuessed) {
  nlohmann::json json = HeaderOfFormat1();
  json["detector"] = "oracle 42";
  const auto header = HeaderFromJson(json);
  ASSERT_FALSE(header.ok());
  EXPECT_THAT(header.error().message, testing::HasSubstr("oracle 42"));
}

TEST(RunHeader, OfANewerRecipeIsRefused) {
  nlohmann::json json = HeaderToJson(*HeaderFromJson(HeaderOfFormat1()));
  EXPECT_TRUE(HeaderFromJson(json).ok());
  json["recipe"]["version"] = 3;
  EXPECT_EQ(HeaderFromJson(json).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace plumbline
