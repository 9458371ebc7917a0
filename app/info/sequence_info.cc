// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/dataset/imu_file.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/stamp_statistics.h"
#include "engine/dataset/tracks_file.h"
#include "engine/geometry/angles.h"
#include "engine/sensor/distorted_camera.h"

namespace plumbline {
namespace {

constexpr double kFrameGap = 1.5;  ///< In median steps; a frame is missing.
constexpr double kImuGap = 2.5;    ///< Samples jitter more than frames do.
constexpr int kImagesLookedAt = 8;
constexpr double kFastestCamera = 20;  ///< [m/s]

void AddWarnings(PathInfo& info, const std::vector<std::string>& sentences) {
  info.odd.insert(info.odd.end(), sentences.begin(), sentences.end());
}

nlohmann::json ToJson(const StampStatistics& stamps, std::size_t count) {
  return {{"count", count},
          {"rate_hz", stamps.rate_hz()},
          {"first_s", static_cast<double>(stamps.first_ns) * 1e-9},
          {"last_s", static_cast<double>(stamps.last_ns) * 1e-9},
          {"span_s", stamps.span_s()},
          {"gaps", stamps.gaps},
          {"longest_step_s", stamps.longest_step_s}};
}

StampStatistics AddFrames(const Sequence& sequence, PathInfo& info) {
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < sequence.num_frames(); ++i) stamps.push_back(sequence.stamp_ns(i));
  const StampStatistics frames = StatisticsOf(stamps, kFrameGap);
  info.lines.push_back(
      {"Frames", Format("%d at %.4g Hz, %.1f s%s", sequence.num_frames(),
                        frames.rate_hz() > 0 ? frames.rate_hz() : sequence.rate_hz(),
                        frames.span_s(), sequence.has_images() ? "" : ", without images")});
  info.json["frames"] = ToJson(frames, stamps.size());
  if (frames.gaps > 0) {
    info.odd.push_back(Format("%s in the frames: the longest lasts %.2f s, after frame %d.",
                              Counted(static_cast<std::size_t>(frames.gaps), "gap", "gaps").c_str(),
                              frames.longest_step_s, frames.longest_after));
  }
  if (frames.rate_hz() > 0 && std::abs(frames.rate_hz() / sequence.rate_hz() - 1) > 0.1) {
    info.odd.push_back(Format("camera.json says %.4g Hz, but frames come at %.4g Hz.",
                              sequence.rate_hz(), frames.rate_hz()));
  }
  return frames;
}

/// Degrees between the left and right (or upper and lower) border of the recorded image.
double FieldOfView(const Camera& camera, bool horizontal) {
  const DistortedCamera lens(camera);
  const PinholeCamera& c = camera.pinhole;
  const Eigen::Vector2d first = horizontal ? Eigen::Vector2d(0, c.cy) : Eigen::Vector2d(c.cx, 0);
  const Eigen::Vector2d last =
      horizontal ? Eigen::Vector2d(c.width - 1, c.cy) : Eigen::Vector2d(c.cx, c.height - 1);
  const auto a = lens.Unproject(first), b = lens.Unproject(last);
  const auto from_axis = [&](const std::optional<Eigen::Vector3d>& ray) {
    return ray ? std::acos(std::clamp(ray->z(), -1.0, 1.0)) : lens.max_angle_rad();
  };
  return (from_axis(a) + from_axis(b)) * kDegPerRad;
}

void AddCameras(const Sequence& sequence, PathInfo& info) {
  info.json["cameras"] = nlohmann::json::array();
  for (const NamedCamera& named : sequence.calibration().cameras) {
    const Camera& camera = named.camera;
    const double across = FieldOfView(camera, true), upright = FieldOfView(camera, false);
    info.lines.push_back(
        {"Camera",
         Format("%dx%d, %s, %.0f x %.0f degrees of view%s", camera.pinhole.width,
                camera.pinhole.height, std::string(CameraModelName(camera.model)).c_str(), across,
                upright, camera.body_from_cam ? ", place in the body known" : "") +
             (camera.rolling_shutter_s != 0
                  ? Format(", rolling shutter of %.4g ms", 1e3 * camera.rolling_shutter_s)
                  : "")});
    nlohmann::json json = CameraToJson(camera);
    json["name"] = named.name;
    json["field_of_view_deg"] = {across, upright};
    info.json["cameras"].push_back(std::move(json));
  }
}

void LookAtImages(const Sequence& sequence, PathInfo& info) {
  if (!sequence.has_images()) return;
  const int count = std::min(kImagesLookedAt, sequence.num_frames());
  int readable = 0;
  for (int i = 0; i < count; ++i) {
    const int frame = count > 1 ? i * (sequence.num_frames() - 1) / (count - 1) : 0;
    const Result<cv::Mat> image = sequence.ReadRawImage(frame);
    readable += image.ok();
    if (!image.ok())
      info.odd.push_back("frame " + std::to_string(frame) + ": " + image.error().message);
  }
  info.lines.push_back({"Images", Format("%d of %d looked at can be read", readable, count)});
  info.json["images"] = {{"looked_at", count}, {"readable", readable}};
}

void AddPoses(const Sequence& sequence, PathInfo& info) {
  const int posed = NumPosedFrames(sequence);
  double path_m = 0;
  std::optional<int> before;
  int jumps = 0;
  std::string first_jump;
  for (int i = 0; i < sequence.num_frames(); ++i) {
    const auto pose = sequence.world_from_cam(i);
    if (!pose) continue;
    if (before) {
      const double step =
          (pose->translation() - sequence.world_from_cam(*before)->translation()).norm();
      const double seconds =
          static_cast<double>(sequence.stamp_ns(i) - sequence.stamp_ns(*before)) * 1e-9;
      path_m += step;
      if (step > kFastestCamera * seconds && jumps++ == 0)
        first_jump = Format("%.2f m between frames %d and %d", step, *before, i);
    }
    before = i;
  }
  info.json["poses"] = {{"frames", posed}, {"path_m", path_m}};
  if (posed == 0) {
    info.lines.push_back({"Poses", "none"});
    info.odd.push_back("No frame has a pose; run needs a trajectory (--poses FILE).");
    return;
  }
  info.lines.push_back(
      {"Poses", Format("%d of %d frames, path %.1f m", posed, sequence.num_frames(), path_m)});
  if (jumps > 0) {
    info.odd.push_back(
        Format("The camera jumps %d times, first by %s.", jumps, first_jump.c_str()));
  }
}

void AddGravity(const Sequence& sequence, bool is_ours, PathInfo& info) {
  const auto gravity = sequence.gravity_in_world();
  const auto floor = sequence.floor_in_world();
  const std::size_t levels = sequence.floor_levels().size();
  info.json["gravity"] = nullptr;
  info.json["floor"] = nullptr;
  if (floor) info.json["floor"] = std::vector<double>(floor->data(), floor->data() + 4);
  if (!gravity) {
    info.lines.push_back({"Gravity", "not known"});
    info.odd.push_back(
        std::string(is_ours
                        ? "There is no gravity.json; run needs the direction of gravity"
                        : "Gravity is not told; run needs its direction, in the gravity.json of "
                          "a converted sequence") +
        " (plumbline gravity finds it in a scan).");
    return;
  }
  info.json["gravity"] = std::vector<double>(gravity->data(), gravity->data() + 3);
  info.lines.push_back(
      {"Gravity",
       Format("(%.3g, %.3g, %.3g) in world, floor %s", gravity->x(), gravity->y(), gravity->z(),
              floor ? "known" : "not known") +
           (levels > 0 ? Format(" with %d more levels", static_cast<int>(levels)) : "")});
}

/// What the samples themselves say against their use.
void LookAtSamples(const std::vector<ImuSample>& samples, const ImuCalibration& imu,
                   PathInfo& info) {
  int saturated = 0;
  double force = 0;
  for (const ImuSample& sample : samples) {
    const double gyro = sample.angular_velocity_rad_s.cwiseAbs().maxCoeff();
    const double accel = sample.specific_force_m_s2.cwiseAbs().maxCoeff();
    saturated += (imu.saturation_gyro_rad_s && gyro >= *imu.saturation_gyro_rad_s) ||
                 (imu.saturation_accel_m_s2 && accel >= *imu.saturation_accel_m_s2);
    force += sample.specific_force_m_s2.norm() / static_cast<double>(samples.size());
  }
  info.json["imu"]["saturated"] = saturated;
  info.json["imu"]["mean_force_m_s2"] = force;
  if (saturated > 0) {
    info.odd.push_back(
        Counted(static_cast<std::size_t>(saturated), "IMU sample reaches", "IMU samples reach") +
        " the limit of the sensor.");
  }
  if (force < 7 || force > 13) {
    info.odd.push_back(
        Format("The IMU's specific force is %.3g m/s^2 on average, far from gravity: "
               "is it in other units?",
               force));
  }
}

void AddImu(const Sequence& sequence, const StampStatistics& frames, PathInfo& info) {
  info.json["imu"] = nullptr;
  if (!sequence.has_imu()) return;
  const Result<ImuRecording> recording = sequence.ReadImu();
  if (!recording.ok()) {
    info.odd.push_back(recording.error().message);
    return;
  }
  AddWarnings(info, recording.value().warnings);
  const std::vector<ImuSample>& samples = recording.value().samples;
  std::vector<std::int64_t> stamps;
  for (const ImuSample& sample : samples) stamps.push_back(sample.stamp_ns);
  const StampStatistics imu = StatisticsOf(stamps, kImuGap);
  info.lines.push_back(
      {"IMU", Format("%zu samples at %.4g Hz, %.1f s, longest step %.1f ms", samples.size(),
                     imu.rate_hz(), imu.span_s(), 1e3 * imu.longest_step_s)});
  info.json["imu"] = ToJson(imu, samples.size());
  if (imu.gaps > 0) {
    info.odd.push_back(Format("%s in the IMU's samples: the longest lasts %.0f ms.",
                              Counted(static_cast<std::size_t>(imu.gaps), "gap", "gaps").c_str(),
                              1e3 * imu.longest_step_s));
  }
  const auto& calibration = sequence.calibration().imu;
  if (!calibration) info.odd.push_back("The noise of the IMU is not known (imu.json).");
  if (calibration && std::abs(imu.rate_hz() / calibration->rate_hz - 1) > 0.1) {
    info.odd.push_back(Format("The calibration says %.4g Hz, but samples come at %.4g Hz.",
                              calibration->rate_hz, imu.rate_hz()));
  }
  if (!sequence.calibration().cameras.front().camera.body_from_cam)
    info.odd.push_back(
        "There is an IMU, but where the camera sits on it is not known (no body_from_cam).");
  constexpr std::int64_t kMargin = 50'000'000;
  if (imu.first_ns > frames.first_ns + kMargin || imu.last_ns < frames.last_ns - kMargin)
    info.odd.push_back("The IMU does not cover the whole time of the frames.");
  LookAtSamples(samples, calibration.value_or(ImuCalibration()), info);
}

void AddTracksAndReference(const Sequence& sequence, PathInfo& info) {
  if (const auto file = sequence.tracks_file()) {
    const Result<FeatureTracks> tracks = ReadTracksFile(*file);
    if (!tracks.ok()) {
      info.odd.push_back(tracks.error().message);
    } else {
      std::size_t points = 0;
      for (const TrackedImage& image : tracks.value().images) points += image.points.size();
      const std::size_t images = tracks.value().images.size();
      info.lines.push_back(
          {"Tracks", Format("%zu images, %zu points each on average", images, points / images)});
      info.json["tracks"] = {{"images", images}, {"points", points}};
      if (sequence.has_images()) AddWarnings(info, tracks.value().warnings);
    }
  }
  if (const auto file = sequence.reference_file()) {
    const Result<ReferenceStates> reference = ReadReferenceStates(*file);
    if (!reference.ok()) {
      info.odd.push_back(reference.error().message);
      return;
    }
    AddWarnings(info, reference.value().warnings);
    const auto& states = reference.value().states;
    info.lines.push_back(
        {"Reference",
         Format("%zu states of the body with velocity and biases, %.1f s", states.size(),
                static_cast<double>(states.back().stamp_ns - states.front().stamp_ns) * 1e-9)});
    info.json["reference"] = {{"states", states.size()}};
  }
}

void AddCompanions(const Sequence& sequence, PathInfo& info) {
  const std::pair<const char*, bool> kCompanions[] = {
      {"edges", sequence.has_edges()},
      {"proposals", sequence.has_proposals()},
      {"depth", sequence.has_depth()},
      {"scan", sequence.scene_file().has_value()},
      {"models", sequence.models_folder().has_value()},
      {"ground truth", sequence.ground_truth_file().has_value()}};
  std::string there;
  info.json["companions"] = nlohmann::json::array();
  for (const auto& [name, present] : kCompanions) {
    if (!present) continue;
    there += (there.empty() ? "" : ", ") + std::string(name);
    info.json["companions"].push_back(name);
  }
  if (!there.empty()) info.lines.push_back({"Also there", there});
}

/// Objects whose poses a public data set tells in a form of its own.
void AddTruth(const Sequence& sequence, PathInfo& info) {
  if (sequence.ground_truth_file()) return;  // one of the companions
  std::vector<std::string> warnings;
  const Result<std::optional<GroundTruth>> truth = ReadTruthOf(sequence, warnings);
  AddWarnings(info, warnings);
  if (!truth.ok()) {
    info.odd.push_back(truth.error().message);
  } else if (truth->has_value()) {
    const std::size_t count = (*truth)->instances.size();
    info.lines.push_back(
        {"Truth", Counted(count, "object", "objects") + " in the world of the sequence"});
    info.json["ground_truth"] = {{"instances", count}};
  }
}

}  // namespace

Likeness ProbeSequence(const std::filesystem::path& path) {
  const SequenceFormat* format = FindSequenceFormat(path);
  return format == nullptr ? Likeness::kNone : format->probe(path);
}

Result<PathInfo> DescribeSequence(const std::filesystem::path& path) {
  const Result<std::shared_ptr<const Sequence>> opened = OpenSequence(path);
  if (!opened.ok()) return opened.error();
  const Sequence& sequence = *opened.value();
  const SequenceFormat& format = *FindSequenceFormat(path);
  PathInfo info;
  info.title = "sequence, " + std::string(format.title);
  info.json["format"] = {{"name", format.name}, {"written", format.write != nullptr}};
  const StampStatistics frames = AddFrames(sequence, info);
  AddCameras(sequence, info);
  LookAtImages(sequence, info);
  AddPoses(sequence, info);
  AddGravity(sequence, format.name == "plumbline", info);
  AddImu(sequence, frames, info);
  AddTracksAndReference(sequence, info);
  AddCompanions(sequence, info);
  AddTruth(sequence, info);
  AddWarnings(info, sequence.warnings());
  return info;
}

}  // namespace plumbline
