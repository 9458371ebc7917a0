// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/camera_input.h"

#include <charconv>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include <opencv2/videoio.hpp>

#include "engine/dataset/text_table.h"

namespace plumbline {
namespace {

std::optional<int> DeviceNumber(const std::string& spec) {
  constexpr std::string_view kDevice = "/dev/video";
  std::string_view text = spec;
  if (text.starts_with(kDevice)) text.remove_prefix(kDevice.size());
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

/// How V4L2 names who sets the exposure (V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_APERTURE_PRIORITY).
constexpr double kExposureByHand = 1, kExposureByItself = 3;
constexpr double kExposureUnit_ms = 0.1;
constexpr std::int64_t kSettles_ns = 2'000'000'000;  ///< An exposure that is set by itself.

/// A V4L2 camera. Its exposure stays as it is set, or as it has set itself after two seconds.
class Device {
 public:
  Device(int number, const Camera& camera, const std::optional<Exposure>& exposure)
      : video_(number, cv::CAP_V4L2), exposure_(exposure), opened_ns_(SteadyNs()) {
    video_.set(cv::CAP_PROP_FRAME_WIDTH, camera.pinhole.width);
    video_.set(cv::CAP_PROP_FRAME_HEIGHT, camera.pinhole.height);
    video_.set(cv::CAP_PROP_FPS, camera.rate_hz);
    if (!exposure) return;
    // Some cameras take what is set by hand only when they come from setting it themselves.
    video_.set(cv::CAP_PROP_AUTO_EXPOSURE, kExposureByItself);
    if (exposure->milliseconds > 0) Lock(exposure->milliseconds / kExposureUnit_ms);
  }
  bool is_open() const { return video_.isOpened(); }
  bool Read(cv::Mat& picture) {
    if (exposure_ && !locked_ && SteadyNs() - opened_ns_ > kSettles_ns)
      Lock(video_.get(cv::CAP_PROP_EXPOSURE));
    return video_.read(picture) && !picture.empty();
  }
  /// The driver's where it is one of this clock.
  std::int64_t StampNs() const {
    const std::int64_t now_ns = SteadyNs();
    const double driver_ns = 1e6 * video_.get(cv::CAP_PROP_POS_MSEC);
    const double age_ns = static_cast<double>(now_ns) - driver_ns;
    return age_ns >= 0 && age_ns < 1e9 ? static_cast<std::int64_t>(driver_ns) : now_ns;
  }
  /// Whether the camera does not let its exposure be set; told once.
  bool RefusedNow() { return std::exchange(refused_, false); }

 private:
  void Lock(double units) {
    locked_ = true;
    refused_ = !video_.set(cv::CAP_PROP_AUTO_EXPOSURE, kExposureByHand) ||
               !video_.set(cv::CAP_PROP_EXPOSURE, units);
  }

  cv::VideoCapture video_;
  const std::optional<Exposure> exposure_;
  const std::int64_t opened_ns_;
  bool locked_ = false, refused_ = false;
};

/// Images that come from elsewhere.
class Stream {
 public:
  explicit Stream(const std::string& address) : video_(address) {}
  bool is_open() const { return video_.isOpened(); }
  bool Read(cv::Mat& picture) { return video_.read(picture) && !picture.empty(); }
  /// When it came.
  static std::int64_t StampNs() { return SteadyNs(); }
  static bool RefusedNow() { return false; }

 private:
  cv::VideoCapture video_;
};

using TakeImage = std::function<Status(const cv::Mat&, std::int64_t)>;

Status PlayImages(const std::string& spec, const SensorWork& work, const TakeImage& image) {
  const auto sequence = PlayedSequence(spec);
  if (!sequence.ok()) return sequence.error();
  for (int i = 0; i < (*sequence)->num_frames(); ++i) {
    const std::int64_t at_ns = work.began_ns + (*sequence)->stamp_ns(i) - (*sequence)->stamp_ns(0);
    if (at_ns < work.joined_ns) continue;
    work.WaitUntil(at_ns);
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

/// What gives images until it is stopped: opened again whenever it gives none.
/// @param open  Makes a Device or a Stream; called again only when the one before is gone.
template <typename Open>
Status ReadLive(const std::string& name, const std::string& not_there, const Open& open,
                const SensorWork& work, const TakeImage& image) {
  auto source = open();
  if (!source->is_open() && !work.patient) return Error{ErrorCode::kNotFound, not_there};
  cv::Mat picture;
  bool gives = true;
  while (!work.stop.stop_requested()) {
    if (source->is_open() && source->Read(picture)) {
      if (source->RefusedNow())
        work.tell("the camera '" + name + "' does not let its exposure be set; it sets it itself");
      gives = true;
      if (Status status = image(picture, source->StampNs()); !status.ok()) return status;
      continue;
    }
    if (std::exchange(gives, false))
      work.tell("the camera '" + name + "' gives no images; trying again until it does");
    source.reset();  // a device that is gone comes back as itself only once nobody has it open
    work.WaitToTryAgain();
    source = open();
  }
  return {};
}

std::string CannotBeOpened(const std::string& spec) {
  return "'" + spec + "' is no camera, video or stream that can be opened";
}

/// A video file comes by its own time.
Status ReadVideo(const std::string& spec, const SensorWork& work, const TakeImage& image) {
  cv::VideoCapture video(spec);
  if (!video.isOpened()) return Error{ErrorCode::kNotFound, CannotBeOpened(spec)};
  cv::Mat picture;
  while (!work.stop.stop_requested() && video.read(picture)) {
    const std::int64_t stamp_ns =
        work.began_ns + std::llround(1e6 * video.get(cv::CAP_PROP_POS_MSEC));
    if (stamp_ns < work.joined_ns) continue;
    work.WaitUntil(stamp_ns);
    if (Status status = image(picture, stamp_ns); !status.ok()) return status;
  }
  return {};
}

}  // namespace

Result<std::optional<Exposure>> ParseExposure(const std::string& text) {
  if (text == kNoExposure) return std::optional<Exposure>();
  if (text == "lock") return std::optional<Exposure>(Exposure());
  const std::optional<double> milliseconds = ParseNumber(text);
  if (milliseconds && *milliseconds > 0 && *milliseconds <= 1000)
    return std::optional<Exposure>(Exposure{*milliseconds});
  return Error{ErrorCode::kInvalidInput,
               "'" + text + "' is no exposure: write auto, lock, or milliseconds up to 1000"};
}

Status ReadCamera(const CameraInput& input, const Camera& camera, const SensorWork& work,
                  const TakeImage& image) {
  if (IsPlayed(input.spec)) return PlayImages(input.spec, work, image);
  if (const auto number = DeviceNumber(input.spec)) {
    const std::string name = "/dev/video" + std::to_string(*number);
    const auto open = [&] { return std::make_unique<Device>(*number, camera, input.exposure); };
    return ReadLive(name, "there is no camera '" + name + "', or another program has it", open,
                    work, image);
  }
  if (input.spec.find("://") != std::string::npos && !input.spec.starts_with("file:")) {
    const auto open = [&] { return std::make_unique<Stream>(input.spec); };
    return ReadLive(input.spec, CannotBeOpened(input.spec), open, work, image);
  }
  return ReadVideo(input.spec, work, image);
}

}  // namespace plumbline
