// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/plumbline_sequence.h"

#include <ctime>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class OwnLayout : public testing::Test {
 protected:
  std::shared_ptr<const Sequence> Open() {
    Result<std::shared_ptr<const Sequence>> sequence = OpenSequence(root_);
    EXPECT_TRUE(sequence.ok()) << sequence.error().message;
    return sequence.ok() ? *sequence : nullptr;
  }
  /// The error's sentence.
  std::string Refusal() {
    const Result<std::shared_ptr<const Sequence>> sequence = OpenSequence(root_);
    return sequence.ok() ? "opened" : sequence.error().message;
  }
  void Rename(const std::string& from, const std::string& to) {
    std::filesystem::rename(root_ / "color" / from, root_ / "color" / to);
  }
  std::vector<std::int64_t> Stamps(const Sequence& sequence) {
    std::vector<std::int64_t> stamps;
    for (int i = 0; i < sequence.num_frames(); ++i) stamps.push_back(sequence.stamp_ns(i));
    return stamps;
  }

  TemporaryFolder folder_;
  std::filesystem::path root_ = folder_.path() / "sequence";
};

TEST_F(OwnLayout, OpensWithStampsPosesGravityAndFloor) {
  WriteTinySequence(root_);
  const auto sequence = Open();
  EXPECT_EQ(sequence->num_frames(), 5);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{64, 48, 60, 60, 31.5, 23.5}));
  EXPECT_EQ(sequence->rate_hz(), 10);
  EXPECT_EQ(sequence->stamp_ns(3), 300000000);
  EXPECT_EQ(sequence->world_from_cam(3)->translation(), Eigen::Vector3d(3, 0, 1));
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(*sequence->floor_in_world(), Eigen::Vector4d(0, 0, 1, 0));
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_FALSE(sequence->scene_file() || sequence->models_folder() ||
               sequence->ground_truth_file());
  const Result<Frame> frame = sequence->ReadFrame(3);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->index, 3);
  EXPECT_EQ(frame->stamp_ns, 300000000);
  EXPECT_EQ(frame->image.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::norm(frame->image, cv::imread((root_ / "color/000003.jpg").string()), cv::NORM_INF),
            0);
  EXPECT_FALSE(sequence->ReadEdges(3).value().has_value());
  EXPECT_FALSE(sequence->ReadProposals(3).value().has_value());
  EXPECT_THROW(sequence->stamp_ns(5), ContractError);
}

TEST_F(OwnLayout, TakesStampsFromColorCsvToTheNanosecond) {
  WriteTinySequence(root_, {.frames = 3});
  Rename("000001.jpg", "left.jpg");
  WriteText(root_ / "color.csv",
            "stamp_s,file\n1403636579.763555584,000000.jpg\n1403636579.863555585,color/left.jpg\n");
  WriteText(root_ / "trajectory.txt", "1403636579.8 7 0 0 0 0 0 1\n");
  const auto sequence = Open();
  EXPECT_THAT(Stamps(*sequence), testing::ElementsAre(1403636579763555584, 1403636579863555585));
  EXPECT_EQ(sequence->world_from_cam(0)->translation().x(),
            7);  // 36 ms away, half a period is 50 ms
  EXPECT_FALSE(sequence->world_from_cam(1));
  EXPECT_TRUE(sequence->ReadFrame(1).ok());
}

TEST_F(OwnLayout, GapsInTheNumbersAreTimeThatPassesNotFrames) {
  WriteTinySequence(root_);
  std::filesystem::remove(root_ / "color/000002.jpg");
  const auto sequence = Open();
  EXPECT_EQ(sequence->num_frames(), 4);
  EXPECT_EQ(sequence->stamp_ns(2), 300000000);
  EXPECT_EQ(sequence->world_from_cam(2)->translation().x(), 3);  // by stamp, not by row
  EXPECT_THAT(sequence->warnings(), IsEmpty());
}

