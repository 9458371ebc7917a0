// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/record_inputs.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/dataset/recording_writer.h"

namespace plumbline {
namespace {

constexpr int kJpegQuality = 95;
constexpr int kReadingsForClock = 100;
constexpr double kGapPeriods = 1.5;  ///< Of a camera: longer, images are missing.

struct RecordArguments {
  std::string camera, imu, calibration, out, json;
  double seconds = 0;
  bool png = false;
};

/// What has come, for the status line.
struct Counts {
  std::atomic<int> images = 0, gaps = 0, readings = 0, not_understood = 0, not_later = 0;
  std::atomic<std::int64_t> offset_ns = 0;
};

class Recorder {
 public:
  Recorder(const RecordArguments& arguments, const Camera& camera,
           std::unique_ptr<RecordingWriter> writer, const std::stop_token& stop)
      : arguments_(arguments),
        camera_(camera),
        writer_(std::move(writer)),
        carrier_(kReadingsForClock),
        carried_(IsPlayed(arguments.imu)) {
    began_ns_ = SteadyNs();
    if (carried_ && IsPlayed(arguments.camera)) began_ns_ += 500'000'000;  // both open it first
    outside_.emplace(stop, [this] { stop_.request_stop(); });
    imu_ended_ = arguments_.imu.empty();
    threads_.emplace_back([this] { End(ReadCameraHere(), camera_ended_); });
    if (!arguments_.imu.empty()) threads_.emplace_back([this] { End(ReadImuHere(), imu_ended_); });
  }

  /// Whether it still goes on, after at most a second.
  bool WaitASecond() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, stop_.get_token(), std::chrono::seconds(1), [&] { return over_; });
    const double seconds = 1e-9 * static_cast<double>(SteadyNs() - began_ns_);
    if (arguments_.seconds > 0 && seconds >= arguments_.seconds) stop_.request_stop();
    return !over_ && !stop_.stop_requested();
  }

  /// Ends what still goes on. Errors: what went wrong.
  Status Finish() {
    stop_.request_stop();
    threads_.clear();
    return status_;
  }

  double seconds() const {
    return std::max(1e-9 * static_cast<double>(SteadyNs() - began_ns_), 1e-3);
  }
  const Counts& counts() const { return counts_; }

 private:
  RecordWork Work() {
    return {began_ns_, stop_.get_token(),
            [](const std::string& sentence) { std::fprintf(stderr, "%s\n", sentence.c_str()); }};
  }

  Status ReadCameraHere() {
    std::vector<unsigned char> encoded;
    std::int64_t last_ns = 0;
    const char* ending = arguments_.png ? ".png" : ".jpg";
    return ReadCamera(
        arguments_.camera, camera_, Work(),
        [&](const cv::Mat& picture, std::int64_t stamp_ns) -> Status {
          const PinholeCamera& size = camera_.pinhole;
          if (picture.cols != size.width || picture.rows != size.height) {
            return Error{ErrorCode::kInvalidInput,
                         "the camera gives images of " + std::to_string(picture.cols) + "x" +
                             std::to_string(picture.rows) + ", its calibration is of " +
                             std::to_string(size.width) + "x" + std::to_string(size.height)};
          }
          if (counts_.images > 0 && stamp_ns <= last_ns) return {};
          const double step_s = 1e-9 * static_cast<double>(stamp_ns - last_ns);
          if (counts_.images > 0 && step_s * camera_.rate_hz > kGapPeriods) ++counts_.gaps;
          last_ns = stamp_ns;
          cv::imencode(ending, picture, encoded, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
          ++counts_.images;
          return writer_->AddImage(
              stamp_ns, {reinterpret_cast<const char*>(encoded.data()), encoded.size()}, ending);
        });
  }

  Status ReadImuHere() {
    Status status =
        ReadImuInput(arguments_.imu, Work(),
                     [this](const std::optional<ImuLine>& line, std::int64_t arrived_ns) {
                       return TakeLine(line, arrived_ns);
                     });
    const Status held = AddHeld();  // of an IMU that gave few readings
    return status.ok() ? held : status;
  }

  Status TakeLine(const std::optional<ImuLine>& line, std::int64_t arrived_ns) {
    if (!line) {
      ++counts_.not_understood;
      return {};
    }
    if (carried_ || !line->stamp_ns || carrier_.ready()) return AddReading(*line, arrived_ns);
    carrier_.See(*line->stamp_ns, arrived_ns);
    held_.emplace_back(*line, arrived_ns);
    return carrier_.ready() ? AddHeld() : Status();
  }

  Status AddHeld() {
    if (held_.empty()) return {};
    counts_.offset_ns = carrier_.offset_ns();
    for (const auto& [reading, arrived_ns] : std::exchange(held_, {}))
      if (Status status = AddReading(reading, arrived_ns); !status.ok()) return status;
    return {};
  }

  Status AddReading(const ImuLine& reading, std::int64_t arrived_ns) {
    const std::int64_t offset_ns = carried_ ? 0 : carrier_.offset_ns();
    const ImuSample sample{reading.stamp_ns ? *reading.stamp_ns + offset_ns : arrived_ns,
                           reading.angular_velocity_rad_s, reading.specific_force_m_s2};
    if (sample.stamp_ns <= last_reading_ns_) {
      ++counts_.not_later;
      return {};
    }
    last_reading_ns_ = sample.stamp_ns;
    ++counts_.readings;
    return writer_->AddReadings({&sample, 1});
  }

  /// One of both has ended. Without images a recording is over; readings that are played again
  /// come to their end, those of an IMU go on for as long as was asked for.
  void End(const Status& status, bool& ended) {
    const std::lock_guard lock(mutex_);
    ended = true;
    if (status_.ok()) status_ = status;
    const bool waits = !imu_ended_ && (carried_ || arguments_.seconds > 0);
    over_ = over_ || !status.ok() || (camera_ended_ && !waits);
    changed_.notify_all();
  }

  const RecordArguments& arguments_;
  const Camera camera_;
  const std::unique_ptr<RecordingWriter> writer_;
  // Of the IMU's thread.
  ClockCarrier carrier_;
  std::vector<std::pair<ImuLine, std::int64_t>> held_;  ///< Until the clocks are known.
  std::int64_t last_reading_ns_ = std::numeric_limits<std::int64_t>::min();
  const bool carried_;
  std::int64_t began_ns_ = 0;
  Counts counts_;
  std::stop_source stop_;
  std::optional<std::stop_callback<std::function<void()>>> outside_;
  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any changed_;
  bool camera_ended_ = false, imu_ended_ = false, over_ = false;
  Status status_;
  std::vector<std::jthread> threads_;  ///< Last: they use all of the above.
};

std::string InWords(const Counts& counts, double seconds) {
  char text[300];
  std::snprintf(text, sizeof(text),
                "%.0f s: %d images (%.1f Hz, %d gaps), %d readings (%.1f Hz), %d lines not "
                "understood, %d not later",
                seconds, counts.images.load(), counts.images / seconds, counts.gaps.load(),
                counts.readings.load(), counts.readings / seconds, counts.not_understood.load(),
                counts.not_later.load());
  return text;
}

/// Of a recording to which nothing came; what is not of it stays.
void RemoveBeginning(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const char* name : {"camera.json", "imu.json", "imu.csv", "color.csv", "color", ""})
    std::filesystem::remove(folder / name, ignored);
}

