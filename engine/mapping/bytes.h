// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include <Eigen/Geometry>

namespace plumbline {

/// Appends plain values to a byte string, for state that only this program version reads back.
class ByteWriter {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void Put(const Eigen::Isometry3d& pose) {
    for (int i = 0; i < 12; ++i) Put(pose.matrix()(i / 4, i % 4));
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads back what ByteWriter wrote. Past the end everything reads as zero and `ok` turns false; it
/// does, too, where a truth value is neither 0 nor 1.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  T Get() {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      const auto byte = Get<std::uint8_t>();
      ok_ = ok_ && byte <= 1;
      return byte == 1;
    }
    T value{};
    if (bytes_.size() < sizeof(T)) {
      ok_ = false;
      return value;
    }
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }
  Eigen::Isometry3d GetPose() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) pose.matrix()(i / 4, i % 4) = Get<double>();
    return pose;
  }
  std::string_view rest() const { return bytes_; }
  bool ok() const { return ok_; }

 private:
  std::string_view bytes_;
  bool ok_ = true;
};

}  // namespace plumbline
