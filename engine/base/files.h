// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// The whole file. Errors: kNotFound, kIo, naming the file.
Result<std::string> ReadFile(const std::filesystem::path& path);

/// Writes a file without a name, fsync, then gives it the name: whenever the process is killed,
/// `path` holds the old or the new content, never a part. Errors: kIo.
Status WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

/// Makes what was created, renamed or removed in the folder of `path` survive a power cut.
void SyncFolderOf(const std::filesystem::path& path);

/// Parses JSON, // comments allowed. Errors: kNotFound, kIo, kCorrupt with file, line and column.
Result<nlohmann::json> ReadJson(const std::filesystem::path& path);
Status WriteJson(const std::filesystem::path& path, const nlohmann::json& json);

/// The text of a JSON value. Bytes that are not UTF-8 (of a path, say) become replacement
/// characters.
/// @param indent  Spaces of each level; negative: all in one line.
std::string JsonText(const nlohmann::json& json, int indent = -1);

/// 64-bit content hash (XXH3) as 16 hexadecimal digits; not cryptographic.
std::string HashHex(std::string_view content);
Result<std::string> HashFile(const std::filesystem::path& path);

/// `$XDG_CACHE_HOME/plumbline` or `~/.cache/plumbline` (the temporary folder if there is no home),
/// created.
std::filesystem::path CacheDirectory();

}  // namespace plumbline
