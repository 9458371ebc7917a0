// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/record_inputs.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <mutex>

#include <opencv2/videoio.hpp>

#include "engine/dataset/sequence.h"

namespace plumbline {
namespace {

constexpr const char* kPlay = "play:";
constexpr int kPollMs = 50;
constexpr std::size_t kLongestLine = 1000;

void WaitUntilNs(std::int64_t time_ns, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_until(lock, stop,
                   std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time_ns)),
                   [] { return false; });
}

/// Of play:SEQUENCE.
Result<std::shared_ptr<const Sequence>> PlayedSequence(const std::string& spec) {
  auto sequence = OpenSequence(spec.substr(std::strlen(kPlay)));
  if (!sequence.ok() || (*sequence)->num_frames() > 0) return sequence;
  return Error{ErrorCode::kInvalidInput, "'" + spec + "' has no frames"};
}

std::optional<int> DeviceNumber(const std::string& spec) {
  constexpr std::string_view kDevice = "/dev/video";
  std::string_view text = spec;
  if (text.starts_with(kDevice)) text.remove_prefix(kDevice.size());
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

cv::VideoCapture OpenDevice(int number, const Camera& camera) {
  cv::VideoCapture video(number, cv::CAP_V4L2);
  video.set(cv::CAP_PROP_FRAME_WIDTH, camera.pinhole.width);
  video.set(cv::CAP_PROP_FRAME_HEIGHT, camera.pinhole.height);
  video.set(cv::CAP_PROP_FPS, camera.rate_hz);
  return video;
}

/// The driver's stamp where it is one of this clock.
std::int64_t StampOfDevice(const cv::VideoCapture& video) {
  const std::int64_t now_ns = SteadyNs();
  const double driver_ns = 1e6 * video.get(cv::CAP_PROP_POS_MSEC);
  const double age_ns = static_cast<double>(now_ns) - driver_ns;
  return age_ns >= 0 && age_ns < 1e9 ? static_cast<std::int64_t>(driver_ns) : now_ns;
}

using TakeImage = std::function<Status(const cv::Mat&, std::int64_t)>;

Status PlayImages(const std::string& spec, const RecordWork& work, const TakeImage& image) {
  const auto sequence = PlayedSequence(spec);
  if (!sequence.ok()) return sequence.error();
  for (int i = 0; i < (*sequence)->num_frames(); ++i) {
    const std::int64_t at_ns = work.began_ns + (*sequence)->stamp_ns(i) - (*sequence)->stamp_ns(0);
    WaitUntilNs(at_ns, work.stop);
    if (work.stop.stop_requested()) return {};
    const Result<cv::Mat> picture = (*sequence)->ReadRawImage(i);
    if (!picture.ok()) {
      work.tell(picture.error().message);
      continue;
    }
    if (Status status = image(*picture, at_ns); !status.ok()) return status;
  }
  return {};
}

Status ReadDevice(int number, const Camera& camera, const RecordWork& work,
                  const TakeImage& image) {
  const std::string name = "/dev/video" + std::to_string(number);
  cv::VideoCapture video = OpenDevice(number, camera);
  if (!video.isOpened()) {
    return Error{ErrorCode::kNotFound,
                 "there is no camera '" + name + "', or another program has it"};
  }
  cv::Mat picture;
  while (!work.stop.stop_requested()) {
    if (video.read(picture) && !picture.empty()) {
      if (Status status = image(picture, StampOfDevice(video)); !status.ok()) return status;
      continue;
    }
    work.tell("the camera '" + name + "' gives no images any more; trying again until it does");
    while (!work.stop.stop_requested() && !video.isOpened()) {
      WaitUntilNs(SteadyNs() + 1'000'000'000, work.stop);
      video = OpenDevice(number, camera);
    }
    if (!video.grab()) video.release();
  }
  return {};
}

/// A video file comes by its own time, a stream when it comes.
Status ReadVideo(const std::string& spec, const RecordWork& work, const TakeImage& image) {
  cv::VideoCapture video(spec);
  if (!video.isOpened()) {
    return Error{ErrorCode::kNotFound,
                 "'" + spec + "' is no camera, video or stream that can be opened"};
  }
  const bool paced = spec.find("://") == std::string::npos;
  cv::Mat picture;
  while (!work.stop.stop_requested() && video.read(picture)) {
    std::int64_t stamp_ns = SteadyNs();
    if (paced) {
      stamp_ns = work.began_ns + std::llround(1e6 * video.get(cv::CAP_PROP_POS_MSEC));
      WaitUntilNs(stamp_ns, work.stop);
    }
    if (Status status = image(picture, stamp_ns); !status.ok()) return status;
  }
  return {};
}

using TakeLine = std::function<Status(const std::optional<ImuLine>&, std::int64_t)>;

Status PlayReadings(const std::string& spec, const RecordWork& work, const TakeLine& line) {
  const auto sequence = PlayedSequence(spec);
  if (!sequence.ok()) return sequence.error();
  const Result<ImuRecording> imu = (*sequence)->ReadImu();
  if (!imu.ok()) return imu.error();
  if (imu->samples.empty())
    return Error{ErrorCode::kInvalidInput, "'" + spec + "' has no readings of an IMU"};
  for (const ImuSample& sample : imu->samples) {
    const std::int64_t at_ns = work.began_ns + sample.stamp_ns - (*sequence)->stamp_ns(0);
    if (at_ns > SteadyNs() + 1'000'000) WaitUntilNs(at_ns, work.stop);
    if (work.stop.stop_requested()) return {};
    const ImuLine reading{at_ns, sample.angular_velocity_rad_s, sample.specific_force_m_s2};
    if (Status status = line(reading, at_ns); !status.ok()) return status;
  }
  return {};
}

/// Closes its file unless it is standard input.
struct OpenInput {
  int descriptor = -1;
  ~OpenInput() {
    if (descriptor > STDIN_FILENO) ::close(descriptor);
  }
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

Status OpenSerial(std::string_view device, OpenInput& input) {
  const std::size_t at = device.rfind('@');
  const std::string file(device.substr(0, at));
  const auto baud = BaudOf(at == std::string_view::npos ? "" : device.substr(at + 1));
  if (!baud) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + std::string(device) +
                     "' names no baud rate of 9600, 57600, 115200, 230400, 460800, 921600"};
  }
  input.descriptor = ::open(file.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios settings{};
  if (input.descriptor < 0 || ::tcgetattr(input.descriptor, &settings) != 0) {
    return Error{ErrorCode::kNotFound,
                 "'" + file + "' is no serial port that can be opened: " + std::strerror(errno)};
  }
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, *baud);
  settings.c_cflag |= CLOCAL | CREAD;
  ::tcsetattr(input.descriptor, TCSANOW, &settings);
  return {};
}

Status OpenUdp(std::string_view port, OpenInput& input) {
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number < 1 || number > 65535) {
    return Error{ErrorCode::kInvalidInput,
                 "'udp:" + std::string(port) + "' names no port of 1 to 65535"};
  }
  input.descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(number));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (input.descriptor < 0 ||
      ::bind(input.descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    return Error{ErrorCode::kIo, "cannot listen on port " + std::to_string(number) +
                                     " of this machine: " + std::strerror(errno)};
  }
  return {};
}

