// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/visma_dataset.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include <google/protobuf/io/coded_stream.h>

#include "engine/base/files.h"
#include "engine/dataset/rigid_matrix.h"

namespace plumbline {
namespace {

/// A field of a message as it is on the wire.
struct WireField {
  int number = 0;
  int type = 0;  ///< 0 varint, 1 eight bytes, 2 bytes behind their length, 5 four bytes.
  std::uint64_t value = 0;
  std::string bytes;
};

/// Hands the fields of a message over, one after the other; false where it is none.
bool ReadFields(const std::string& message, const std::function<bool(const WireField&)>& field) {
  google::protobuf::io::CodedInputStream stream(
      reinterpret_cast<const std::uint8_t*>(message.data()), static_cast<int>(message.size()));
  while (const std::uint32_t tag = stream.ReadTag()) {
    WireField read{static_cast<int>(tag >> 3), static_cast<int>(tag & 7), 0, {}};
    std::uint32_t small = 0;
    bool whole = false;
    if (read.type == 0) whole = stream.ReadVarint64(&read.value);
    if (read.type == 1) whole = stream.ReadLittleEndian64(&read.value);
    if (read.type == 5) whole = stream.ReadLittleEndian32(&small);
    if (read.type == 5) read.value = small;
    if (read.type == 2)
      whole = stream.ReadVarint32(&small) && small <= message.size() &&
              stream.ReadString(&read.bytes, static_cast<int>(small));
    if (!whole || !field(read)) return false;
  }
  return stream.ConsumedEntireMessage();
}

/// Appends one number, or those of a packed field.
bool AppendDoubles(const WireField& field, std::vector<double>& numbers) {
  if (field.type == 1) {
    numbers.push_back(std::bit_cast<double>(field.value));
    return true;
  }
  if (field.type != 2 || field.bytes.size() % 8 != 0) return false;
  for (std::size_t at = 0; at < field.bytes.size(); at += 8) {
    std::uint64_t bits = 0;
    for (std::size_t b = 8; b-- > 0;)
      bits = bits << 8 | static_cast<unsigned char>(field.bytes[at + b]);
    numbers.push_back(std::bit_cast<double>(bits));
  }
  return true;
}

bool ReadCameraInfo(const std::string& message, VismaDataset& dataset) {
  return ReadFields(message, [&](const WireField& field) {
    const auto size = static_cast<int>(std::min<std::uint64_t>(field.value, 65536));
    if (field.number == 1) dataset.rows = size;
    if (field.number == 2) dataset.cols = size;
    return field.number != 3 || AppendDoubles(field, dataset.parameters);
  });
}

bool ReadPacket(const std::string& message, VismaDataset& dataset) {
  VismaDataset::Packet packet;
  std::vector<double> pose, rotation;
  const bool whole = ReadFields(message, [&](const WireField& field) {
    if (field.number == 1 && field.type == 1) packet.stamp = std::bit_cast<double>(field.value);
    if (field.number == 2) return AppendDoubles(field, pose);
    if (field.number == 4) return AppendDoubles(field, rotation);
    return true;
  });
  if (!whole) return false;
  packet.world_from_cam = pose.size() == 12 ? RigidFromRows(pose) : std::nullopt;
  if (rotation.size() == 2 && std::hypot(rotation[0], rotation[1]) < 4)
    packet.gravity_rotation = Eigen::Vector2d(rotation[0], rotation[1]);
  dataset.packets.push_back(std::move(packet));
  return true;
}

/// A number of four bytes, or the first of a packed field.
std::optional<float> FloatOf(const WireField& field) {
  if (field.type == 5) return std::bit_cast<float>(static_cast<std::uint32_t>(field.value));
  if (field.type != 2 || field.bytes.size() < 4) return std::nullopt;
  std::uint32_t bits = 0;
  for (std::size_t b = 4; b-- > 0;) bits = bits << 8 | static_cast<unsigned char>(field.bytes[b]);
  return std::bit_cast<float>(bits);
}

bool ReadVismaBox(const std::string& message, std::vector<Detection>& boxes) {
  Detection detection;
  bool scored = false;
  const bool whole = ReadFields(message, [&](const WireField& field) {
    const std::optional<float> number = FloatOf(field);
    if (field.number >= 1 && field.number <= 5 && !number) return false;
    if (field.number == 1) detection.box.x0 = *number;
    if (field.number == 2) detection.box.y0 = *number;
    if (field.number == 3) detection.box.x1 = *number;
    if (field.number == 4) detection.box.y1 = *number;
    // Of several scores the first is the best one's.
    if (field.number == 5 && !std::exchange(scored, true)) detection.score = *number;
    if (field.number == 6 && field.type == 2) detection.category = field.bytes;
    return true;
  });
  if (!whole) return false;
  const Box2& b = detection.box;
  const bool usable = std::isfinite(b.x0) && std::isfinite(b.y0) && std::isfinite(b.x1) &&
                      std::isfinite(b.y1) && b.x0 < b.x1 && b.y0 < b.y1 && std::abs(b.x0) < 1e6f &&
                      std::abs(b.y0) < 1e6f && b.x1 < 1e6f && b.y1 < 1e6f && detection.score >= 0 &&
                      detection.score <= 1;
  if (usable) boxes.push_back(std::move(detection));
  return true;
}

Error NoMessage(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kCorrupt,
          "'" + file.string() + "' is truncated or is no " + what + " of VISMA"};
}

}  // namespace

Result<VismaDataset> ReadVismaDataset(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  if (bytes->size() > INT32_MAX) return NoMessage(file, "data set");
  VismaDataset dataset;
  bool has_camera = false;
  const bool whole = ReadFields(*bytes, [&](const WireField& field) {
    if (field.number == 2 && field.type == 2) {
      has_camera = true;
      return ReadCameraInfo(field.bytes, dataset);
    }
    return field.number != 3 || field.type != 2 || ReadPacket(field.bytes, dataset);
  });
  if (!whole || !has_camera) return NoMessage(file, "data set");
  return dataset;
}

Result<std::vector<Detection>> ReadVismaBoxes(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  if (bytes->size() > INT32_MAX) return NoMessage(file, "list of boxes");
  std::vector<Detection> boxes;
  if (!ReadFields(*bytes, [&](const WireField& field) {
        return field.number != 2 || field.type != 2 || ReadVismaBox(field.bytes, boxes);
      }))
    return NoMessage(file, "list of boxes");
  return boxes;
}

}  // namespace plumbline
