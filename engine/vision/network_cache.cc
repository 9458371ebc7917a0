// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_cache.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"

namespace plumbline {
namespace {

constexpr std::size_t kHashDigits = 16;
constexpr std::uintmax_t kDefaultLimitMb = 4096;
constexpr double kKeepAfterMakingRoom = 0.8, kCheckEvery = 0.05;  // shares of the limit

std::uintmax_t LimitFromEnvironment() {
  const char* text = std::getenv("PLUMBLINE_NETWORK_CACHE_MB");
  if (text == nullptr || *text == '\0') return kDefaultLimitMb << 20;
  return static_cast<std::uintmax_t>(std::strtoull(text, nullptr, 10)) << 20;
}

void AppendSize(std::size_t size, std::string& out) {
  const auto value = static_cast<std::uint64_t>(size);
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// Takes a size and as many bytes from the front.
std::optional<std::string_view> TakePart(std::string_view& rest) {
  std::uint64_t size = 0;
  if (rest.size() < sizeof(size)) return std::nullopt;
  std::memcpy(&size, rest.data(), sizeof(size));
  rest.remove_prefix(sizeof(size));
  if (rest.size() < size) return std::nullopt;
  const std::string_view part = rest.substr(0, size);
  rest.remove_prefix(size);
  return part;
}

}  // namespace

NetworkCache::NetworkCache(std::filesystem::path folder, std::uintmax_t limit_bytes)
    : folder_(std::move(folder)), limit_bytes_(limit_bytes) {}

NetworkCache& NetworkCache::Shared() {
  // One for each thread: nothing but the folder is shared, and that by whole files.
  static thread_local NetworkCache cache(CacheDirectory() / "networks", LimitFromEnvironment());
  return cache;
}

std::filesystem::path NetworkCache::FileOf(const std::string& key) const {
  return folder_ / key.substr(0, 2) / key;
}

std::optional<std::string> NetworkCache::Get(const std::string& key) {
  if (limit_bytes_ == 0) return std::nullopt;
  const std::filesystem::path file = FileOf(key);
  Result<std::string> content = ReadFile(file);
  if (!content.ok() || content->size() < kHashDigits) return std::nullopt;
  const std::string_view body = std::string_view(*content).substr(kHashDigits);
  if (HashHex(body) != std::string_view(*content).substr(0, kHashDigits)) return std::nullopt;
  std::error_code ignored;
  std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now(), ignored);
  return std::string(body);
}

void NetworkCache::Put(const std::string& key, std::string_view content) {
  if (limit_bytes_ == 0) return;
  std::error_code error;
  const std::filesystem::path file = FileOf(key);
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) return;
  const Status written = WriteFileAtomically(file, HashHex(content) + std::string(content));
  if (!written.ok()) return;
  written_bytes_ += content.size() + kHashDigits;
  if (!checked_ ||
      written_bytes_ > static_cast<std::uintmax_t>(kCheckEvery * static_cast<double>(limit_bytes_)))
    MakeRoom();
}

void NetworkCache::MakeRoom() {
  struct Entry {
    std::filesystem::file_time_type used;
    std::uintmax_t bytes = 0;
    std::filesystem::path file;
  };
  checked_ = true;
  written_bytes_ = 0;
  std::vector<Entry> entries;
  std::uintmax_t total = 0;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator it(folder_, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code gone;  // another process may make room, too
    if (!it->is_regular_file(gone) || gone) continue;
    const Entry entry{it->last_write_time(gone), it->file_size(gone), it->path()};
    if (gone) continue;
    total += entry.bytes;
    entries.push_back(entry);
  }
  if (total <= limit_bytes_) return;
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (static_cast<double>(total) <= kKeepAfterMakingRoom * static_cast<double>(limit_bytes_))
      break;
    std::filesystem::remove(entry.file, error);
    total -= entry.bytes;
  }
}

std::string NetworkCacheKey(std::string_view what, const cv::Mat& image) {
  std::string bytes(what);
  for (const int number : {image.rows, image.cols, image.type()})
    AppendSize(static_cast<std::size_t>(number), bytes);
  const std::size_t row_bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int y = 0; y < image.rows; ++y)
    bytes.append(reinterpret_cast<const char*>(image.ptr(y)), row_bytes);
  // Two hashes of 64 bits: no two of a billion images meet.
  return HashHex(bytes) + HashHex(bytes + "second");
}

std::string EncodeEdges(const EdgeMap& edges) {
  std::string out;
  for (const cv::Mat* map : {&edges.probability, &edges.angle}) {
    std::vector<std::uint8_t> png;
    cv::imencode(".png", *map, png, {cv::IMWRITE_PNG_COMPRESSION, 1});
    AppendSize(png.size(), out);
    out.append(png.begin(), png.end());
  }
  return out;
}

std::optional<EdgeMap> DecodeEdges(std::string_view content) {
  EdgeMap edges;
  for (cv::Mat* map : {&edges.probability, &edges.angle}) {
    const auto png = TakePart(content);
    // As EncodeEdges writes it: OpenCV would try every format that it knows.
    if (!png || !png->starts_with("\x89PNG\r\n")) return std::nullopt;
    const std::vector<std::uint8_t> bytes(png->begin(), png->end());
    try {
      *map = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {  // no bytes, or a size beyond reason
      return std::nullopt;
    }
    if (map->type() != CV_8UC1 || map->empty()) return std::nullopt;
  }
  if (edges.probability.size() != edges.angle.size()) return std::nullopt;
  return edges;
}

std::string EncodeTensors(const std::vector<cv::Mat>& tensors) {
  std::string out;
  for (const cv::Mat& tensor : tensors) {
    AppendSize(static_cast<std::size_t>(tensor.dims), out);
    for (int i = 0; i < tensor.dims; ++i) AppendSize(static_cast<std::size_t>(tensor.size[i]), out);
    const cv::Mat whole = tensor.isContinuous() ? tensor : tensor.clone();
    out.append(reinterpret_cast<const char*>(whole.data), whole.total() * whole.elemSize());
  }
  return out;
}

std::optional<std::vector<cv::Mat>> DecodeTensors(std::string_view content) {
  const auto number = [&]() -> std::optional<std::uint64_t> {
    std::uint64_t value = 0;
    if (content.size() < sizeof(value)) return std::nullopt;
    std::memcpy(&value, content.data(), sizeof(value));
    content.remove_prefix(sizeof(value));
    return value;
  };
  std::vector<cv::Mat> tensors;
  do {
    const auto dims = number();
    if (!dims || *dims < 1 || *dims > 8) return std::nullopt;
    std::vector<int> size;
    std::uint64_t bytes = sizeof(float);
    for (std::uint64_t i = 0; i < *dims; ++i) {
      const auto length = number();
      if (!length || *length < 1 || *length > (1u << 20)) return std::nullopt;
      size.push_back(static_cast<int>(*length));
      bytes *= *length;
      if (bytes > content.size()) return std::nullopt;
    }
    cv::Mat tensor(size, CV_32FC1);
    std::memcpy(tensor.data, content.data(), bytes);
    content.remove_prefix(bytes);
    tensors.push_back(std::move(tensor));
  } while (!content.empty());
  return tensors;
}

}  // namespace plumbline
