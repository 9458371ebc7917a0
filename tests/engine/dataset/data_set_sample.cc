// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/dataset/data_set_sample.h"

#include <cstdlib>
#include <map>
#include <string>

#include <opencv2/core.hpp>

namespace plumbline {

void DataSetSample::Write(const std::string& layout, const std::string& more,
                          const std::string& interpreter) {
  if (std::system((interpreter + " -c 'import zlib' 2>/dev/null").c_str()) != 0)
    GTEST_SKIP() << "there is no Python to write the sample";
  // Each sample is written once, and copied for those who change it.
  static const TemporaryFolder kWritten;
  static std::map<std::string, std::filesystem::path> places;
  const std::string wanted = layout + " " + more;
  if (!places.contains(wanted)) {
    const auto place = kWritten.path() / std::to_string(places.size());
    const auto script = SourceDirectory() / "tests/engine/dataset/data_set_samples.py";
    const std::string command = interpreter + " -B '" + script.string() + "' " + layout + " '" +
                                place.string() + "' " + more;
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    places[wanted] = place;
  }
  std::filesystem::copy(
      places[wanted], folder_.path(),
      std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
}

std::shared_ptr<const Sequence> DataSetSample::Open(const std::string& path) {
  const auto opened = OpenSequence(folder_.path() / path);
  if (!opened.ok()) throw std::runtime_error(opened.error().message);
  return *opened;
}

std::string DataSetSample::WhyNot(const std::string& path) {
  const auto opened = OpenSequence(folder_.path() / path);
  return opened.ok() ? "it opens" : opened.error().message;
}

Eigen::Isometry3d SamplePose(double i) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  pose.translation() << 0.5 * i, 0.25, 1 + 0.1 * i;
  return pose;
}

void ExpectSampleImage(const Sequence& sequence, int frame, int i) {
  const Result<cv::Mat> image = sequence.ReadRawImage(frame);
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->type(), CV_8UC3);
  ASSERT_EQ(image->size(), cv::Size(sequence.camera().width, sequence.camera().height));
  for (int y = 3; y < image->rows; y += 37) {
    for (int x = 5; x < image->cols; x += 41) {
      const cv::Vec3b expected((30 * i + 10) % 256, 7 * (y / 16) % 256,
                               (5 * (x / 16) + 40 * i) % 256);
      ASSERT_EQ(image->at<cv::Vec3b>(y, x), expected)
          << "frame " << frame << " at " << x << ", " << y;
    }
  }
}

void ExpectSampleDepth(const Sequence& sequence, int frame, int i) {
  const auto depth = sequence.ReadDepth(frame);
  ASSERT_TRUE(depth.ok()) << depth.error().message;
  ASSERT_TRUE(depth->has_value()) << "frame " << frame << " has no depth";
  ASSERT_EQ((*depth)->type(), CV_16UC1);
  ASSERT_EQ((*depth)->size(), cv::Size(sequence.camera().width, sequence.camera().height));
  for (int y = 3; y < (*depth)->rows; y += 37) {
    for (int x = 5; x < (*depth)->cols; x += 41) {
      const int expected = x < 16 ? 0 : 1000 + 10 * (x / 16) + i;
      ASSERT_EQ((*depth)->at<std::uint16_t>(y, x), expected)
          << "frame " << frame << " at " << x << ", " << y;
    }
  }
}

}  // namespace plumbline
