// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/progress.h"
#include "engine/base/result.h"

namespace plumbline {

/// A public detector that can be fetched.
struct ListedNetwork {
  std::string name;    ///< As --detector takes it.
  std::string about;   ///< One line.
  std::string url;     ///< https; plain http only to this machine.
  std::string sha256;  ///< Of the ONNX file, 64 hexadecimal digits.
  std::uintmax_t bytes = 0;
  std::string licence;
  std::string sidecar;  ///< What is written as NAME.json.
};

/// Those of assets/networks/list.json, the best first.
const std::vector<ListedNetwork>& ListedNetworks();

/// `$XDG_DATA_HOME/plumbline/networks` or `~/.local/share/plumbline/networks`; not created.
std::filesystem::path NetworksFolder();

/// The file of a listed network that has been fetched; nothing for others.
std::optional<std::filesystem::path> FetchedNetwork(std::string_view name);
/// The first of ListedNetworks that has been fetched.
std::optional<std::filesystem::path> BestFetchedDetector();

/// What --detector is given, with the name of a listed network replaced by its file. Errors:
/// kNotFound (not fetched yet).
Result<std::string> ResolveNetworkName(const std::string& choice);

/// Downloads a network into `folder` and writes its sidecar; goes on where an earlier try was cut
/// off. The file gets its name only when its SHA-256 is the listed one; what differs is deleted.
/// Nothing is downloaded if it is there already. Errors: kNotFound (no such file there), kIo (no
/// connection, cannot write), kCorrupt (not the listed content), kCancelled.
Result<std::filesystem::path> FetchNetwork(const ListedNetwork& network,
                                           const std::filesystem::path& folder,
                                           const WorkContext& work);

/// Of a file, 64 hexadecimal digits. Errors: kNotFound, kIo.
Result<std::string> Sha256OfFile(const std::filesystem::path& file);

}  // namespace plumbline
