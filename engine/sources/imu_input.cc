// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/imu_input.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

namespace plumbline {
namespace {

constexpr int kPollMs = 50, kConnectMs = 3000;
constexpr std::size_t kLongestLine = 1000;

using TakeLine = std::function<Status(const std::optional<ImuLine>&, std::int64_t)>;

Status PlayReadings(const std::string& spec, const SensorWork& work, const TakeLine& line) {
  const auto sequence = PlayedSequence(spec);
  if (!sequence.ok()) return sequence.error();
  const Result<ImuRecording> imu = (*sequence)->ReadImu();
  if (!imu.ok()) return imu.error();
  if (imu->samples.empty())
    return Error{ErrorCode::kInvalidInput, "'" + spec + "' has no readings of an IMU"};
  for (const ImuSample& sample : imu->samples) {
    const std::int64_t at_ns = work.began_ns + sample.stamp_ns - (*sequence)->stamp_ns(0);
    if (at_ns < work.joined_ns) continue;
    if (at_ns > SteadyNs() + 1'000'000) work.WaitUntil(at_ns);
    if (work.stop.stop_requested()) return {};
    const ImuLine reading{at_ns, sample.angular_velocity_rad_s, sample.specific_force_m_s2};
    if (Status status = line(reading, at_ns); !status.ok()) return status;
  }
  return {};
}

/// Closes its file unless it is standard input.
class OpenInput {
 public:
  explicit OpenInput(int descriptor) : descriptor_(descriptor) {}
  ~OpenInput() {
    if (descriptor_ > STDIN_FILENO) ::close(descriptor_);
  }
  OpenInput(const OpenInput&) = delete;
  OpenInput& operator=(const OpenInput&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  const int descriptor_;
};

std::optional<speed_t> BaudOf(std::string_view text) {
  if (text.empty() || text == "115200") return B115200;
  if (text == "9600") return B9600;
  if (text == "57600") return B57600;
  if (text == "230400") return B230400;
  if (text == "460800") return B460800;
  if (text == "921600") return B921600;
  return std::nullopt;
}

Result<int> OpenSerial(std::string_view device) {
  const std::size_t at = device.rfind('@');
  const std::string file(device.substr(0, at));
  const auto baud = BaudOf(at == std::string_view::npos ? "" : device.substr(at + 1));
  if (!baud) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + std::string(device) +
                     "' names no baud rate of 9600, 57600, 115200, 230400, 460800, 921600"};
  }
  const int port = ::open(file.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios settings{};
  if (port < 0 || ::tcgetattr(port, &settings) != 0) {
    const Error error{
        ErrorCode::kNotFound,
        "'" + file + "' is no serial port that can be opened: " + std::strerror(errno)};
    if (port >= 0) ::close(port);
    return error;
  }
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, *baud);
  settings.c_cflag |= CLOCAL | CREAD;
  ::tcsetattr(port, TCSANOW, &settings);
  return port;
}

std::optional<int> PortOf(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 1 || number > 65535)
    return std::nullopt;
  return number;
}

