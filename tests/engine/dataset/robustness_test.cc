// SPDX-License-Identifier: Apache-2.0
// Every input file of a sequence cut short, overwritten or sprinkled with wrong bytes: an error or
// a warning that says so, never a crash. Run under the address sanitizer by CI.

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

constexpr int kFrames = 3;

const char* const kFiles[] = {
    "camera.json",           "color.csv",        "gravity.json",     "trajectory.txt",
    "color/000001.jpg",      "color/000002.png", "edges/000001.png", "edges/000001_angle.png",
    "proposals/000001.json", "ground_truth.json"};

void WriteSequence(const std::filesystem::path& root) {
  WriteTinySequence(root, {.frames = kFrames, .edges = true, .proposals = true});
  std::filesystem::copy(root / "edges/000000.png", root / "color/000002.png");
  std::filesystem::remove(root / "color/000002.jpg");
  WriteText(root / "color.csv", "stamp_s,file\n0.0,000000.jpg\n0.1,000001.jpg\n0.2,000002.png\n");
  WriteText(root / "ground_truth.json",
            R"({"gravity": [0, 0, -1], "instances": [{"id": "a", "model": "m", "category":
      "chair", "quality": "fine", "world_from_object": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
}

/// Everything that can be read, read; the number of problems that were reported. Checks what was
/// accepted.
int Problems(const std::filesystem::path& root) {
  int problems = ReadGroundTruth(root / "ground_truth.json").ok() ? 0 : 1;
  const Result<std::shared_ptr<const Sequence>> opened = OpenSequence(root);
  if (!opened.ok()) {
    EXPECT_NE(opened.error().message.find(root.string()), std::string::npos)
        << opened.error().message;
    return problems + 1;
  }
  const Sequence& sequence = *opened.value();
  problems += static_cast<int>(sequence.warnings().size());
  if (sequence.gravity_in_world()) {
    EXPECT_NEAR(sequence.gravity_in_world()->norm(), 1, 1e-9);
  }
  for (int i = 0; i < sequence.num_frames(); ++i) {
    const auto pose = sequence.world_from_cam(i);
    if (pose) {
      EXPECT_NEAR(pose->linear().determinant(), 1, 1e-9);
    }
    const Result<Frame> frame = sequence.ReadFrame(i);
    const auto edges = sequence.ReadEdges(i);
    const auto proposals = sequence.ReadProposals(i);
    problems += !frame.ok() + !edges.ok() + !proposals.ok();
    const cv::Size size(sequence.camera().width, sequence.camera().height);
    if (frame.ok()) {
      EXPECT_EQ(frame->image.size(), size);
    }
    if (edges.ok() && edges->has_value()) {
      EXPECT_EQ(edges.value()->angle.size(), size);
    }
  }
  return problems;
}

class DamagedInput : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    WriteSequence(root_);
    ASSERT_EQ(Problems(root_), 0);
    content_ = ReadFile(file_).value();
  }
  TemporaryFolder folder_;
  const std::filesystem::path root_ = folder_.path() / "sequence";
  const std::filesystem::path file_ = root_ / GetParam();
  std::string content_;
};

TEST_P(DamagedInput, CutShortIsReported) {
  for (const double share : {0.0, 0.02, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9}) {
    const auto length = static_cast<std::size_t>(share * static_cast<double>(content_.size()));
    WriteText(file_, content_.substr(0, length));
    EXPECT_GT(Problems(root_), 0) << length << " of " << content_.size();
  }
  for (std::size_t cut = 1; cut < 5; ++cut) {  // may be no loss, must be no crash
    WriteText(file_, content_.substr(0, content_.size() - cut));
    Problems(root_);
  }
}

TEST_P(DamagedInput, ReplacedByNoiseIsReported) {
  Random random({.seed = 21});
  for (const std::size_t length : {1, 7, 100, 5000}) {
    std::string noise(length, '\0');
    for (char& c : noise) c = static_cast<char>(random.Index(256));
    WriteText(file_, noise);
    EXPECT_GT(Problems(root_), 0) << length;
  }
  for (const std::string& text :
       {std::string(20000, '['), std::string(20000, '{'), std::string("[1e999]"),
        std::string("null"), std::string("\n"), std::string("{\"width\": 1e308}"),
        std::string(5000, '0'), std::string("\xff\xd8\xff\xd9")}) {
    WriteText(file_, text);
    EXPECT_GT(Problems(root_), 0) << text.substr(0, 20);
  }
}

TEST_P(DamagedInput, SprinkledWithWrongBytesDoesNoHarm) {
  Random random({.seed = 22});
  for (int round = 0; round < 60; ++round) {
    std::string damaged = content_;
    const int changes = 1 + static_cast<int>(random.Index(4));
    for (int i = 0; i < changes; ++i)
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Index(256));
    WriteText(file_, damaged);
    Problems(root_);
  }
}

TEST_P(DamagedInput, MissingIsReportedOrOptional) {
  std::filesystem::remove(file_);
  Problems(root_);
  std::filesystem::create_directories(file_);
  Problems(root_);
}

INSTANTIATE_TEST_SUITE_P(Files, DamagedInput, testing::ValuesIn(kFiles), [](const auto& param) {
  std::string name = param.param;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace plumbline
