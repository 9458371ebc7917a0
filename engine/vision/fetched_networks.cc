// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/fetched_networks.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include <curl/curl.h>
#include <openssl/evp.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/vision/vision_resources.h"

namespace plumbline {
namespace {

constexpr long kConnectTimeout_s = 20;
constexpr long kSlowest_bytes_per_s = 100, kSlowFor_s = 60;  // then the connection is given up

bool IsThisMachine(const std::string& url) {
  return url.starts_with("http://127.0.0.1:") || url.starts_with("http://localhost:");
}

/// A file that is being downloaded, and what its progress is told to.
struct Download {
  std::ofstream file;
  std::uintmax_t had = 0;       ///< Bytes from earlier tries.
  std::uintmax_t expected = 0;  ///< Bytes in all.
  std::uintmax_t taken = 0;
  const WorkContext* work = nullptr;
  bool too_long = false;
};

std::size_t OnData(char* data, std::size_t size, std::size_t count, void* user) {
  auto& download = *static_cast<Download*>(user);
  const std::size_t bytes = size * count;
  if (download.had + download.taken + bytes > download.expected) {
    download.too_long = true;
    return 0;
  }
  download.file.write(data, static_cast<std::streamsize>(bytes));
  if (!download.file) return 0;
  download.taken += bytes;
  return bytes;
}

int OnProgress(void* user, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  const auto& download = *static_cast<const Download*>(user);
  constexpr std::uintmax_t kKilo = 1024;
  download.work->report({"downloading (kB)",
                         static_cast<int>((download.had + download.taken) / kKilo),
                         static_cast<int>(download.expected / kKilo)});
  return download.work->stop.stop_requested() ? 1 : 0;
}

/// Appends to `part` what is missing. True if the server would not go on in the middle, so that
/// `part` must be begun anew.
Result<bool> Continue(const ListedNetwork& network, const std::filesystem::path& part,
                      const WorkContext& work) {
  std::error_code none;
  Download download;
  download.had = std::filesystem::exists(part, none) ? std::filesystem::file_size(part, none) : 0;
  download.expected = network.bytes;
  download.work = &work;
  download.file.open(part, std::ios::binary | std::ios::app);
  if (!download.file) return Error{ErrorCode::kIo, "cannot write '" + part.string() + "'"};
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(),
                                                                 curl_easy_cleanup);
  PLB_CHECK(curl != nullptr);
  std::array<char, CURL_ERROR_SIZE> reason{};
  curl_easy_setopt(curl.get(), CURLOPT_URL, network.url.c_str());
#if LIBCURL_VERSION_NUM >= 0x075500
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR,
                   IsThisMachine(network.url) ? "http,https" : "https");
  curl_easy_setopt(curl.get(), CURLOPT_REDIR_PROTOCOLS_STR, "https");
#else
  const long protocols =
      IsThisMachine(network.url) ? CURLPROTO_HTTP | CURLPROTO_HTTPS : CURLPROTO_HTTPS;
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS, protocols);
  curl_easy_setopt(curl.get(), CURLOPT_REDIR_PROTOCOLS, static_cast<long>(CURLPROTO_HTTPS));
#endif
  curl_easy_setopt(curl.get(), CURLOPT_FOLLOWLOCATION, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_FAILONERROR, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_CONNECTTIMEOUT, kConnectTimeout_s);
  curl_easy_setopt(curl.get(), CURLOPT_LOW_SPEED_LIMIT, kSlowest_bytes_per_s);
  curl_easy_setopt(curl.get(), CURLOPT_LOW_SPEED_TIME, kSlowFor_s);
  curl_easy_setopt(curl.get(), CURLOPT_RESUME_FROM_LARGE, static_cast<curl_off_t>(download.had));
  curl_easy_setopt(curl.get(), CURLOPT_ERRORBUFFER, reason.data());
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, OnData);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEDATA, &download);
  curl_easy_setopt(curl.get(), CURLOPT_NOPROGRESS, 0L);
  curl_easy_setopt(curl.get(), CURLOPT_XFERINFOFUNCTION, OnProgress);
  curl_easy_setopt(curl.get(), CURLOPT_XFERINFODATA, &download);
  const CURLcode code = curl_easy_perform(curl.get());
  long status = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  download.file.close();
  if (code == CURLE_OK) return false;
  constexpr long kRangeNotSatisfiable = 416;
  if (download.had > 0 && (code == CURLE_RANGE_ERROR || status == kRangeNotSatisfiable))
    return true;
  if (work.stop.stop_requested()) {
    return Error{ErrorCode::kCancelled,
                 "stopped; 'plumbline networks get " + network.name + "' goes on from there"};
  }
  if (download.too_long) {
    std::filesystem::remove(part, none);
    return Error{ErrorCode::kCorrupt, "'" + network.url +
                                          "' is longer than the listed file; it was deleted and "
                                          "will not be used"};
  }
  const std::string why = reason[0] != '\0' ? reason.data() : curl_easy_strerror(code);
  if (code == CURLE_HTTP_RETURNED_ERROR) {
    return Error{ErrorCode::kNotFound, "'" + network.url + "' cannot be fetched (" + why +
                                           "); it may have moved: download it by hand and name it "
                                           "with --detector FILE.onnx"};
  }
  return Error{ErrorCode::kIo, "cannot reach '" + network.url + "' (" + why +
                                   "); what has arrived is kept: connect this machine and try "
                                   "again"};
}

}  // namespace

