// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/dataset/recording_writer.h"
#include "engine/sources/recording_rig.h"
#include "engine/sources/sensor_recorder.h"

namespace plumbline {
namespace {

struct RecordArguments {
  CameraInput camera;
  std::string exposure = kNoExposure, imu, calibration, out, json;
  double seconds = 0;
  bool png = false;
};

class Recorder {
 public:
  Recorder(const RecordArguments& arguments, const Camera& camera,
           std::unique_ptr<RecordingWriter> writer, const std::stop_token& stop)
      : arguments_(arguments),
        writer_(std::move(writer)),
        camera_(camera, arguments.png, *writer_),
        imu_(*writer_),
        imu_played_(IsPlayed(arguments.imu)) {
    began_ns_ = SteadyNs();
    if (imu_played_ && IsPlayed(arguments.camera.spec))
      began_ns_ += 500'000'000;  // both open it first
    outside_.emplace(stop, [this] { stop_.request_stop(); });
    imu_ended_ = arguments_.imu.empty();
    threads_.emplace_back([this] { End(camera_.Run(arguments_.camera, Work()), camera_ended_); });
    if (!arguments_.imu.empty())
      threads_.emplace_back([this] { End(imu_.Run(arguments_.imu, Work()), imu_ended_); });
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
  const CameraRecorder& camera() const { return camera_; }
  const ImuRecorder& imu() const { return imu_; }

 private:
  SensorWork Work() {
    SensorWork work;
    work.began_ns = began_ns_;
    work.stop = stop_.get_token();
    work.tell = [](const std::string& sentence) { std::fprintf(stderr, "%s\n", sentence.c_str()); };
    return work;
  }

  /// One of both has ended. Without images a recording is over; readings that are played again
  /// come to their end, those of an IMU go on for as long as was asked for.
  void End(const Status& status, bool& ended) {
    const std::lock_guard lock(mutex_);
    ended = true;
    if (status_.ok()) status_ = status;
    const bool waits = !imu_ended_ && (imu_played_ || arguments_.seconds > 0);
    over_ = over_ || !status.ok() || (camera_ended_ && !waits);
    changed_.notify_all();
  }

  const RecordArguments& arguments_;
  const std::unique_ptr<RecordingWriter> writer_;
  CameraRecorder camera_;
  ImuRecorder imu_;
  const bool imu_played_;
  std::int64_t began_ns_ = 0;
  std::stop_source stop_;
  std::optional<std::stop_callback<std::function<void()>>> outside_;
  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any changed_;
  bool camera_ended_ = false, imu_ended_ = false, over_ = false;
  Status status_;
  std::vector<std::jthread> threads_;  ///< Last: they use all of the above.
};

std::string InWords(const Recorder& recorder, double seconds) {
  const int images = recorder.camera().images(), readings = recorder.imu().readings();
  char text[300];
  std::snprintf(text, sizeof(text),
                "%.0f s: %d images (%.1f Hz, %d gaps), %d readings (%.1f Hz), %d lines not "
                "understood, %d not later",
                seconds, images, images / seconds, recorder.camera().gaps(), readings,
                readings / seconds, recorder.imu().not_understood(), recorder.imu().not_later());
  return text;
}

Status Record(RecordArguments& arguments) {
  auto exposure = ParseExposure(arguments.exposure);
  if (!exposure.ok()) return exposure.error();
  arguments.camera.exposure = *exposure;
  const Result<RecordingRig> rig = ReadRecordingRig(arguments.calibration);
  if (!rig.ok()) return rig.error();
  auto writer = RecordingWriter::Create(arguments.out, rig->camera_json, rig->imu_json);
  if (!writer.ok()) return writer.error();
  if (!rig->camera.body_from_cam)
    std::fprintf(stderr, "%s\n", NoBodyFromCam(arguments.calibration).c_str());
  ConsoleWork console;
  auto recorder = std::make_unique<Recorder>(arguments, rig->camera, std::move(writer).value(),
                                             console.context().stop);
  while (recorder->WaitASecond())
    std::fprintf(stderr, "%s\n", InWords(*recorder, recorder->seconds()).c_str());
  const double seconds = recorder->seconds();
  const Status status = recorder->Finish();
  const CameraRecorder& camera = recorder->camera();
  const ImuRecorder& imu = recorder->imu();
  if (!status.ok() && camera.images() == 0 && imu.readings() == 0) {
    recorder.reset();
    RecordingWriter::RemoveIfEmpty(arguments.out);
    return status;
  }
  if (arguments.json != "-")
    std::printf("%s; wrote %s\n", InWords(*recorder, seconds).c_str(), arguments.out.c_str());
  if (!arguments.json.empty()) {
    const nlohmann::json json = {{"seconds", seconds},
                                 {"images", camera.images()},
                                 {"gaps", camera.gaps()},
                                 {"readings", imu.readings()},
                                 {"not_understood", imu.not_understood()},
                                 {"not_later", imu.not_later()},
                                 {"clock_offset_s", 1e-9 * static_cast<double>(imu.offset_ns())}};
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
          "--camera", arguments->camera.spec,
          "A number or /dev/videoN, a video file or URL, or play:SEQUENCE: its images again "
          "by the clock")
      ->required();
  verb->add_option("--imu", arguments->imu,
                   "serial:DEVICE[@BAUD], udp:PORT (of this machine), tcp:HOST:PORT (who listens "
                   "there), - for standard input, or play:SEQUENCE; lines t,wx,wy,wz,ax,ay,az or "
                   "the same without t");
  verb->add_option("--exposure", arguments->exposure,
                   "Of a V4L2 camera: auto, lock (as it is after two seconds), or milliseconds")
      ->capture_default_str();
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