TEST_F(OwnLayout, NumbersNeedNoLeadingZeros) {
  WriteTinySequence(root_);
  Rename("000000.jpg", "2000000.jpg");
  Rename("000003.jpg", "3.jpg");
  const auto sequence = Open();
  EXPECT_EQ(sequence->stamp_ns(2), 300000000);
  EXPECT_EQ(sequence->stamp_ns(4), 200000000000000);
}

TEST_F(OwnLayout, FramesWithoutAPoseNearbyAreNamed) {
  WriteTinySequence(root_);
  WriteText(root_ / "trajectory.txt",
            "0 0 0 0 0 0 0 1\n0.1 nan 0 0 0 0 0 1\n0.249 2 0 0 0 0 0 1\n0.351 3 0 0 0 0 0 1\n");
  const auto sequence = Open();
  EXPECT_TRUE(sequence->world_from_cam(0));
  EXPECT_FALSE(sequence->world_from_cam(1));
  EXPECT_EQ(sequence->world_from_cam(2)->translation().x(), 2);
  EXPECT_FALSE(sequence->world_from_cam(3));
  EXPECT_EQ(sequence->world_from_cam(4)->translation().x(), 3);
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("line 2: the pose is not finite")));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("2 of 5 frames (such as '000001.jpg')")));
}

TEST_F(OwnLayout, UnusableImagesAreErrorsOfTheirFrameOnly) {
  WriteTinySequence(root_);
  const std::string bytes = ReadFile(root_ / "color/000001.jpg").value();
  WriteText(root_ / "color/000001.jpg", bytes.substr(0, bytes.size() / 2));
  WriteText(root_ / "color/000002.jpg", "no image");
  cv::imwrite((root_ / "color/000003.jpg").string(), cv::Mat::zeros(10, 10, CV_8UC3));
  const auto sequence = Open();
  std::filesystem::remove(root_ / "color/000004.jpg");
  EXPECT_TRUE(sequence->ReadFrame(0).ok());
  for (int i = 1; i < 5; ++i) {
    const Result<Frame> frame = sequence->ReadFrame(i);
    ASSERT_FALSE(frame.ok()) << i;
    EXPECT_THAT(frame.error().message, HasSubstr("color/" + FrameName(i) + ".jpg"));
  }
  EXPECT_EQ(sequence->ReadFrame(1).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(sequence->ReadFrame(4).error().code, ErrorCode::kNotFound);
}

TEST_F(OwnLayout, AnImageThatColorCsvNamesButIsMissingIsAnErrorOfItsFrame) {
  WriteTinySequence(root_, {.frames = 2});
  WriteText(root_ / "color.csv", "0.0,000000.jpg\n0.1,nowhere.jpg\n0.2,000001.jpg\n");
  const auto sequence = Open();
  EXPECT_EQ(sequence->num_frames(), 3);
  EXPECT_EQ(sequence->ReadFrame(1).error().code, ErrorCode::kNotFound);
}

TEST_F(OwnLayout, OddRowsOfColorCsvAreNamed) {
  WriteTinySequence(root_);
  WriteText(root_ / "color.csv",
            "stamp_s,file\n0.3,000003.jpg\n0.1,000001.jpg\nnan,000002.jpg\n0.2\n0.4,../"
            "secret.jpg\n0.1,000004.jpg\n"
            "0.5,000001.jpg\n");
  const auto sequence = Open();
  EXPECT_THAT(Stamps(*sequence), testing::ElementsAre(100000000, 300000000));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("line 3: the stamp is before")));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("line 4 (and 2 more): not 'stamp_s,file'")));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("line 8: the image has a row already")));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("'000004.jpg'")));
}

TEST_F(OwnLayout, TwoImagesOfOneNumberAreNamed) {
  WriteTinySequence(root_);
  std::filesystem::copy(root_ / "color/000002.jpg", root_ / "color/000002.png");
  WriteText(root_ / "color/cover.png", "x");
  WriteText(root_ / "color/notes.txt", "x");
  const auto sequence = Open();
  EXPECT_EQ(sequence->num_frames(), 5);
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("'000002.png'")));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("'cover.png'")));
}

