// SPDX-License-Identifier: Apache-2.0
// Every input file of a sequence cut short, overwritten or sprinkled with wrong bytes: an error or
// a warning that says so, never a crash. Run under the address sanitizer by CI.

#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/tracks_file.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

constexpr int kFrames = 3;

const char* const kFiles[] = {
    "camera.json",           "color.csv",         "gravity.json",     "trajectory.txt",
    "color/000001.jpg",      "color/000002.png",  "edges/000001.png", "edges/000001_angle.png",
    "proposals/000001.json", "ground_truth.json", "imu.csv",          "imu.json",
    "depth/000001.png"};

void WriteSequence(const std::filesystem::path& root) {
  WriteTinySequence(root, {.frames = kFrames, .edges = true, .proposals = true});
  std::filesystem::copy(root / "edges/000000.png", root / "color/000002.png");
  std::filesystem::remove(root / "color/000002.jpg");
  WriteText(root / "color.csv", "stamp_s,file\n0.0,000000.jpg\n0.1,000001.jpg\n0.2,000002.png\n");
  std::filesystem::create_directories(root / "depth");
  cv::imwrite((root / "depth/000001.png").string(), cv::Mat(48, 64, CV_16UC1, cv::Scalar(1500)));
  WriteText(root / "imu.csv",
            "#t,wx,wy,wz,ax,ay,az\n0.00,0.1,0.2,0.3,0,0,9.8\n0.01,0,0,0,0,0,9.8\n");
  WriteText(root / "imu.json", R"({"rate_hz": 200, "gyro_noise_density": 0.00016})");
  WriteText(root / "tracks.csv", "#t,id,u,v\n0.0,7,3.5,4.25\n0.1,7,4.5,4.25\n");
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
  const Result<ImuRecording> imu = sequence.ReadImu();
  problems += imu.ok() ? static_cast<int>(imu->warnings.size()) : 1;
  if (imu.ok()) {
    for (const ImuSample& sample : imu->samples)
      EXPECT_TRUE(sample.angular_velocity_rad_s.allFinite());
  }
  if (sequence.tracks_file()) {
    const Result<FeatureTracks> tracks = ReadTracksFile(*sequence.tracks_file());
    problems += tracks.ok() ? static_cast<int>(tracks->warnings.size()) : 1;
  }
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
    const auto depth = sequence.ReadDepth(i);
    problems += !frame.ok() + !edges.ok() + !proposals.ok() + !depth.ok();
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
  /// Each part of a PNG has one.
  bool has_checksum() const { return file_.extension() == ".png"; }

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
    EXPECT_GE(Problems(root_), has_checksum() ? 1 : 0) << cut << " bytes cut off";
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
  int changed = 0, reported = 0;
  for (int round = 0; round < 60; ++round) {
    std::string damaged = content_;
    const int changes = 1 + static_cast<int>(random.Index(4));
    for (int i = 0; i < changes; ++i)
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Index(256));
    WriteText(file_, damaged);
    changed += damaged != content_;
    reported += Problems(root_) > 0;
  }
  EXPECT_GT(reported, 0);
  if (has_checksum()) {
    EXPECT_EQ(reported, changed) << "a PNG with a wrong byte was taken for whole";
  }
  WriteText(file_, content_);
  EXPECT_EQ(Problems(root_), 0) << "reading a damaged file changed something";
}

TEST_P(DamagedInput, MissingIsReportedOrOptional) {
  static const std::set<std::string> kNeeded = {"camera.json", "color/000001.jpg",
                                                "color/000002.png", "edges/000001_angle.png",
                                                "ground_truth.json"};
  std::filesystem::remove(file_);
  EXPECT_EQ(Problems(root_) > 0, kNeeded.contains(GetParam()));
  std::filesystem::create_directories(file_);
  EXPECT_GT(Problems(root_), 0) << "a folder was taken for the file";
}

INSTANTIATE_TEST_SUITE_P(Files, DamagedInput, testing::ValuesIn(kFiles), [](const auto& param) {
  std::string name = param.param;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace plumbline
