// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/own_pose_message.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"
#include "engine/base/log.h"
#include "engine/recording/frame_codec.h"
#include "engine/transport/wire_values.h"

namespace plumbline {
namespace {

constexpr int kReadingsAMessage = 100'000;               // 5.6 MB
constexpr std::size_t kRecordBytesAMessage = 4'000'000;  // a record more may be added to them
constexpr std::size_t kImagesAMessage = 200, kCorrectionsAMessage = 8;

Error BadImu(const std::string& what) {
  return {ErrorCode::kCorrupt,
          "the player sent " + what + " of an IMU that is none; is it another program's?"};
}

Error BadPoses() {
  return {ErrorCode::kCorrupt,
          "the poses that a node found cannot be read; is it of another version?"};
}

template <typename Message>
void AddReading(const ImuSample& sample, Message& message) {
  message.add_stamps_ns(sample.stamp_ns);
  for (const double rate : sample.angular_velocity_rad_s) message.add_readings(rate);
  for (const double force : sample.specific_force_m_s2) message.add_readings(force);
}

/// Adds the readings of a message to those before. Errors: kCorrupt.
template <typename Message>
Status AddReadings(const Message& message, std::vector<ImuSample>& samples) {
  if (message.readings_size() != 6 * message.stamps_ns_size()) return BadImu("readings");
  for (int i = 0; i < message.stamps_ns_size(); ++i) {
    ImuSample sample{message.stamps_ns(i), {}, {}};
    for (int axis = 0; axis < 3; ++axis) {
      sample.angular_velocity_rad_s[axis] = message.readings(6 * i + axis);
      sample.specific_force_m_s2[axis] = message.readings(6 * i + 3 + axis);
    }
    const bool rises = samples.empty() || sample.stamp_ns > samples.back().stamp_ns;
    if (!rises || !sample.angular_velocity_rad_s.allFinite() ||
        !sample.specific_force_m_s2.allFinite())
      return BadImu("readings");
    samples.push_back(sample);
  }
  return {};
}

/// Errors: kCorrupt. @param known  Images.
Status AddCorrections(const wire::OwnPoses& message, int known,
                      std::vector<PastCorrection>& corrections) {
  for (const wire::PastCorrection& row : message.corrections()) {
    PastCorrection correction;
    correction.image = row.image();
    correction.epoch = row.epoch();
    const PastCorrection* last = corrections.empty() ? nullptr : &corrections.back();
    if (!DecodeMoves(row.moves(), correction).ok() || row.image() < 0 || row.image() > known ||
        (last != nullptr && (row.epoch() <= last->epoch || row.image() <= last->image)))
      return BadPoses();
    corrections.push_back(std::move(correction));
  }
  return {};
}

Status TakeLoops(const wire::OwnPoses& message, OwnPoses& poses) {
  try {
    poses.loops = LoopReportFromJson(ParseJson(message.loops()));
  } catch (const std::exception&) {
    return BadPoses();
  }
  return {};
}

void AddCorrection(const PastCorrection& correction, wire::OwnPoses& message) {
  wire::PastCorrection& row = *message.add_corrections();
  row.set_image(correction.image);
  row.set_epoch(correction.epoch);
  row.set_moves(EncodeMoves(correction));
}

class RemoteOwnPoses : public OwnPoseFeed {
 public:
  RemoteOwnPoses(NodeClient& vio, std::size_t images, std::size_t corrections)
      : vio_(vio), images_(images), corrections_(corrections) {}

  bool Next(const std::stop_token& stop) override {
    while (come_.frames.size() == taken_) {
      if (stop.stop_requested() || !finding_) return false;
      if (const Result<bool> more = Ask(stop); !more.ok()) {
        if (more.error().code != ErrorCode::kCancelled) log::warn("{}", more.error().message);
        return false;
      } else if (!*more && finding_) {
        std::this_thread::sleep_for(kAskPeriod);
      }
    }
    return true;
  }
  OwnPoseReport TakeReport() override { return std::move(come_.frames[taken_++]); }
  std::vector<PastCorrection> TakeCorrections() override {
    return std::exchange(come_.corrections, {});
  }
  const LoopReport& loops() const override { return come_.loops; }

