// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include <Eigen/Core>

namespace plumbline {

/// As printf formats it.
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);
/// "1 frame", "3 frames".
std::string Counted(std::size_t count, const std::string& one, const std::string& many);
/// "1.2 x 0.8 x 0.75 m".
std::string SizeText(const Eigen::Vector3d& size_m);
/// "812 kB", "1.2 GB".
std::string BytesText(std::uintmax_t bytes);
/// Of a file, or of all files under a folder.
std::uintmax_t BytesOnDisk(const std::filesystem::path& path);
/// Whether the file name ends so, in any case; ".ply".
bool HasEnding(const std::filesystem::path& file, const char* ending);

}  // namespace plumbline