TEST_F(OwnLayout, PosesOfTheBodyNeedBodyFromCam) {
  WriteTinySequence(root_);
  WriteText(root_ / "trajectory.txt", "# world_from_body\n0 5 0 0 0 0 0 1\n");
  EXPECT_THAT(Refusal(), HasSubstr("body_from_cam"));
  WriteText(root_ / "camera.json",
            R"({"width": 64, "height": 48, "model": "pinhole", "fx": 60, "fy": 60, "cx": 31.5,
      "cy": 23.5, "rate_hz": 10, "body_from_cam": [[0,0,1,0.5],[-1,0,0,0],[0,-1,0,0],[0,0,0,1]], "serial": "kept"})");
  EXPECT_EQ(Open()->world_from_cam(0)->translation().x(), 5.5);
}

std::string CovarianceRow(const std::string& stamp) {
  std::string row = stamp;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) row += r != c ? ",0" : r < 3 ? ",0.0004" : ",0.0001";
  }
  return row + "\n";
}

TEST_F(OwnLayout, TellsHowUncertainItsPosesAre) {
  WriteTinySequence(root_);
  const std::filesystem::path file = root_ / "trajectory.covariance.csv";
  WriteText(file, "# filter\n" + CovarianceRow("0.0") + CovarianceRow("0.1"));
  const auto sequence = Open();
  EXPECT_NEAR(sequence->pose_uncertainty(1).drift(0, 0), 4e-4, 1e-12);
  EXPECT_TRUE(sequence->pose_uncertainty(1).own.isZero());
  EXPECT_TRUE(sequence->pose_uncertainty(2).drift.isZero());
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("3 poses, which count as exact")));

  WriteText(file, "# independent\n" + CovarianceRow("0.0"));
  EXPECT_NEAR(Open()->pose_uncertainty(0).own(5, 5), 1e-4, 1e-12);
  WriteText(file, "# world_from_body\n" + CovarianceRow("0.0"));
  EXPECT_THAT(Refusal(), HasSubstr("body_from_cam"));
  WriteText(file, "nonsense\n");
  EXPECT_THAT(Refusal(), HasSubstr("no usable covariance"));
}

TEST_F(OwnLayout, RefusesWithASentenceThatNamesTheFile) {
  EXPECT_THAT(Refusal(), HasSubstr("there is no sequence"));
  std::filesystem::create_directories(root_);
  EXPECT_THAT(Refusal(), HasSubstr("camera.json"));
  WriteTinySequence(root_);
  const std::string camera = ReadFile(root_ / "camera.json").value();
  WriteText(root_ / "camera.json", "{");
  EXPECT_THAT(Refusal(), HasSubstr("not valid JSON"));
  WriteText(
      root_ / "camera.json",
      R"({"width": 64, "height": 48, "model": "mei", "fx": 60, "fy": 60, "cx": 31, "cy": 23, "rate_hz": 10})");
  EXPECT_THAT(Refusal(), HasSubstr("camera model 'mei'"));
  WriteText(
      root_ / "camera.json",
      R"({"width": 64, "height": 48, "model": "pinhole", "fx": 60, "fy": 60, "cx": 31, "cy": 23})");
  EXPECT_THAT(Refusal(), HasSubstr("rate_hz"));
  WriteText(root_ / "camera.json", camera);
  for (const char* gravity : {"{}", "[]", R"({"gravity": [0,0,0]})", R"({"gravity": [0,0]})",
                              R"({"gravity": [0,0,-1], "floor": [1,0,0,0]})",
                              R"({"gravity": [0,0,-1], "floor": [0,0,0,1]})", "{"}) {
    WriteText(root_ / "gravity.json", gravity);
    EXPECT_THAT(Refusal(), HasSubstr("gravity.json")) << gravity;
  }
  std::filesystem::remove(root_ / "gravity.json");
  EXPECT_FALSE(Open()->gravity_in_world());
  WriteText(root_ / "trajectory.txt", "hello\n");
  EXPECT_THAT(Refusal(), HasSubstr("trajectory.txt"));
  std::filesystem::remove(root_ / "trajectory.txt");
  EXPECT_FALSE(Open()->world_from_cam(0));
  std::filesystem::remove_all(root_ / "color");
  EXPECT_THAT(Refusal(), HasSubstr("color"));
  std::filesystem::create_directories(root_ / "color");
  EXPECT_THAT(Refusal(), HasSubstr("no image"));
}