Status Record(const RecordArguments& arguments) {
  namespace fs = std::filesystem;
  fs::path file = arguments.calibration;
  std::error_code ignored;
  std::optional<nlohmann::json> imu_json;
  if (fs::is_directory(file, ignored)) {
    if (const fs::path imu = file / "imu.json"; fs::exists(imu, ignored)) {
      auto read = ReadJson(imu);
      if (!read.ok()) return read.error();
      imu_json = std::move(read).value();
    }
    file /= "camera.json";
  }
  auto camera_json = ReadJson(file);
  if (!camera_json.ok()) return camera_json.error();
  const Result<Camera> camera = CameraFromJson(*camera_json, file);
  if (!camera.ok()) return camera.error();
  auto writer = RecordingWriter::Create(arguments.out, *camera_json, imu_json);
  if (!writer.ok()) return writer.error();
  if (!camera->body_from_cam) {
    std::fprintf(stderr,
                 "'%s' does not say where the camera sits on the IMU (body_from_cam): no "
                 "poses can be found from this recording\n",
                 file.c_str());
  }
  ConsoleWork console;
  auto recorder = std::make_unique<Recorder>(arguments, *camera, std::move(writer).value(),
                                             console.context().stop);
  while (recorder->WaitASecond())
    std::fprintf(stderr, "%s\n", InWords(recorder->counts(), recorder->seconds()).c_str());
  const double seconds = recorder->seconds();
  const Status status = recorder->Finish();
  const Counts& counts = recorder->counts();
  if (!status.ok() && counts.images == 0 && counts.readings == 0) {
    recorder.reset();
    RemoveBeginning(arguments.out);
    return status;
  }
  if (arguments.json != "-")
    std::printf("%s; wrote %s\n", InWords(counts, seconds).c_str(), arguments.out.c_str());
  if (!arguments.json.empty()) {
    const nlohmann::json json = {{"seconds", seconds},
                                 {"images", counts.images.load()},
                                 {"gaps", counts.gaps.load()},
                                 {"readings", counts.readings.load()},
                                 {"not_understood", counts.not_understood.load()},
                                 {"not_later", counts.not_later.load()},
                                 {"clock_offset_s", 1e-9 * static_cast<double>(counts.offset_ns)}};
    if (Status written = WriteJsonResult(arguments.json, json); !written.ok()) return written;
  }
  return status;
}

}  // namespace

void AddRecordVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<RecordArguments>();
  CLI::App* verb = app.add_subcommand(
      "record", "Record a camera and an IMU, kill-safe; run --live maps the folder meanwhile");
  verb->add_option(
          "--camera", arguments->camera,
          "A number or /dev/videoN, a video file or URL, or play:SEQUENCE: its images again "
          "by the clock")
      ->required();
  verb->add_option("--imu", arguments->imu,
                   "serial:DEVICE[@BAUD], udp:PORT (of this machine), - for standard input, or "
                   "play:SEQUENCE; lines t,wx,wy,wz,ax,ay,az or the same without t");
  verb->add_option("--calibration", arguments->calibration,
                   "camera.json of the camera, or a folder with it and imu.json")
      ->required();
  verb->add_option("--out", arguments->out, "Folder to make")->required();
  verb->add_option("--seconds", arguments->seconds, "Stop after so long (default: at Ctrl-C)")
      ->check(CLI::PositiveNumber);
  verb->add_flag("--png", arguments->png, "Images as PNG, which lose nothing (default: JPEG)");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Record(*arguments); }; });
}

}  // namespace plumbline
