// SPDX-License-Identifier: Apache-2.0
// Seeking in a run of 10 000 frames: how long until the new picture is there, and in how much
// memory.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/engine/recording/random_run.h"
#include "tests/engine/runtime/box_run.h"
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

void WriteRun(const std::filesystem::path& file, const std::filesystem::path& sequence,
              const std::filesystem::path& models) {
  auto writer = RunWriter::Create(file, HeaderOfBoxRun(sequence, models));
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  const cv::Mat image = RandomImage(3);
  for (int i = 0; i < kFrames; ++i) ASSERT_TRUE((*writer)->Write(FrameOfBoxRun(i), image).ok());
  ASSERT_TRUE((*writer)->Close().ok());
}

TEST(Seek, FindsAnyOf10000FramesAtOnceInFlatMemory) {
  const TemporaryFolder folder;
  WriteBoxModels(folder.path() / "models");
  WriteBoxSequence(folder.path() / "sequence", kFrames);
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