TEST_F(OwnLayout, TellsTheRateFromColorCsvWhereCameraJsonDoesNot) {
  WriteTinySequence(root_, {.frames = 4});
  WriteText(
      root_ / "camera.json",
      R"({"width": 64, "height": 48, "model": "pinhole", "fx": 60, "fy": 60, "cx": 31, "cy": 23})");
  WriteText(root_ / "color.csv", "0,000000.jpg\n0.05,000001.jpg\n0.1,000002.jpg\n0.9,000003.jpg\n");
  EXPECT_NEAR(Open()->rate_hz(), 20, 1e-9);
}

TEST_F(OwnLayout, TurnsOverAFloorThatPointsDown) {
  WriteTinySequence(root_);
  WriteText(root_ / "gravity.json", R"({"gravity": [0, 9.8, 0], "floor": [0, 2, 0, 3]})");
  const auto sequence = Open();
  EXPECT_EQ(*sequence->floor_in_world(), Eigen::Vector4d(0, -1, 0, -1.5));
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("points down")));
}

TEST_F(OwnLayout, FindsTheFloorUnderThePathOfACameraOfKnownHeight) {
  WriteTinySequence(root_);  // the camera goes along x at a height of 1
  WriteText(root_ / "gravity.json", R"({"gravity": [0, 0, -1], "camera_height_m": 1.65})");
  const auto sequence = Open();
  ASSERT_TRUE(sequence->floor_in_world().has_value());
  EXPECT_LT((*sequence->floor_in_world() - Eigen::Vector4d(0, 0, 1, 0.65)).norm(), 1e-9);
  EXPECT_NEAR(sequence->floor_std_m(), 0, 1e-9);
  // A floor that is told is believed.
  WriteText(root_ / "gravity.json",
            R"({"gravity": [0, 0, -1], "floor": [0, 0, 1, 0], "camera_height_m": 1.65})");
  EXPECT_EQ((*Open()->floor_in_world())[3], 0);
  for (const char* wrong : {"0", "-1", "\"high\"", "1e9", "null"}) {
    WriteText(root_ / "gravity.json",
              R"({"gravity": [0, 0, -1], "camera_height_m": )" + std::string(wrong) + "}");
    EXPECT_THAT(Refusal(), HasSubstr("'camera_height_m'")) << wrong;
  }
}