Result<int> OpenUdp(std::string_view text) {
  const std::optional<int> port = PortOf(text);
  if (!port) {
    return Error{ErrorCode::kInvalidInput,
                 "'udp:" + std::string(text) + "' names no port of 1 to 65535"};
  }
  const int receiver = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(*port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (receiver < 0 ||
      ::bind(receiver, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    const Error error{ErrorCode::kIo, "cannot listen on port " + std::to_string(*port) +
                                          " of this machine: " + std::strerror(errno)};
    if (receiver >= 0) ::close(receiver);
    return error;
  }
  return receiver;
}

/// 0, or what errno says of it.
int Connect(int stream, const addrinfo& address) {
  if (::connect(stream, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd ready{stream, POLLOUT, 0};
  if (::poll(&ready, 1, kConnectMs) <= 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof(error);
  ::getsockopt(stream, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

/// Connects to whoever listens at HOST:PORT, a phone as a rule.
Result<int> OpenTcp(std::string_view where) {
  const std::size_t colon = where.rfind(':');
  const std::optional<int> port =
      colon == std::string_view::npos ? std::nullopt : PortOf(where.substr(colon + 1));
  if (!port || colon == 0) {
    return Error{ErrorCode::kInvalidInput, "'tcp:" + std::string(where) + "' is not tcp:HOST:PORT"};
  }
  const std::string host(where.substr(0, colon));
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failed = ::getaddrinfo(host.c_str(), std::to_string(*port).c_str(), &hints, &found);
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  std::string why = failed != 0 ? ::gai_strerror(failed) : "it has no address";
  for (const addrinfo* one = failed == 0 ? found : nullptr; one != nullptr; one = one->ai_next) {
    const int stream = ::socket(one->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int error = stream < 0 ? errno : Connect(stream, *one);
    if (error == 0) return stream;
    why = std::strerror(error);
    if (stream >= 0) ::close(stream);
  }
  return Error{ErrorCode::kNotFound,
               "nobody listens at 'tcp:" + std::string(where) + "' that can be reached: " + why};
}

Result<int> OpenImu(const std::string& spec) {
  constexpr std::string_view kSerial = "serial:", kUdp = "udp:", kTcp = "tcp:";
  const std::string_view text = spec;
  if (text == "-") return STDIN_FILENO;
  if (text.starts_with(kSerial)) return OpenSerial(text.substr(kSerial.size()));
  if (text.starts_with(kUdp)) return OpenUdp(text.substr(kUdp.size()));
  if (text.starts_with(kTcp)) return OpenTcp(text.substr(kTcp.size()));
  return Error{ErrorCode::kInvalidInput,
               "'" + spec +
                   "' is no IMU: write serial:DEVICE[@BAUD], udp:PORT, "
                   "tcp:HOST:PORT, play:SEQUENCE or - for standard input"};
}

/// Until nothing comes any more.
Status ReadLines(int descriptor, bool datagrams, const SensorWork& work, const TakeLine& line) {
  std::string rest;
  char bytes[4096];
  while (!work.stop.stop_requested()) {
    pollfd ready{descriptor, POLLIN, 0};
    if (::poll(&ready, 1, kPollMs) <= 0) continue;
    const ssize_t size = ::read(descriptor, bytes, sizeof(bytes));
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size == 0 && datagrams) continue;
    if (size <= 0) return {};
    const std::int64_t arrived_ns = SteadyNs();
    rest.append(bytes, static_cast<std::size_t>(size));
    if (datagrams && !rest.ends_with('\n')) rest += '\n';
    for (std::size_t end = rest.find('\n'); end != std::string::npos; end = rest.find('\n')) {
      const std::string_view text(rest.data(), end);
      if (!text.empty() && text != "\r") {
        if (Status status = line(ParseImuLine(text), arrived_ns); !status.ok()) return status;
      }
      rest.erase(0, end + 1);
    }
    if (rest.size() > kLongestLine) rest.clear();
  }
  return {};
}

}  // namespace

Status ReadImuInput(const std::string& spec, const SensorWork& work, const TakeLine& line) {
  if (IsPlayed(spec)) return PlayReadings(spec, work, line);
  const bool comes_back = spec.starts_with("serial:") || spec.starts_with("tcp:");
  for (bool patient = work.patient, was_there = true; !work.stop.stop_requested(); patient = true) {
    Result<int> opened = OpenImu(spec);
    if (opened.ok()) {
      const OpenInput input(*opened);
      was_there = true;
      Status status = ReadLines(input.descriptor(), spec.starts_with("udp:"), work, line);
      if (!status.ok() || work.stop.stop_requested()) return status;
    } else if (!patient || !comes_back || opened.error().code == ErrorCode::kInvalidInput) {
      return opened.error();
    }
    if (std::exchange(was_there, false))
      work.tell(comes_back ? "the IMU is gone; trying again until it is back"
                           : "the IMU is gone: no readings come any more");
    if (!comes_back) return {};
    work.WaitToTryAgain();
  }
  return {};
}

}  // namespace plumbline