Status ReadLines(int descriptor, bool datagrams, const RecordWork& work, const TakeLine& line) {
  std::string rest;
  char bytes[4096];
  while (!work.stop.stop_requested()) {
    pollfd ready{descriptor, POLLIN, 0};
    if (::poll(&ready, 1, kPollMs) <= 0) continue;
    const ssize_t size = ::read(descriptor, bytes, sizeof(bytes));
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size == 0 && datagrams) continue;
    if (size <= 0) {
      work.tell("the IMU is gone: no readings come any more");
      return {};
    }
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

std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

bool IsPlayed(const std::string& spec) { return spec.starts_with(kPlay); }

Status ReadCamera(const std::string& spec, const Camera& camera, const RecordWork& work,
                  const TakeImage& image) {
  if (IsPlayed(spec)) return PlayImages(spec, work, image);
  if (const auto number = DeviceNumber(spec)) return ReadDevice(*number, camera, work, image);
  return ReadVideo(spec, work, image);
}

Status ReadImuInput(const std::string& spec, const RecordWork& work, const TakeLine& line) {
  constexpr std::string_view kSerial = "serial:", kUdp = "udp:";
  if (IsPlayed(spec)) return PlayReadings(spec, work, line);
  OpenInput input;
  Status status;
  if (spec == "-") {
    input.descriptor = STDIN_FILENO;
  } else if (spec.starts_with(kSerial)) {
    status = OpenSerial(std::string_view(spec).substr(kSerial.size()), input);
  } else if (spec.starts_with(kUdp)) {
    status = OpenUdp(std::string_view(spec).substr(kUdp.size()), input);
  } else {
    return Error{ErrorCode::kInvalidInput, "'" + spec +
                                               "' is no IMU: write serial:DEVICE[@BAUD], udp:PORT, "
                                               "play:SEQUENCE or - for standard input"};
  }
  if (!status.ok()) return status;
  return ReadLines(input.descriptor, spec.starts_with(kUdp), work, line);
}

}  // namespace plumbline