TEST_F(OwnLayout, KnowsLevelsBesideTheFloor) {
  WriteTinySequence(root_);
  EXPECT_THAT(Open()->floor_levels(), IsEmpty());
  const auto write = [&](const std::string& levels) {
    WriteText(root_ / "gravity.json",
              R"({"gravity": [0, 0, -1], "floor": [0, 0, 1, 0], "levels": )" + levels + "}");
  };
  write(R"([{"height_m": -0.2}, {"height_m": 0.3, "std_m": 0.01,
             "outline": [[0, 0, 0.3], [2, 0, 0.3], [2, 1, 0]]}])");
  const std::vector<FloorLevel> levels = Open()->floor_levels();
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[0].height_m, -0.2);
  EXPECT_THAT(levels[0].outline_in_world, IsEmpty());
  EXPECT_EQ(levels[1].std_m, 0.01);
  EXPECT_EQ(levels[1].outline_in_world.at(1), Eigen::Vector3d(2, 0, 0.3));
  write("{}");
  EXPECT_THAT(Refusal(), HasSubstr("not a list"));
  for (const auto& [level, complaint] : std::vector<std::pair<std::string, std::string>>{
           {"7", "height_m"},
           {"{}", "height_m"},
           {R"({"height_m": "high"})", "height_m"},
           {R"({"height_m": 1e9})", "height_m"},
           {R"({"height_m": 0.3, "std_m": -1})", "std_m"},
           {R"({"height_m": 0.3, "outline": [[0, 0, 0], [1, 0, 0]]})", "outline"},
           {R"({"height_m": 0.3, "outline": [[0, 0], [1, 0], [1, 1]]})", "outline"},
           {R"({"height_m": 0.3, "outline": [[0, 0, 0], [1, 0, 0], [2, 0, 5]]})", "no area"}}) {
    write(R"([{"height_m": 0.1}, )" + level + "]");
    EXPECT_THAT(Refusal(), testing::AllOf(HasSubstr("gravity.json"), HasSubstr("level 1"),
                                          HasSubstr(complaint)))
        << level;
  }
  WriteText(root_ / "gravity.json", R"({"gravity": [0, 0, -1], "levels": [{"height_m": 0.3}]})");
  EXPECT_THAT(Refusal(), HasSubstr("no 'floor'"));
}

TEST_F(OwnLayout, UndistortsItsImages) {
  WriteTinySequence(root_);
  WriteText(root_ / "camera.json",
            R"({"width": 64, "height": 48, "model": "radial_tangential", "fx": 60, "fy": 60,
      "cx": 31.5, "cy": 23.5, "distortion": [0.3, 0, 0, 0], "rate_hz": 10})");
  const Result<Frame> frame = Open()->ReadFrame(0);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  const cv::Mat recorded = cv::imread((root_ / "color/000000.jpg").string());
  EXPECT_EQ(frame->image.size(), recorded.size());
  EXPECT_GT(cv::norm(frame->image, recorded, cv::NORM_INF), 10);
}

TEST_F(OwnLayout, KeepsTheRecordedImageAndItsCameraForTracking) {
  WriteTinySequence(root_);
  WriteText(root_ / "camera.json",
            R"({"width": 64, "height": 48, "model": "fov", "fx": 30, "fy": 30, "cx": 31.5,
      "cy": 23.5, "distortion": [0.93], "rate_hz": 10})");
  const auto sequence = Open();
  const cv::Mat recorded = cv::imread((root_ / "color/000000.jpg").string());
  EXPECT_EQ(cv::norm(sequence->ReadRawImage(0).value(), recorded, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(sequence->ReadFrame(0).value().image, recorded, cv::NORM_INF), 10);
  ASSERT_EQ(sequence->calibration().cameras.size(), 1u);
  EXPECT_EQ(sequence->calibration().cameras[0].camera.model, CameraModel::kFov);
  EXPECT_EQ(sequence->calibration().cameras[0].camera.pinhole, sequence->camera());
  EXPECT_FALSE(sequence->calibration().imu);
}

TEST_F(OwnLayout, OpensWithoutImagesByTheTimesOfItsTracks) {
  WriteTinySequence(root_, {.edges = true, .proposals = true});
  std::filesystem::remove_all(root_ / "color");
  WriteText(root_ / "tracks.csv", "#t,id,u,v\n0.1,7,3,4\n0.3,7,4,4\n0.1,8,5,6\n0.2,7,3.5,4\n");
  const auto sequence = Open();
  EXPECT_FALSE(sequence->has_images());
  EXPECT_THAT(Stamps(*sequence), testing::ElementsAre(100000000, 200000000, 300000000));
  EXPECT_EQ(sequence->world_from_cam(2)->translation().x(), 3);
  for (const auto& message :
       {sequence->ReadFrame(1).error().message, sequence->ReadRawImage(1).error().message})
    EXPECT_THAT(message, HasSubstr("has no images"));
  EXPECT_FALSE(sequence->ReadEdges(1).value().has_value());
  EXPECT_FALSE(sequence->ReadProposals(1).value().has_value());
  EXPECT_FALSE(sequence->ReadDepth(1).value().has_value());
  WriteText(root_ / "color.csv", "0.25,a.png\n0.75,b.png\n");
  EXPECT_THAT(Stamps(*Open()), testing::ElementsAre(250000000, 750000000));
}

