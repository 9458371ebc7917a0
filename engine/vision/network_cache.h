// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// What networks made of images, one file for each, by content: ten seeds, a probe or a fork of one
/// sequence run the network once. A file that is damaged or cannot be written costs only time. Any
/// number of processes may share a folder.
class NetworkCache {
 public:
  /// @param limit_bytes  When more is kept, what was not used for longest goes first.
  explicit NetworkCache(std::filesystem::path folder, std::uintmax_t limit_bytes);
  /// Beside the viewpoint models; PLUMBLINE_NETWORK_CACHE_MB sets the limit (4096), 0 keeps
  /// nothing.
  static NetworkCache& Shared();

  std::optional<std::string> Get(const std::string& key);
  void Put(const std::string& key, std::string_view content);

 private:
  std::filesystem::path FileOf(const std::string& key) const;
  void MakeRoom();

  std::filesystem::path folder_;
  std::uintmax_t limit_bytes_;
  std::uintmax_t written_bytes_ = 0;  ///< Since room was last made.
  bool checked_ = false;
};

/// @param what  Names the computation: the content hash of the network, and what else decides.
std::string NetworkCacheKey(std::string_view what, const cv::Mat& image);

/// Lossless.
std::string EncodeEdges(const EdgeMap& edges);
std::optional<EdgeMap> DecodeEdges(std::string_view content);
std::string EncodeTensors(const std::vector<cv::Mat>& tensors);
std::optional<std::vector<cv::Mat>> DecodeTensors(std::string_view content);

}  // namespace plumbline
