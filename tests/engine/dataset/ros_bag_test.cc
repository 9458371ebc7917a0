// SPDX-License-Identifier: Apache-2.0
// Bags of ROS 1: written by data_set_samples.py and, where it is installed, by ROS's own library.
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/dataset/bag_file.h"
#include "engine/dataset/ros_messages.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class RosBag : public DataSetSample {
 protected:
  void ExpectSampleBag() {
    const auto sequence = Open("sample.bag");
    EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "rosbag");
    ASSERT_EQ(sequence->num_frames(), 4);
    EXPECT_THAT(sequence->warnings(), IsEmpty());
    const Camera& camera = sequence->calibration().cameras[0].camera;
    EXPECT_EQ(sequence->calibration().cameras[0].name, "/cam0/image_raw");
    EXPECT_EQ(camera.pinhole, (PinholeCamera{160, 120, 130, 131, 81, 61}));
    EXPECT_EQ(camera.model, CameraModel::kRadialTangential);
    EXPECT_THAT(camera.distortion, ElementsAre(-0.2, 0.05, 0.001, -0.002));
    for (const int i : {2, 0, 3, 1}) ExpectSampleImage(*sequence, i, i);
  }
};

TEST_F(RosBag, IsReadFieldByField) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  ExpectSampleBag();
}

TEST_F(RosBag, IsReadFromCompressedChunks) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag", "bz2"));
  if (IsSkipped()) return;
  ExpectSampleBag();
}

TEST_F(RosBag, StampsAreThoseOfTheHeadersNotOfTheRecording) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  const auto sequence = Open("sample.bag");
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(sequence->stamp_ns(i), 1600000000'000000000 + 100000000LL * i);
  EXPECT_EQ(sequence->ReadImu()->samples.front().stamp_ns, 1600000000'000000000);
}

TEST_F(RosBag, TfGivesPosesAndThePlaceOfTheCameraOnTheBody) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  const auto sequence = Open("sample.bag");
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-6, 1e-9)) << i;
  EXPECT_FALSE(sequence->world_from_cam(3).has_value()) << "TF has ended before";
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
  Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();
  body_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  body_from_cam.translation() << 0.8, 0.1, 0.95;
  EXPECT_THAT(*sequence->calibration().cameras[0].camera.body_from_cam,
              IsometryNear(body_from_cam, 1e-6, 1e-12));
}

TEST_F(RosBag, TheImuIsReadInItsUnits) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  const auto imu = Open("sample.bag")->ReadImu();
  ASSERT_TRUE(imu.ok()) << imu.error().message;
  ASSERT_EQ(imu->samples.size(), 80u);
  EXPECT_EQ(imu->samples[23].angular_velocity_rad_s, Eigen::Vector3d(0.03, 0.02, -0.03));
  EXPECT_EQ(imu->samples[23].specific_force_m_s2, Eigen::Vector3d(0.1, 0.2, 9.81));
}

TEST_F(RosBag, DepthInMetresBecomesMillimetres) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  // Without distortion, so that pixels stay where they are.
  ASSERT_TRUE(WriteFileAtomically(folder() / "sample.bag.json",
                                  R"({"camera": {"width": 160, "height": 120, "model": "pinhole",
                                      "fx": 130, "fy": 131, "cx": 81, "cy": 61, "rate_hz": 10}})")
                  .ok());
  const auto sequence = Open("sample.bag");
  for (int i = 0; i < 4; ++i) ExpectSampleDepth(*sequence, i, i);
}

TEST_F(RosBag, AFileBesideItChoosesTopicsAndDescribesWhatItLacks) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  const auto choice = folder() / "sample.bag.json";
  ASSERT_TRUE(WriteFileAtomically(choice, R"({"image_topic": "/cam1/image_raw/compressed"})").ok());
  EXPECT_THAT(WhyNot("sample.bag"),
              testing::AllOf(HasSubstr("/cam1/camera_info"), HasSubstr("sample.bag.json")));
  ASSERT_TRUE(
      WriteFileAtomically(
          choice, R"({"image_topic": "/cam1/image_raw/compressed", "camera_frame": "cam0_optical",
                    "camera": {"width": 160, "height": 120, "model": "pinhole", "fx": 100, "fy": 100,
                               "cx": 80, "cy": 60}, "imu": {"gyro_noise_density": 0.002}})")
          .ok());
  const auto sequence = Open("sample.bag");
  ASSERT_EQ(sequence->num_frames(), 2);
  EXPECT_EQ(sequence->camera().fx, 100);
  EXPECT_EQ(sequence->calibration().imu->gyro_noise_density, 0.002);
  for (int i = 0; i < 2; ++i) ExpectSampleImage(*sequence, i, i);
  EXPECT_THAT(*sequence->world_from_cam(1), IsometryNear(SamplePose(1), 1e-6, 1e-9));
  ASSERT_TRUE(WriteFileAtomically(choice, R"({"image_topic": "/cam7"})").ok());
  EXPECT_THAT(WhyNot("sample.bag"), HasSubstr("/cam7"));
}

TEST_F(RosBag, OneThatWasCutOffIsRefusedInASentence) {
  ASSERT_NO_FATAL_FAILURE(Write("ros_bag"));
  if (IsSkipped()) return;
  const auto file = folder() / "sample.bag";
  const auto size = std::filesystem::file_size(file);
  std::filesystem::resize_file(file, size - 40);
  EXPECT_THAT(WhyNot("sample.bag"), HasSubstr("damaged"));
  std::filesystem::resize_file(file, size / 2);
  EXPECT_THAT(WhyNot("sample.bag"), HasSubstr("rosbag reindex"));
  ASSERT_TRUE(WriteFileAtomically(file, "#ROSBAG V1.2\n").ok());
  EXPECT_THAT(WhyNot("sample.bag"), HasSubstr("1.2"));
}