TEST_F(OwnLayout, ReadsTheImuToTheNanosecond) {
  WriteTinySequence(root_);
  EXPECT_FALSE(Open()->has_imu());
  EXPECT_TRUE(Open()->ReadImu().value().samples.empty());
  WriteText(root_ / "imu.csv", "#t,wx,wy,wz,ax,ay,az\n1403715285.002142976,1,2,3,4,5,6\n");
  WriteText(root_ / "imu.json", R"({"rate_hz": 200, "time_offset_s": 0.01})");
  const auto sequence = Open();
  const ImuRecording imu = sequence->ReadImu().value();
  ASSERT_EQ(imu.samples.size(), 1u);
  EXPECT_EQ(imu.samples[0].stamp_ns, 1403715285002142976);
  EXPECT_EQ(sequence->calibration().imu->time_offset_s, 0.01);
  WriteText(root_ / "imu.json", R"({"rate_hz": "fast"})");
  EXPECT_THAT(Refusal(), HasSubstr("imu.json"));
}

TEST_F(OwnLayout, ReadsDepthWhereThereIsAny) {
  WriteTinySequence(root_);
  std::filesystem::create_directories(root_ / "depth");
  cv::imwrite((root_ / "depth/000001.png").string(), cv::Mat(48, 64, CV_16UC1, cv::Scalar(1500)));
  cv::imwrite((root_ / "depth/000002.png").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(150)));
  const auto sequence = Open();
  EXPECT_TRUE(sequence->has_depth());
  EXPECT_FALSE(sequence->ReadDepth(0).value().has_value());
  EXPECT_EQ(sequence->ReadDepth(1).value()->at<std::uint16_t>(5, 5), 1500);
  EXPECT_EQ(sequence->ReadDepth(2).error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(sequence->ReadDepth(2).error().message, HasSubstr("16 bits"));
}

TEST_F(OwnLayout, TakesOtherPosesByStampWhereAskedTo) {
  WriteTinySequence(root_);
  const std::filesystem::path poses = folder_.path() / "poses.txt";
  WriteText(poses, "0.11 10 0 0 0 0 0 1\n0.29 30 0 0 0 0 0 1\n");
  const auto sequence = OpenSequence(root_, {.poses = poses}).value();
  EXPECT_FALSE(sequence->world_from_cam(0));
  EXPECT_EQ(sequence->world_from_cam(1)->translation().x(), 10);
  EXPECT_EQ(sequence->world_from_cam(3)->translation().x(), 30);
  EXPECT_EQ(NumPosedFrames(*sequence), 2);
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("poses.txt' has no pose")));
  EXPECT_THAT(OpenSequence(root_, {.poses = "nowhere.txt"}).error().message,
              HasSubstr("nowhere.txt"));
}

TEST(SequenceFormats, SayWhatWouldBeASequence) {
  const TemporaryFolder folder;
  const auto opened = OpenSequence(folder.path());
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("is not a supported sequence"));
  for (const SequenceFormat& format : SequenceFormats())
    EXPECT_THAT(opened.error().message, HasSubstr(std::string(format.expects)));
  EXPECT_EQ(FindSequenceFormat(folder.path()), nullptr);
  WriteText(folder.path() / "camera.json", "{}");
  EXPECT_EQ(FindSequenceFormat(folder.path())->name, "plumbline");
}

