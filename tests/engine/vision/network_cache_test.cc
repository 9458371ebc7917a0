// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

cv::Mat Noise(int rows, int cols, int type, std::uint64_t seed) {
  cv::Mat image(rows, cols, type);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

TEST(NetworkCache, GivesBackWhatItWasGiven) {
  const TemporaryFolder folder;
  NetworkCache cache(folder.path(), 1 << 20);
  const std::string key = NetworkCacheKey("network", Noise(5, 7, CV_8UC3, 1));
  EXPECT_FALSE(cache.Get(key).has_value());
  cache.Put(key, std::string("a\0b", 3));
  EXPECT_EQ(cache.Get(key), std::string("a\0b", 3));
  EXPECT_EQ(NetworkCache(folder.path(), 1 << 20).Get(key), std::string("a\0b", 3));
  EXPECT_FALSE(NetworkCache(folder.path(), 0).Get(key).has_value());
}

TEST(NetworkCache, KeysTellNetworksImagesAndShapesApart) {
  const cv::Mat image = Noise(6, 4, CV_8UC3, 1);
  const std::string key = NetworkCacheKey("a", image);
  EXPECT_EQ(key, NetworkCacheKey("a", image.clone()));
  EXPECT_EQ(NetworkCacheKey("a", Noise(12, 8, CV_8UC3, 2)(cv::Rect(1, 1, 4, 6))),
            NetworkCacheKey("a", Noise(12, 8, CV_8UC3, 2)(cv::Rect(1, 1, 4, 6)).clone()));
  EXPECT_NE(key, NetworkCacheKey("b", image));
  EXPECT_NE(key, NetworkCacheKey("a", image.reshape(3, 4)));
  cv::Mat other = image.clone();
  other.data[0] ^= 1;
  EXPECT_NE(key, NetworkCacheKey("a", other));
}

TEST(NetworkCache, TakesDamagedFilesForAbsent) {
  const TemporaryFolder folder;
  NetworkCache cache(folder.path(), 1 << 20);
  cache.Put("abcd", "content");
  const auto file = folder.path() / "ab" / "abcd";
  std::string bytes = *ReadFile(file);
  bytes.back() ^= 1;
  ASSERT_TRUE(WriteFileAtomically(file, bytes).ok());
  EXPECT_FALSE(cache.Get("abcd").has_value());
  ASSERT_TRUE(WriteFileAtomically(file, "short").ok());
  EXPECT_FALSE(cache.Get("abcd").has_value());
}

TEST(NetworkCache, ForgetsWhatWasNotUsedForLongest) {
  const TemporaryFolder folder;
  NetworkCache cache(folder.path(), 10000);
  const std::string content(1000, 'x');
  const auto key = [](int i) { return "key" + std::to_string(100 + i); };
  for (int i = 0; i < 30; ++i) {
    cache.Put(key(i), content);
    std::filesystem::last_write_time(
        folder.path() / "ke" / key(i),
        std::filesystem::file_time_type::clock::now() - std::chrono::seconds(100 - i));
    EXPECT_TRUE(cache.Get(key(0)).has_value()) << "used all the time, after " << i;
  }
  std::uintmax_t total = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder.path() / "ke"))
    total += file.file_size();
  EXPECT_LE(total, 12000u);
  EXPECT_TRUE(cache.Get(key(29)).has_value());
  EXPECT_FALSE(cache.Get(key(1)).has_value());
}

TEST(NetworkCache, KeepsEdgesAndTensorsBitForBit) {
  const EdgeMap edges{Noise(31, 17, CV_8UC1, 3), Noise(31, 17, CV_8UC1, 4)};
  const auto back = DecodeEdges(EncodeEdges(edges));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(cv::norm(back->probability, edges.probability, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(back->angle, edges.angle, cv::NORM_INF), 0);
  const int size[] = {1, 3, 4, 5};
  cv::Mat tensor(4, size, CV_32FC1);
  cv::RNG(5).fill(tensor, cv::RNG::UNIFORM, -1.0, 1.0);
  const std::string bytes = EncodeTensors({tensor});
  const auto tensor_back = DecodeTensors(bytes);
  ASSERT_TRUE(tensor_back.has_value());
  EXPECT_EQ(EncodeTensors(*tensor_back), bytes);
  const std::string two = EncodeTensors({tensor, tensor});
  ASSERT_TRUE(DecodeTensors(two).has_value());
  EXPECT_EQ(EncodeTensors(*DecodeTensors(two)), two);
  for (std::size_t cut = 0; cut < bytes.size(); cut += 7)
    EXPECT_FALSE(DecodeTensors(std::string_view(bytes).substr(0, cut)).has_value());
  EXPECT_FALSE(DecodeEdges("nothing").has_value());
}

}  // namespace
}  // namespace plumbline
