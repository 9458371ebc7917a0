// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/own_pose_message.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"
#include "engine/recording/frame_codec.h"
#include "engine/transport/wire_values.h"

namespace plumbline {
namespace {

constexpr int kReadingsAMessage = 100'000;               // 5.6 MB
constexpr std::size_t kRecordBytesAMessage = 4'000'000;  // a record more may be added to them

Error BadImu(const std::string& what) {
  return {ErrorCode::kCorrupt,
          "the player sent " + what + " of an IMU that is none; is it another program's?"};
}

Error BadPoses() {
  return {ErrorCode::kCorrupt,
          "the poses that a node found cannot be read; is it of another version?"};
}

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
    const ImuSample& sample = imu.samples[static_cast<std::size_t>(i)];
    message.add_stamps_ns(sample.stamp_ns);
    for (const double rate : sample.angular_velocity_rad_s) message.add_readings(rate);
    for (const double force : sample.specific_force_m_s2) message.add_readings(force);
  }
  return message;
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
  for (const PastCorrection& correction : poses.corrections) {
    wire::PastCorrection& row = *message.add_corrections();
    row.set_image(correction.image);
    row.set_epoch(correction.epoch);
    row.set_poses(EncodePoses(correction.world_from_cam));
  }
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
  try {
    poses.loops = LoopReportFromJson(ParseJson(message.loops()));
  } catch (const std::exception&) {
    return BadPoses();
  }
  poses.corrections.clear();
  for (const wire::PastCorrection& row : message.corrections()) {
    PastCorrection correction{row.image(), row.epoch(), {}};
    if (!DecodePoses(row.poses(), correction.world_from_cam).ok() || row.image() > known ||
        static_cast<int>(correction.world_from_cam.size()) != row.image() ||
        (!poses.corrections.empty() && row.epoch() <= poses.corrections.back().epoch))
      return BadPoses();
    poses.corrections.push_back(std::move(correction));
  }
  return true;
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