 private:
  static constexpr auto kAskPeriod = std::chrono::milliseconds(4);

  /// @return whether there was anything new.
  Result<bool> Ask(const std::stop_token& stop) {
    wire::Request request;
    wire::OwnPosesRequest& known = *request.mutable_own_poses();
    known.set_from(static_cast<int>(images_));
    known.set_corrections(static_cast<int>(corrections_));
    known.set_by_now(true);
    const Result<SharedReply> reply = vio_.AskAndWait(std::move(request), stop);
    if (!reply.ok()) return reply.error();
    const wire::OwnPoses& message = (*reply)->own_poses();
    come_.frames.clear();
    taken_ = 0;
    const std::size_t corrections_before = come_.corrections.size();
    const Result<bool> finding = AddOwnPosesByNow(message, static_cast<int>(images_), come_);
    if (!finding.ok()) return finding.error();
    images_ += come_.frames.size();
    corrections_ += come_.corrections.size() - corrections_before;
    finding_ = *finding;
    return message.records_size() > 0 || message.corrections_size() > 0;
  }

  NodeClient& vio_;
  std::size_t images_, corrections_;  ///< That have come.
  OwnPoses come_;                     ///< Frames of the last message; corrections not taken.
  std::size_t taken_ = 0;             ///< Of those frames.
  bool finding_ = true;
};

void SetNoise(const ImuCalibration& imu, wire::ImuNoise& out) {
  out.set_rate_hz(imu.rate_hz);
  out.set_gyro_noise_density(imu.gyro_noise_density);
  out.set_accel_noise_density(imu.accel_noise_density);
  out.set_gyro_bias_walk(imu.gyro_bias_walk);
  out.set_accel_bias_walk(imu.accel_bias_walk);
  out.set_time_offset_s(imu.time_offset_s);
  out.set_gravity_m_s2(imu.gravity_m_s2);
  if (imu.saturation_gyro_rad_s) out.set_saturation_gyro_rad_s(*imu.saturation_gyro_rad_s);
  if (imu.saturation_accel_m_s2) out.set_saturation_accel_m_s2(*imu.saturation_accel_m_s2);
}

Result<ImuCalibration> NoiseFromWire(const wire::ImuNoise& row) {
  ImuCalibration imu;
  imu.rate_hz = row.rate_hz();
  imu.gyro_noise_density = row.gyro_noise_density();
  imu.accel_noise_density = row.accel_noise_density();
  imu.gyro_bias_walk = row.gyro_bias_walk();
  imu.accel_bias_walk = row.accel_bias_walk();
  imu.time_offset_s = row.time_offset_s();
  imu.gravity_m_s2 = row.gravity_m_s2();
  if (row.has_saturation_gyro_rad_s()) imu.saturation_gyro_rad_s = row.saturation_gyro_rad_s();
  if (row.has_saturation_accel_m_s2()) imu.saturation_accel_m_s2 = row.saturation_accel_m_s2();
  for (const double positive :
       {imu.rate_hz, imu.gyro_noise_density, imu.accel_noise_density, imu.gyro_bias_walk,
        imu.accel_bias_walk, imu.gravity_m_s2, imu.saturation_gyro_rad_s.value_or(1),
        imu.saturation_accel_m_s2.value_or(1)})
    if (!(positive > 0) || !std::isfinite(positive)) return BadImu("the noise");
  if (!std::isfinite(imu.time_offset_s)) return BadImu("the clock");
  return imu;
}

void SetCamera(const Camera& camera, wire::RawCamera& out) {
  out.set_model(static_cast<std::uint32_t>(camera.model));
  out.mutable_pinhole()->set_width(camera.pinhole.width);
  out.mutable_pinhole()->set_height(camera.pinhole.height);
  out.mutable_pinhole()->set_fx(camera.pinhole.fx);
  out.mutable_pinhole()->set_fy(camera.pinhole.fy);
  out.mutable_pinhole()->set_cx(camera.pinhole.cx);
  out.mutable_pinhole()->set_cy(camera.pinhole.cy);
  out.mutable_distortion()->Add(camera.distortion.begin(), camera.distortion.end());
  out.set_rate_hz(camera.rate_hz);
  if (camera.body_from_cam) SetTransform(*camera.body_from_cam, *out.mutable_body_from_cam());
  out.set_rolling_shutter_s(camera.rolling_shutter_s);
}

/// As camera.json would have it: its reader knows what a camera is.
Result<Camera> CameraFromWire(const wire::RawCamera& row) {
  if (row.model() > static_cast<std::uint32_t>(CameraModel::kFov)) return BadImu("the camera");
  Camera camera;
  camera.model = static_cast<CameraModel>(row.model());
  const wire::Pinhole& pinhole = row.pinhole();
  camera.pinhole = {pinhole.width(), pinhole.height(), pinhole.fx(),
                    pinhole.fy(),    pinhole.cx(),     pinhole.cy()};
  camera.distortion.assign(row.distortion().begin(), row.distortion().end());
  camera.rate_hz = row.rate_hz();
  camera.rolling_shutter_s = row.rolling_shutter_s();
  if (row.body_from_cam_size() > 0) {
    const auto pose = TransformFromWire(row.body_from_cam());
    if (!pose.ok()) return pose.error();
    const Eigen::Matrix3d rotation = pose->linear();
    if (!(rotation * rotation.transpose()).isIdentity(1e-6) || rotation.determinant() < 0)
      return BadImu("the camera");
    camera.body_from_cam = *pose;
  }
  if (const auto checked = CameraFromJson(CameraToJson(camera), "the player's camera");
      !checked.ok())
    return Error{ErrorCode::kCorrupt, checked.error().message};
  return camera;
}

}  // namespace

wire::Imu ImuToWire(const Calibration& calibration, const ImuRecording& imu, int from) {
  wire::Imu message;
  SetCamera(calibration.cameras.front().camera, *message.mutable_camera());
  if (calibration.imu) SetNoise(*calibration.imu, *message.mutable_noise());
  const int total = static_cast<int>(imu.samples.size());
  message.set_total(total);
  const int begin = std::clamp(from, 0, total);
  for (int i = begin; i < std::min(total, begin + kReadingsAMessage); ++i) {
    AddReading(imu.samples[static_cast<std::size_t>(i)], message);
  }
  return message;
}

Result<wire::Growth> GrowthToWire(const Sequence& sequence, const GrowingRecording* growing,
                                  const wire::GrowthRequest& known) {
  wire::Growth growth;
  // Asked first: what came before the end is in the message that tells of it, or in one before.
  const bool ended = growing == nullptr || growing->ended();
  const int frames = sequence.num_frames();
  for (int i = std::clamp(known.frames(), 0, frames); i < frames; ++i)
    growth.add_frame_stamps_ns(sequence.stamp_ns(i));
  const auto from = static_cast<std::size_t>(std::max(known.readings(), 0));
  std::vector<ImuSample> readings;
  if (growing != nullptr) {
    readings = growing->WaitForImu(from, std::numeric_limits<std::int64_t>::min(), {});
  } else if (known.readings() != kEveryReading) {
    Result<ImuRecording> imu = sequence.ReadImu();
    if (!imu.ok()) return imu.error();
    readings.assign(
        imu->samples.begin() + static_cast<std::ptrdiff_t>(std::min(from, imu->samples.size())),
        imu->samples.end());
  }
  const std::size_t sent = std::min<std::size_t>(readings.size(), kReadingsAMessage);
  for (std::size_t i = 0; i < sent; ++i) AddReading(readings[i], growth);
  growth.set_ended(ended && sent == readings.size());
  return growth;
}

Status AddGrowthFromWire(const wire::Growth& growth, std::vector<ImuSample>& samples) {
  return AddReadings(growth, samples);
}

Result<bool> AddImuFromWire(const wire::Imu& message, Calibration& calibration,
                            std::vector<ImuSample>& samples) {
  Result<Camera> camera = CameraFromWire(message.camera());
  if (!camera.ok()) return camera.error();
  calibration.cameras = {{"camera", std::move(camera).value()}};
  calibration.imu.reset();
  if (message.has_noise()) {
    const Result<ImuCalibration> noise = NoiseFromWire(message.noise());
    if (!noise.ok()) return noise.error();
    calibration.imu = *noise;
  }
  if (Status status = AddReadings(message, samples); !status.ok()) return status.error();
  const int known = static_cast<int>(samples.size());
  if (known > message.total() || (known < message.total() && message.stamps_ns().empty()))
    return BadImu("readings");
  return known == message.total();
}

wire::OwnPoses OwnPosesToWire(const OwnPoses& poses, int from) {
  wire::OwnPoses message;
  const int total = static_cast<int>(poses.frames.size());
  message.set_total(total);
  int next = std::clamp(from, 0, total);
  for (std::size_t bytes = 0; next < total && bytes < kRecordBytesAMessage; ++next) {
    message.add_records(EncodeOwnPose(poses.frames[static_cast<std::size_t>(next)]));
    bytes += message.records().rbegin()->size();
  }
  if (next < total) return message;
  message.set_causal(poses.causal);
  message.set_loops(ToJson(poses.loops).dump());
  for (const PastCorrection& correction : poses.corrections) AddCorrection(correction, message);
  return message;
}

Result<bool> AddOwnPosesFromWire(const wire::OwnPoses& message, OwnPoses& poses) {
  for (const std::string& record : message.records())
    if (!DecodeOwnPose(record, poses.frames.emplace_back()).ok()) return BadPoses();
  const int known = static_cast<int>(poses.frames.size());
  if (known > message.total() || (known < message.total() && message.records().empty()))
    return BadPoses();
  if (known < message.total()) return false;
  poses.causal = message.causal();
  if (Status status = TakeLoops(message, poses); !status.ok()) return status.error();
  poses.corrections.clear();
  if (Status status = AddCorrections(message, known, poses.corrections); !status.ok())
    return status.error();
  return true;
}

wire::OwnPoses OwnPosesByNow(const OwnPoseStore& store, const wire::OwnPosesRequest& known) {
  const auto at_least_0 = [](int number) { return static_cast<std::size_t>(std::max(number, 0)); };
  const OwnPoseGrowth growth =
      store.Since(at_least_0(known.from()), at_least_0(known.corrections()), kImagesAMessage,
                  kCorrectionsAMessage);
  wire::OwnPoses message;
  for (const OwnPoseReport& frame : growth.poses.frames) message.add_records(EncodeOwnPose(frame));
  const int told = known.from() + message.records_size();
  bool all = told == growth.images;
  for (const PastCorrection& correction : growth.poses.corrections) {
    // One belongs to an image: it is told after it.
    if (correction.image > told) break;
    AddCorrection(correction, message);
  }
  all = all && growth.poses.corrections.size() < kCorrectionsAMessage;
  message.set_total(growth.images);
  message.set_causal(true);
  message.set_loops(ToJson(growth.poses.loops).dump());
  message.set_finding(!growth.ended || !all);
  return message;
}

Result<bool> AddOwnPosesByNow(const wire::OwnPoses& message, int images, OwnPoses& poses) {
  for (const std::string& record : message.records())
    if (!DecodeOwnPose(record, poses.frames.emplace_back()).ok()) return BadPoses();
  Status status = AddCorrections(message, images + message.records_size(), poses.corrections);
  if (status.ok()) status = TakeLoops(message, poses);
  if (!status.ok()) return status.error();
  return message.finding();
}

std::unique_ptr<OwnPoseFeed> MakeRemoteOwnPoses(NodeClient& vio, std::size_t images,
                                                std::size_t corrections) {
  return std::make_unique<RemoteOwnPoses>(vio, images, corrections);
}

Result<std::shared_ptr<const OwnPoses>> AskForOwnPoses(NodeClient& vio,
                                                       const std::stop_token& stop) {
  auto poses = std::make_shared<OwnPoses>();
  while (true) {
    wire::Request request;
    request.mutable_own_poses()->set_from(static_cast<int>(poses->frames.size()));
    const Result<SharedReply> reply = vio.AskAndWait(std::move(request), stop);
    if (!reply.ok()) return reply.error();
    const Result<bool> complete = AddOwnPosesFromWire((*reply)->own_poses(), *poses);
    if (!complete.ok()) return complete.error();
    if (*complete) return std::shared_ptr<const OwnPoses>(std::move(poses));
  }
}

}  // namespace plumbline