const std::vector<ListedNetwork>& ListedNetworks() {
  static const std::vector<ListedNetwork> networks = [] {
    std::vector<ListedNetwork> list;
    const auto json = nlohmann::json::parse(VisionResource("assets/networks/list.json"));
    for (const auto& entry : json.at("networks")) {
      list.push_back({entry.at("name"), entry.at("about"), entry.at("url"), entry.at("sha256"),
                      entry.at("bytes"), entry.at("licence"), entry.at("sidecar").dump(1)});
    }
    return list;
  }();
  return networks;
}

std::filesystem::path NetworksFolder() {
  std::filesystem::path base = std::filesystem::temp_directory_path();
  if (const char* data = std::getenv("XDG_DATA_HOME"); data != nullptr && *data != '\0') {
    base = data;
  } else if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    base = std::filesystem::path(home) / ".local/share";
  }
  return base / "plumbline/networks";
}

std::optional<std::filesystem::path> FetchedNetwork(std::string_view name) {
  for (const ListedNetwork& network : ListedNetworks()) {
    if (network.name != name) continue;
    const std::filesystem::path file = NetworksFolder() / (network.name + ".onnx");
    std::error_code none;
    if (std::filesystem::exists(file, none)) return file;
  }
  return std::nullopt;
}

std::optional<std::filesystem::path> BestFetchedDetector() {
  for (const ListedNetwork& network : ListedNetworks())
    if (auto file = FetchedNetwork(network.name)) return file;
  return std::nullopt;
}

Result<std::string> ResolveNetworkName(const std::string& choice) {
  if (const auto file = FetchedNetwork(choice)) return file->string();
  for (const ListedNetwork& network : ListedNetworks()) {
    if (network.name == choice) {
      return Error{ErrorCode::kNotFound, "the network '" + choice +
                                             "' is not on this machine; fetch it with 'plumbline "
                                             "networks get " +
                                             choice + "'"};
    }
  }
  return choice;
}

Result<std::string> Sha256OfFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot read '" + path.string() + "'"};
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        EVP_MD_CTX_free);
  PLB_CHECK(context != nullptr && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1);
  std::vector<char> block(1 << 16);
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    EVP_DigestUpdate(context.get(), block.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof()) return Error{ErrorCode::kIo, "cannot read '" + path.string() + "' to its end"};
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &length);
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) {
    std::array<char, 3> two{};
    std::snprintf(two.data(), two.size(), "%02x", digest[i]);
    hex += two.data();
  }
  return hex;
}

Result<std::filesystem::path> FetchNetwork(const ListedNetwork& network,
                                           const std::filesystem::path& folder,
                                           const WorkContext& work) {
  const std::filesystem::path file = folder / (network.name + ".onnx");
  const std::filesystem::path part = folder / (network.name + ".onnx.part");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  }
  const auto is_listed = [&](const std::filesystem::path& candidate) {
    const Result<std::string> hash = Sha256OfFile(candidate);
    return hash.ok() && *hash == network.sha256;
  };
  if (!is_listed(file)) {
    if (std::filesystem::exists(part, error) &&
        std::filesystem::file_size(part, error) >= network.bytes && !is_listed(part))
      std::filesystem::remove(part, error);
    if (!is_listed(part)) {
      Result<bool> again = Continue(network, part, work);
      if (again.ok() && *again) {
        std::filesystem::remove(part, error);
        again = Continue(network, part, work);
      }
      if (!again.ok()) return again.error();
    }
    if (!is_listed(part)) {
      std::filesystem::remove(part, error);
      return Error{ErrorCode::kCorrupt, "what '" + network.url +
                                            "' gave is not the listed file (its SHA-256 differs); "
                                            "it was deleted and will not be used"};
    }
  }
  // The sidecar first: a network without one cannot be used, a sidecar alone does no harm.
  Status written = WriteFileAtomically(folder / (network.name + ".json"), network.sidecar);
  if (!written.ok()) return written.error();
  if (std::filesystem::exists(part, error) && is_listed(part)) {
    std::filesystem::rename(part, file, error);
    if (error) return Error{ErrorCode::kIo, "cannot name '" + file.string() + "'"};
    SyncFolderOf(file);
  }
  return file;
}

}  // namespace plumbline