TEST(RosImages, OfEveryEncodingAreReadAsColour) {
  const auto image = [](const std::string& encoding, int width, int height, int step,
                        const std::string& data) {
    const auto number = [](std::uint32_t value) {
      return std::string(reinterpret_cast<const char*>(&value), 4);
    };
    const auto text = [&](const std::string& t) {
      return number(static_cast<std::uint32_t>(t.size())) + t;
    };
    return std::string(12, '\0') + text("cam") + number(static_cast<std::uint32_t>(height)) +
           number(static_cast<std::uint32_t>(width)) + text(encoding) + std::string(1, '\0') +
           number(static_cast<std::uint32_t>(step)) + text(data);
  };
  const auto first = [&](const std::string& encoding, const std::string& pixel) {
    std::string data;
    for (int i = 0; i < 16; ++i) data += pixel;
    const auto read =
        ParseRosImage(image(encoding, 4, 4, 4 * static_cast<int>(pixel.size()), data));
    EXPECT_TRUE(read.ok()) << encoding;
    return read.ok() ? read->at<cv::Vec3b>(0, 0) : cv::Vec3b();
  };
  EXPECT_EQ(first("bgr8", "\1\2\3"), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(first("rgb8", "\1\2\3"), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(first("rgba8", "\1\2\3\4"), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(first("mono8", "\x28"), cv::Vec3b(40, 40, 40));
  EXPECT_EQ(first("mono16", std::string("\0\x28", 2)), cv::Vec3b(40, 40, 40));
  // Red in the first pixel of the first row.
  std::string mosaic;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) mosaic += x % 2 == 0 && y % 2 == 0 ? '\x64' : '\0';
  }
  EXPECT_EQ(ParseRosImage(image("bayer_rggb8", 8, 8, 8, mosaic))->at<cv::Vec3b>(4, 4),
            cv::Vec3b(0, 0, 100));
  EXPECT_EQ(ParseRosImage(image("bayer_bggr8", 8, 8, 8, mosaic))->at<cv::Vec3b>(4, 4),
            cv::Vec3b(100, 0, 0));
  EXPECT_THAT(ParseRosImage(image("mono8", 4, 4, 2, std::string(16, '\0'))).error().message,
              HasSubstr("damaged"));
  EXPECT_THAT(ParseRosImage(image("rgb16", 4, 4, 24, std::string(96, '\0'))).error().message,
              HasSubstr("rgb16"));
}

/// What ROS's own library says of a bag, line by line.
std::string Listed(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  char part[4096];
  while (pipe != nullptr && std::fgets(part, sizeof part, pipe) != nullptr) text += part;
  if (pipe != nullptr) pclose(pipe);
  return text;
}

std::string ListedByUs(const std::filesystem::path& file) {
  const auto bag = BagFile::Open(file);
  if (!bag.ok()) return bag.error().message;
  std::ostringstream text;
  for (const BagMessage& message : (*bag)->messages()) {
    const auto bytes = (*bag)->Read(message);
    if (!bytes.ok()) return bytes.error().message;
    std::uint32_t sum = 0;
    for (const char byte : *bytes) sum = 31 * sum + static_cast<unsigned char>(byte);
    const BagTopic& topic = (*bag)->topics()[message.topic];
    text << message.stamp_ns << ' ' << topic.name << ' ' << topic.type << ' ' << bytes->size()
         << ' ' << sum << '\n';
  }
  return text.str();
}

/// Lines of one stamp may come in any order.
std::vector<std::string> SortedLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  std::sort(lines.begin(), lines.end());
  return lines;
}

class RosLibrary : public DataSetSample {
 protected:
  void SetUp() override {
    const char* writer = std::getenv("PLUMBLINE_ROSBAG_WRITER");
    if (writer == nullptr || !std::filesystem::exists(writer))
      GTEST_SKIP() << "ROS's library (librosbag-storage-dev) was not there when this was built";
    writer_ = writer;
  }
  std::string writer_;
};

TEST_F(RosLibrary, WritesWhatWeReadCompressedOrNot) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const auto file = folder() / (compression + ".bag");
    ASSERT_EQ(std::system((writer_ + " write " + compression + " " + file.string()).c_str()), 0);
    const std::string theirs = Listed(writer_ + " list " + file.string());
    EXPECT_EQ(SortedLines(ListedByUs(file)), SortedLines(theirs));
    EXPECT_EQ(SortedLines(theirs).size(), 110u);
    const auto sequence = Open(compression + ".bag");
    ASSERT_EQ(sequence->num_frames(), 5);
    EXPECT_EQ(sequence->camera(), (PinholeCamera{64, 48, 60, 61, 31.5, 23.5}));
    EXPECT_EQ(sequence->ReadRawImage(3)->at<cv::Vec3b>(7, 9), cv::Vec3b(127, 127, 127));
    EXPECT_EQ(sequence->ReadImu()->samples.size(), 100u);
    EXPECT_EQ(sequence->ReadImu()->samples[45].angular_velocity_rad_s,
              Eigen::Vector3d(0.02, 0, 0.005));
  }
}

TEST_F(RosLibrary, ReadsTheSampleOfOurScriptAsWeDo) {
  for (const std::string compression : {"none", "bz2"}) {
    ASSERT_NO_FATAL_FAILURE(Write("ros_bag", compression));
    if (IsSkipped()) return;
    const auto file = folder() / "sample.bag";
    const std::string theirs = Listed(writer_ + " list " + file.string());
    EXPECT_EQ(SortedLines(theirs).size(), 101u);
    EXPECT_EQ(SortedLines(ListedByUs(file)), SortedLines(theirs));
  }
}

}  // namespace
}  // namespace plumbline
