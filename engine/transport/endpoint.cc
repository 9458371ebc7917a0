// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/endpoint.h"

#include <sys/un.h>

#include <algorithm>
#include <cctype>
#include <charconv>

namespace plumbline {
namespace {

/// sun_path holds it and the zero behind it.
constexpr std::size_t kLongestIpcFile = sizeof(sockaddr_un{}.sun_path) - 1;

Error WrongEndpoint(std::string_view text, const std::string& why) {
  return {ErrorCode::kInvalidInput, "'" + std::string(text) + "' " + why +
                                        "; write ipc://FILE, or tcp://HOST:PORT, as in "
                                        "tcp://127.0.0.1:7000"};
}

/// 127.x.y.z in full: 127.evil.example is a name.
bool IsLoopback(std::string_view host) {
  if (host == "localhost" || host == "[::1]") return true;
  const auto dots = std::count(host.begin(), host.end(), '.');
  const bool numeric = std::all_of(
      host.begin(), host.end(), [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; });
  return numeric && dots == 3 && host.substr(0, 4) == "127.";
}

}  // namespace

Result<Endpoint> Endpoint::Parse(std::string_view text) {
  constexpr std::string_view kIpc = "ipc://", kTcp = "tcp://";
  const bool printable =
      std::all_of(text.begin(), text.end(), [](unsigned char c) { return c >= ' ' && c != 0x7f; });
  if (!printable) return WrongEndpoint(text, "has characters that no address has");
  if (text.substr(0, kIpc.size()) == kIpc) {
    const std::string_view file = text.substr(kIpc.size());
    if (file.empty() || file[0] == '@' || file[0] == '*')
      return WrongEndpoint(text, "names no file");  // abstract sockets have no owner
    if (file.size() > kLongestIpcFile)
      return WrongEndpoint(text, "is longer than the " + std::to_string(kLongestIpcFile) +
                                     " bytes that the name of a socket may have");
    return Endpoint(std::string(text), true);
  }
  if (text.substr(0, kTcp.size()) != kTcp) return WrongEndpoint(text, "is no address of a node");
  const std::string_view place = text.substr(kTcp.size());
  const std::size_t colon = place.rfind(':');
  if (colon == std::string_view::npos || colon == 0)
    return WrongEndpoint(text, "has no host and port");
  const std::string_view host = place.substr(0, colon), digits = place.substr(colon + 1);
  unsigned port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || end != digits.data() + digits.size() || port == 0 || port > 65535)
    return WrongEndpoint(text, "has no port from 1 to 65535");
  if (host.find_first_of("/;@ ") != std::string_view::npos)
    return WrongEndpoint(text, "has no host");
  return Endpoint(std::string(text), IsLoopback(host));
}

}  // namespace plumbline
