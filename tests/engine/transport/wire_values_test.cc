// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/wire_values.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <limits>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

cv::Mat Noise(int rows, int columns, int type) {
  cv::Mat image(rows, columns, type);
  cv::RNG random(5);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(WireValues, ImagesComeBackBitForBitInEveryForm) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat whole = Noise(50, 70, type);
    const cv::Mat image = whole(cv::Rect(3, 4, 41, 33));  // rows that do not follow one another
    const auto counts = std::make_shared<PixelCounts>();
    SendablePixels pixels(image, counts);
    wire::Request here, plain, elsewhere;
    here.set_machine(ThisMachine());
    plain.set_plain_pixels(true);
    elsewhere.set_machine("another");
    for (const wire::Request& request : {here, plain, elsewhere}) {
      const auto sent = pixels.For(request);
      ASSERT_TRUE(sent.ok());
      const auto back = PixelsFromWire(*sent);
      ASSERT_TRUE(back.ok()) << back.error().message;
      EXPECT_TRUE(Same(*back, image));
    }
    EXPECT_TRUE(pixels.For(here)->has_shared());
    EXPECT_TRUE(pixels.For(elsewhere)->has_png());
    EXPECT_EQ(counts->shared, 2u);
    EXPECT_EQ(counts->sent, 3u);
    const std::size_t bytes = image.total() * image.elemSize();
    EXPECT_EQ(counts->copied_bytes, 3 * bytes) << "one copy for each form, whoever asks";
  }
}

TEST(WireValues, SharedImagesAreSealedAndOutliveTheirOwner) {
  const cv::Mat image = Noise(60, 80, CV_8UC3);
  auto shared = SharedImage::Create(image);
  ASSERT_TRUE(shared.ok()) << shared.error().message;
  const wire::SharedMemory name = (*shared)->name();
  auto first = MapSharedImage(name, image.size(), CV_8UC3);
  auto second = MapSharedImage(name, image.size(), CV_8UC3);
  ASSERT_TRUE(first.ok() && second.ok());
  first->setTo(0);
  EXPECT_TRUE(Same(*second, image)) << "whoever writes changes a copy of its own";
  EXPECT_EQ(MapSharedImage(name, {81, 60}, CV_8UC3).error().code, ErrorCode::kCorrupt);
  shared = Error{ErrorCode::kCancelled, ""};
  EXPECT_TRUE(Same(*second, image));
  EXPECT_EQ(MapSharedImage(name, image.size(), CV_8UC3).error().code, ErrorCode::kNotFound);
}

TEST(WireValues, WhatIsNoSharedImageIsNotMapped) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  const int descriptor = fileno(file);
  ASSERT_EQ(ftruncate(descriptor, 300), 0);
  struct stat state {};
  fstat(descriptor, &state);
  wire::SharedMemory name;
  name.set_process(getpid());
  name.set_file(descriptor);
  name.set_inode(state.st_ino);
  name.set_bytes(300);
  EXPECT_EQ(MapSharedImage(name, {10, 10}, CV_8UC3).error().code, ErrorCode::kCorrupt);
  std::fclose(file);
}

TEST(WireValues, ImagesThatLieAboutThemselvesAreRefused) {
  wire::Pixels pixels;
  pixels.set_width(10);
  pixels.set_height(10);
  pixels.set_channels(3);
  EXPECT_FALSE(PixelsFromWire(pixels).ok());
  pixels.set_plain(std::string(299, 'x'));
  EXPECT_FALSE(PixelsFromWire(pixels).ok());
  pixels.set_png("\x89PNG no");
  EXPECT_FALSE(PixelsFromWire(pixels).ok());
  SendablePixels large(Noise(20, 20, CV_8UC3), std::make_shared<PixelCounts>());
  pixels.set_png(large.For({})->png());
  EXPECT_FALSE(PixelsFromWire(pixels).ok());
  pixels.set_width(1u << 31);
  pixels.set_height(1u << 31);
  EXPECT_FALSE(PixelsFromWire(pixels).ok());
}

TEST(WireValues, PosesKeepEveryBit) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(0.123456789, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  pose.translation() << 0.1, -1.0 / 3, 1e-17;
  google::protobuf::RepeatedField<double> rows;
  SetTransform(pose, rows);
  const auto back = TransformFromWire(rows);
  ASSERT_TRUE(back.ok());
  EXPECT_TRUE(back->matrix() == pose.matrix());
  rows[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(TransformFromWire(rows).ok());
  rows.RemoveLast();
  EXPECT_FALSE(TransformFromWire(rows).ok());
}

TEST(WireValues, ScoresOutsideTheirRangeAreRefused) {
  wire::Proposals proposals =
      ProposalsToWire(std::vector<Detection>{{{1, 2, 3, 4}, "chair", 0.5f}});
  ASSERT_TRUE(ProposalsFromWire(proposals).ok());
  proposals.mutable_proposals(0)->set_score(1.5f);
  EXPECT_FALSE(ProposalsFromWire(proposals).ok());
  proposals.mutable_proposals(0)->set_score(0.5f);
  proposals.mutable_proposals(0)->set_x0(std::numeric_limits<float>::infinity());
  EXPECT_FALSE(ProposalsFromWire(proposals).ok());
}

}  // namespace
}  // namespace plumbline
