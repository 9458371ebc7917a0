// SPDX-License-Identifier: Apache-2.0
// Seeking in a run of 10 000 frames: how long until the new picture is there, and in how much
// memory.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/random.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/engine/recording/random_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr int kFrames = 10'000;

long ResidentKilobytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  }
  return 0;
}

/// A box as OBJ, in a database folder.
void WriteModels(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "box.obj")
      << "v 0 0 0\nv 0.5 0 0\nv 0.5 0.5 0\nv 0 0.5 0\nv 0 0 0.8\nv 0.5 0 0.8\nv 0.5 0.5 0.8\nv 0 "
         "0.5 0.8\n"
         "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\n"
         "f 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream(folder / "models.json")
      << R"({"units": "m", "models": [{"name": "box", "file": "box.obj", "category": "chair"}]})";
}

/// 10 000 frames of a 960x500 sequence whose image files are a few, linked under many names.
void WriteSequence(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "color");
  std::ofstream(folder / "camera.json")
      << R"({"width": 960, "height": 500, "model": "pinhole", "fx": 600, "fy": 600, "cx": 480,)"
         R"( "cy": 250, "rate_hz": 30})";
  std::ofstream(folder / "gravity.json") << R"({"gravity": [0, 0, -1]})";
  std::ofstream trajectory(folder / "trajectory.txt");
  char name[32];
  for (int i = 0; i < kFrames; ++i) {
    trajectory << i / 30.0 << " 0 0 1.2 -0.5 0.5 -0.5 0.5\n";
    std::snprintf(name, sizeof(name), "%06d.jpg", i);
    if (i < 8) {
      cv::imwrite((folder / "color" / name).string(), RandomImage(static_cast<std::uint64_t>(i)));
      continue;
    }
    char original[32];
    std::snprintf(original, sizeof(original), "%06d.jpg", i % 8);
    std::filesystem::create_hard_link(folder / "color" / original, folder / "color" / name);
  }
}

void WriteRun(const std::filesystem::path& file, const std::filesystem::path& sequence,
              const std::filesystem::path& models) {
  RunHeader header = RandomHeader(1);
  header.recipe.sequence = sequence;
  header.recipe.models = models;
  header.models = {{"box", "chair"}};
  header.recipe.edges = EdgeChoice{EdgeSource::kGradient, {}, {}};
  header.camera = {960, 500, 600, 600, 480, 250};
  auto writer = RunWriter::Create(file, header);
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  const cv::Mat image = RandomImage(3);
  for (int i = 0; i < kFrames; ++i) {
    FrameReport report = RandomFrame(5, i, 3, 60);
    report.skipped.clear();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(0, 0, 1.2);
    report.world_from_cam = pose;
    for (ObjectReport& object : report.objects) {
      object.label = {0};
      object.label_probability = {{{0}, 1.0}};
      for (auto& mode : object.modes) mode.label = {0};
      if (object.particles != nullptr) {
        auto particles = *object.particles;
        for (Particle& particle : particles) particle.label = 0;
        object.particles = std::make_shared<decltype(particles)>(std::move(particles));
      }
      object.state = ObjectState::kConfirmed;
      object.world_from_object = Eigen::Isometry3d::Identity();
      object.world_from_object.translation() = Eigen::Vector3d(2, object.id.value - 2.0, 0);
    }
    ASSERT_TRUE((*writer)->Write(report, image).ok());
  }
  ASSERT_TRUE((*writer)->Close().ok());
}

TEST(Seek, FindsAnyOf10000FramesAtOnceInFlatMemory) {
  const TemporaryFolder folder;
  WriteModels(folder.path() / "models");
  WriteSequence(folder.path() / "sequence");
  WriteRun(folder.path() / "long.plb", folder.path() / "sequence", folder.path() / "models");

  const auto start = std::chrono::steady_clock::now();
  auto source = OpenRunSource({folder.path() / "long.plb", {}, {}}, WorkContext());
  ASSERT_TRUE(source.ok()) << source.error().message;
  const auto milliseconds_since = [](auto from) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from)
        .count();
  };
  const double open_ms = milliseconds_since(start);
  ASSERT_EQ((*source)->size(), kFrames);

  std::vector<double> seek_ms;
  Random random({.seed = 11});
  long after_some_kb = 0;
  for (int i = 0; i < 200; ++i) {
    if (i == 100) after_some_kb = ResidentKilobytes();
    const auto from = std::chrono::steady_clock::now();
    const auto snapshot =
        (*source)->Past(static_cast<int>(random.Index(kFrames)), std::stop_token());
    seek_ms.push_back(milliseconds_since(from));
    ASSERT_TRUE(snapshot.ok()) << snapshot.error().message;
    EXPECT_FALSE((*snapshot)->image.empty());
    EXPECT_FALSE((*snapshot)->edge_probability.empty());
    EXPECT_FALSE((*snapshot)->depth.empty());
  }
  const long grown_kb = ResidentKilobytes() - after_some_kb;
  std::sort(seek_ms.begin(), seek_ms.end());

  const auto read_from = std::chrono::steady_clock::now();
  int turns = 0;
  while ((*source)->ReadAhead()) ++turns;
  const double history_ms = milliseconds_since(read_from);
  EXPECT_GT(turns, 10) << "it reads in small bites, between commands";
  EXPECT_EQ((*source)->history().frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NE((*source)->history().frames.back(), nullptr);
  EXPECT_LE((*source)->history().thumbnails.size(), 64u);

  std::printf(
      "open %.0f ms; seek median %.1f ms, 95 %% %.1f ms, worst %.1f ms; 100 more seeks took %ld "
      "kB; "
      "history of %d frames %.0f ms\n",
      open_ms, seek_ms[100], seek_ms[190], seek_ms.back(), grown_kb, kFrames, history_ms);
  // The machine is shared: the median says what a seek takes.
  EXPECT_LT(seek_ms[100], 100);
  // The memory of recent frames has its budget; it may still be filling.
  EXPECT_LT(grown_kb, 320 * 1024);
}

}  // namespace
}  // namespace plumbline
