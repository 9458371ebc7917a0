// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/image_file.h"

#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

cv::Mat Picture() {
  cv::Mat image(60, 80, CV_8UC3);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      image.at<cv::Vec3b>(y, x) = cv::Vec3b(3 * x, 4 * y, static_cast<unsigned char>(x * y));
    }
  }
  return image;
}

class ImageFile : public testing::TestWithParam<const char*> {
 protected:
  std::string Bytes() const { return ReadFile(file_).value(); }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / (std::string("image") + GetParam());
  bool written_ = cv::imwrite(file_.string(), Picture());
};

TEST_P(ImageFile, ReadsThePixelsThatOpenCvReads) {
  const Result<cv::Mat> image = ReadImage(file_, ImageKind::kColor, cv::Size(80, 60));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(cv::norm(*image, cv::imread(file_.string(), cv::IMREAD_COLOR), cv::NORM_INF), 0);
  const Result<cv::Mat> gray = ReadImage(file_, ImageKind::kGray);
  ASSERT_TRUE(gray.ok()) << gray.error().message;
  EXPECT_EQ(gray->type(), CV_8UC1);
}

TEST_P(ImageFile, SaysThatTheSizeIsAnother) {
  const Result<cv::Mat> image = ReadImage(file_, ImageKind::kColor, cv::Size(640, 480));
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::kInvalidInput);
  EXPECT_NE(image.error().message.find("80x60"), std::string::npos);
  EXPECT_NE(image.error().message.find(file_.string()), std::string::npos);
}

TEST_P(ImageFile, NoticesEveryTruncation) {
  const std::string bytes = Bytes();
  for (std::size_t length = 0; length + 2 < bytes.size(); length += 1 + bytes.size() / 97) {
    WriteText(file_, bytes.substr(0, length));
    EXPECT_FALSE(ReadImage(file_, ImageKind::kColor).ok()) << length << " of " << bytes.size();
  }
}

TEST_P(ImageFile, SurvivesDamage) {
  const std::string bytes = Bytes();
  Random random({.seed = 3});
  for (int round = 0; round < 200; ++round) {
    std::string damaged = bytes;
    for (int i = 0; i < 5; ++i)
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Index(256));
    WriteText(file_, damaged);
    const Result<cv::Mat> image = ReadImage(file_, ImageKind::kColor, cv::Size(80, 60));
    if (image.ok()) {
      EXPECT_EQ(image->size(), cv::Size(80, 60));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ImageFile, testing::Values(".jpg", ".png"),
                         [](const auto& param) { return std::string(param.param + 1); });

TEST(ReadImage, NamesAMissingFileAndAForeignFormat) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "image.jpg";
  EXPECT_EQ(ReadImage(file, ImageKind::kColor).error().code, ErrorCode::kNotFound);
  WriteText(file, "GIF89a and so on");
  EXPECT_EQ(ReadImage(file, ImageKind::kColor).error().code, ErrorCode::kUnsupported);
}

TEST(ReadImage, DoesNotBelieveAHeaderThatClaimsAHugeImage) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "image.png";
  cv::imwrite(file.string(), Picture());
  std::string bytes = ReadFile(file).value();
  bytes[16] = bytes[20] = 0x7f;
  WriteText(file, bytes);
  EXPECT_EQ(ReadImage(file, ImageKind::kColor).error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace plumbline
