// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/random_access_file.h"
#include "engine/base/result.h"

namespace plumbline {

struct BagTopic {
  std::string name, type;  ///< As /cam0/image_raw and sensor_msgs/Image.
};

/// Where a message lies.
struct BagMessage {
  std::size_t topic = 0;      ///< Index in BagFile::topics().
  std::int64_t stamp_ns = 0;  ///< When it was recorded; what it says itself may differ.
  std::size_t chunk = 0;      ///< Index of the chunk.
  std::uint32_t offset = 0;   ///< In the chunk, uncompressed.
};

/// A ROS 1 bag of format 2.0 (wiki.ros.org/Bags/Format/2.0): its index is read when it is opened,
/// messages when they are asked for. Chunks may be compressed with bz2 or LZ4; the last one that
/// was unpacked is kept. All functions are safe to call from several threads.
///
/// It is read here and not by rosbag_storage, which copies by lengths and offsets that it has not
/// checked, so that a damaged bag ends the program. Tests compare the two.
class BagFile {
 public:
  /// Errors: kNotFound, kIo, kCorrupt, kUnsupported (another version, encryption), kInvalidInput (a
  /// bag without index, as one that was not closed), naming the file.
  static Result<std::shared_ptr<const BagFile>> Open(const std::filesystem::path& file);
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  const std::filesystem::path& path() const { return file_.path(); }
  const std::vector<BagTopic>& topics() const { return topics_; }
  /// By the time at which they were recorded.
  const std::vector<BagMessage>& messages() const { return messages_; }
  /// The message as it was sent; of a long one at least the first `enough` bytes. Errors: kIo,
  /// kCorrupt.
  Result<std::string> Read(const BagMessage& message, std::size_t enough = SIZE_MAX) const;

 private:
  struct Chunk {
    std::uint64_t data_begin = 0;
    std::uint32_t packed_size = 0, size = 0;
    std::string compression;
  };
  struct Record;
  explicit BagFile(RandomAccessFile file) : file_(std::move(file)) {}

  Result<Record> ReadRecord(std::uint64_t begin) const;
  Status ReadIndex();
  Status ReadChunk(std::uint64_t begin);
  Status AddTopic(std::uint32_t connection, const std::string& name, std::string_view header);
  Result<std::shared_ptr<const std::string>> Unpacked(std::size_t chunk) const;

  RandomAccessFile file_;
  std::vector<BagTopic> topics_;
  std::vector<std::uint32_t> connections_;  ///< Of each topic: one topic may have several.
  std::vector<Chunk> chunks_;
  std::vector<BagMessage> messages_;
  mutable std::mutex mutex_;
  mutable std::size_t unpacked_chunk_ = SIZE_MAX;
  mutable std::shared_ptr<const std::string> unpacked_;
};

}  // namespace plumbline