TEST_F(OwnLayout, ReadsEdgesAndProposals) {
  WriteTinySequence(root_, {.edges = true, .proposals = true});
  const auto sequence = Open();
  EXPECT_TRUE(sequence->has_edges());
  EXPECT_TRUE(sequence->has_proposals());
  const Result<std::optional<EdgeMap>> edges = sequence->ReadEdges(2);
  ASSERT_TRUE(edges.ok()) << edges.error().message;
  EXPECT_EQ(edges.value()->probability.at<unsigned char>(5, 12), 200);
  EXPECT_EQ(edges.value()->angle.size(), cv::Size(64, 48));
  const auto proposals = sequence->ReadProposals(2);
  ASSERT_TRUE(proposals.ok()) << proposals.error().message;
  EXPECT_EQ(proposals.value()->at(0).category, "chair");

  std::filesystem::remove(root_ / "edges/000001_angle.png");
  EXPECT_EQ(sequence->ReadEdges(1).error().code, ErrorCode::kCorrupt);
  std::filesystem::remove(root_ / "edges/000001.png");
  EXPECT_FALSE(sequence->ReadEdges(1).value().has_value());
  cv::imwrite((root_ / "edges/000003.png").string(), cv::Mat::zeros(4, 4, CV_8UC1));
  EXPECT_EQ(sequence->ReadEdges(3).error().code, ErrorCode::kCorrupt);
  WriteText(root_ / "proposals/000003.json", "[{]");
  EXPECT_EQ(sequence->ReadProposals(3).error().code, ErrorCode::kCorrupt);
}

TEST_F(OwnLayout, OpensTenThousandFramesInWellUnderASecond) {
  WriteTinySequence(root_, {.frames = 1});
  std::string trajectory, table = "stamp_s,file\n";
  for (int i = 0; i < 10000; ++i) {
    const std::string stamp = std::to_string(i * 0.1);
    table += stamp + "," + FrameName(i) + ".jpg\n";
    trajectory += stamp + " 1 2 3 0 0 0 1\n";
  }
  WriteText(root_ / "color.csv", table);
  WriteText(root_ / "trajectory.txt", trajectory);
  const std::clock_t start = std::clock();
  EXPECT_EQ(Open()->num_frames(), 10000);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 0.5);  // about 20 ms
}

TEST_F(OwnLayout, ListsAFolderOfManyImagesQuickly) {
  WriteTinySequence(root_, {.frames = 1});
  std::filesystem::remove(root_ / "trajectory.txt");
  // Names are all that is looked at, and links are quick to make.
  for (int i = 1; i < 1000; ++i) {
    std::filesystem::create_symlink("000000.jpg", root_ / "color" / (FrameName(i) + ".jpg"));
  }
  const std::clock_t start = std::clock();
  EXPECT_EQ(Open()->num_frames(), 1000);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 0.1);  // about 3 ms
}

TEST(Tango, OpensWithoutImages) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto sequence = OpenSequence(*shared / "data/vio/tango_lc").value();
  EXPECT_EQ(sequence->num_frames(), 969);
  EXPECT_EQ(sequence->stamp_ns(0), 524683655592184);
  EXPECT_EQ(sequence->ReadImu().value().samples.size(), 23741u);
  EXPECT_EQ(sequence->calibration().imu->saturation_accel_m_s2, 150);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
}

TEST(Kitchen, OpensAsPublished) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto sequence = OpenSequence(*shared / "data/kitchen").value();
  EXPECT_EQ(sequence->num_frames(), 600);
  EXPECT_EQ(sequence->camera().width, 640);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_TRUE(sequence->scene_file() && sequence->models_folder() && sequence->ground_truth_file());
  for (int i = 0; i < 600; ++i) EXPECT_TRUE(sequence->world_from_cam(i)) << i;
  EXPECT_NEAR(sequence->world_from_cam(2)->translation().x(), -0.508225, 1e-9);
  EXPECT_EQ(sequence->ReadFrame(599).value().image.size(), cv::Size(640, 480));
}

}  // namespace
}  // namespace plumbline
