// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/single_frames.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/analysis/run_review.h"
#include "engine/base/check.h"
#include "engine/dataset/ground_truth.h"
#include "engine/mapping/map_report.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/run_file.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// A cube of 1 m, 4 m before a camera of 64 x 48 pixels that looks along the world's z. Frame i of
/// the sequence stands i metres to the right, so that the cube shows in the first of them.
class SingleFramesOfARun : public testing::Test {
 protected:
  void SetUp() override {
    WriteTinySequence(Folder() / "sequence", {.frames = 5});
    std::filesystem::create_directory(Folder() / "models");
    Check(WritePly(Folder() / "models" / "cube.ply", MakeBox({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1})));
    WriteText(Folder() / "models" / "models.json",
              R"({"units": "m", "models": [{"name": "cube", "file": "cube.ply",
      "category": "chair", "symmetry": {"axis": [0, 0, 1], "order": 4}, "support": "any"}]})");
    GroundTruth truth;
    truth.instances = {{"a", "cube", "chair", Cube(0), true}};
    Check(WriteGroundTruth(Folder() / "truth.json", truth));
  }

  static Eigen::Isometry3d Cube(double right_m) {
    return Eigen::Isometry3d(Eigen::Translation3d(right_m, 0, 5));
  }
  static void Check(const Status& status) { PLB_CHECK(status.ok()) << status.error().message; }
  const std::filesystem::path& Folder() const { return folder_.path(); }

  /// A run whose map holds the cube so far to the right, confirmed from a frame on.
  SingleFrames Judge(double right_m, int confirmed_from = 0, const TriangleMesh* scan = nullptr,
                     int frames = 20) {
    RunHeader header;
    header.models = {{"cube", "chair"}};
    header.recipe.models = Folder() / "models";
    header.recipe.sequence = Folder() / "sequence";
    {
      const auto writer = RunWriter::Create(Folder() / "run.plb", header).value();
      for (int i = 0; i < 5; ++i) {
        FrameReport report;
        report.frame = i;
        report.world_from_cam = Eigen::Isometry3d(Eigen::Translation3d(i, 0, 1));
        ObjectReport object;
        object.id = {1};
        object.state = i >= confirmed_from ? ObjectState::kConfirmed : ObjectState::kTentative;
        object.category = "chair";
        object.label = {0};
        object.world_from_object = Cube(right_m);
        report.objects = {object};
        Check(writer->Write(report, {}));
      }
      Check(writer->Close());
    }
    const RunReview review =
        ReviewRun({Folder() / "run.plb", {}, {}}, Folder() / "truth.json", WorkContext()).value();
    const auto reader = RunReader::Open(Folder() / "run.plb").value();
    const auto sequence = OpenSequence(Folder() / "sequence").value();
    SingleFrameOptions options;
    options.frames = frames;
    return MeasureSingleFrames(review, *reader, *sequence, scan, options, WorkContext()).value();
  }

  TemporaryFolder folder_;
};

TEST_F(SingleFramesOfARun, ArePerfectForAPerfectMap) {
  const SingleFrames frames = Judge(0);
  EXPECT_EQ(frames.frames, 5);
  EXPECT_EQ(frames.models, 5) << "neither depth nor a scan";
  // Half of the width is 2.1 m at 4 m: the cube shows whole from 0 and 1 m to its side, half
  // from 2.
  EXPECT_EQ(frames.all.targets, 3);
  EXPECT_EQ(frames.all.estimated, 3);
  EXPECT_EQ(frames.all.vsd, 1);
  EXPECT_EQ(frames.all.mssd, 1);
  EXPECT_EQ(frames.all.mspd, 1);
  EXPECT_EQ(frames.by_truth.at("a").targets, 3);
}

TEST_F(SingleFramesOfARun, GiveTheErrorsOfAShiftInClosedForm) {
  // 26 cm off a diameter of sqrt(3) m is 0.15: below .20 to .50, 7 of 10.
  const SingleFrames frames = Judge(0.15 * std::sqrt(3.0));
  EXPECT_NEAR(frames.all.mssd, 0.7, 1e-12);
  // The near face is 4 m away: 60 * .26 / 4 = 3.9 pixels of 64, 39 of 640: below 40, 45 and 50.
  EXPECT_NEAR(frames.all.mspd, 0.3, 1e-12);
  EXPECT_LT(frames.all.vsd, 1);
  EXPECT_GT(frames.all.vsd, 0);
}

TEST_F(SingleFramesOfARun, CountWhatTheMapDidNotHoldYetAsWrong) {
  const SingleFrames frames = Judge(0, 1);
  EXPECT_EQ(frames.all.targets, 3);
  EXPECT_EQ(frames.all.estimated, 2);
  EXPECT_NEAR(frames.all.average(), 2.0 / 3, 1e-12);
  EXPECT_EQ(Judge(0, 5).all.average(), 0);
}

TEST_F(SingleFramesOfARun, LeaveOutWhatTheScanHides) {
  const TriangleMesh wall = MakeParallelogram({-9, -9, 3}, {18, 0, 0}, {0, 18, 0});
  const SingleFrames frames = Judge(0, 0, &wall);
  EXPECT_EQ(frames.scan, 5);
  EXPECT_EQ(frames.all.targets, 0);
}

TEST_F(SingleFramesOfARun, PreferMeasuredDepth) {
  // Nothing nearer than 6 m in frame 1; the scan would hide the cube.
  std::filesystem::create_directory(Folder() / "sequence" / "depth");
  cv::imwrite((Folder() / "sequence" / "depth" / "000001.png").string(),
              cv::Mat(48, 64, CV_16UC1, cv::Scalar(6000)));
  const TriangleMesh wall = MakeParallelogram({-9, -9, 3}, {18, 0, 0}, {0, 18, 0});
  const SingleFrames frames = Judge(0, 0, &wall, 1);
  EXPECT_EQ(frames.frames, 1);
  EXPECT_EQ(frames.measured, 1);
  EXPECT_EQ(frames.all.targets, 1);
  const nlohmann::json json = SingleFramesToJson(frames);
  EXPECT_EQ(json["hidden_by"]["measured_depth"], 1);
  EXPECT_EQ(json["ar"], 1);
  EXPECT_EQ(json["by_instance"]["a"]["targets"], 1);
}

}  // namespace
}  // namespace plumbline
