// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/imu_simulator.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/random_vector.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Numbers of the sources of chance, beside the walk's and the furniture's.
constexpr std::uint32_t kNoiseSource = 0x494d55, kTremorSource = 0x545245, kWrongSource = 0x57524f;

/// Of a steady hand that holds a phone: 8 to 12 Hz, 0.04 degrees and 0.15 mm.
struct Tremor {
  struct Wave {
    Vector3d turn_rad, move_m;
    double frequency_hz, phase;
  };
  std::array<Wave, 3> waves;

  Tremor(double strength, std::uint64_t seed) {
    Random random({.seed = seed, .object = kTremorSource});
    const auto direction = [&](double size) -> Vector3d {
      return size * strength * GaussianVector<3>(random).normalized();
    };
    for (Wave& wave : waves) {
      wave = {direction(0.04 * kRadPerDeg), direction(0.00015), random.Uniform(8, 12),
              random.Uniform(0, 2 * std::numbers::pi)};
    }
  }

  Isometry3d At(double t_s) const {
    Vector3d turn = Vector3d::Zero(), move = Vector3d::Zero();
    for (const Wave& wave : waves) {
      const double s = std::sin(2 * std::numbers::pi * wave.frequency_hz * t_s + wave.phase);
      turn += s * wave.turn_rad;
      move += s * wave.move_m;
    }
    Isometry3d result = Isometry3d::Identity();
    if (turn.norm() > 0)
      result.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    result.translation() = move;
    return result;
  }
};

Vector3d Normal(Random& random, double sigma) {
  const double x = random.Gaussian(), y = random.Gaussian(), z = random.Gaussian();
  return sigma * Vector3d(x, y, z);
}

std::string Row(std::int64_t stamp_ns, std::span<const double> values) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%lld.%09lld",
                static_cast<long long>(stamp_ns / 1'000'000'000),
                static_cast<long long>(stamp_ns % 1'000'000'000));
  std::string row = text.data();
  for (const double value : values) {
    std::snprintf(text.data(), text.size(), ",%.10g", value);
    row += text.data();
  }
  return row + "\n";
}

}  // namespace

Isometry3d SyntheticBodyFromCam() {
  Isometry3d body_from_cam = Isometry3d::Identity();
  body_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  body_from_cam.linear() =
      Eigen::AngleAxisd(0.03, Vector3d(1, -2, 1.5).normalized()) * body_from_cam.linear();
  body_from_cam.translation() << 0.031, -0.022, 0.014;
  return body_from_cam;
}

BodyPath PathOfBody(const Walk& walk, const ImuSimulation& options, std::uint64_t seed,
                    double seconds) {
  const Tremor tremor(options.tremor, seed);
  const Isometry3d cam_from_body = SyntheticBodyFromCam().inverse();
  return BodyPath(
      [&](double t_s) {
        return walk.RoomFromCam(TimeAfterRest(t_s, options.rest_s)) * cam_from_body *
               tremor.At(t_s);
      },
      seconds);
}

ImuTruth SimulateImu(const BodyPath& path, const Isometry3d& world_from_room,
                     std::span<const std::int64_t> image_stamps_ns, const ImuSimulation& options,
                     std::uint64_t seed) {
  ImuTruth truth;
  truth.calibration.rate_hz = options.rate_hz;
  const ImuCalibration& imu = truth.calibration;
  Random random({.seed = seed, .object = kNoiseSource});
  Vector3d gyro_bias = Normal(random, options.gyro_bias_std_rad_s);
  Vector3d accel_bias = Normal(random, options.accel_bias_std_m_s2);
  const double walk_step = options.noise / std::sqrt(options.rate_hz);
  const double white = options.noise * std::sqrt(options.rate_hz);
  // The room is built with z up.
  const Vector3d up_in_room(0, 0, imu.gravity_m_s2);
  const double end_s = static_cast<double>(image_stamps_ns.back()) * 1e-9 + 0.5;
  std::size_t image = 0;
  for (int k = 0; k / options.rate_hz <= end_s; ++k) {
    ImuSample sample;
    sample.stamp_ns = std::llround(k / options.rate_hz * 1e9);
    const double t_s = k / options.rate_hz - options.time_offset_s;  // on the camera's clock
    const Eigen::Matrix3d body_from_room = path.RoomFromBody(t_s).linear().transpose();
    sample.angular_velocity_rad_s = path.AngularVelocityInBody(t_s) + gyro_bias +
                                    Normal(random, white * imu.gyro_noise_density);
    sample.specific_force_m_s2 = body_from_room * (path.AccelerationInRoom(t_s) + up_in_room) +
                                 accel_bias + Normal(random, white * imu.accel_noise_density);
    truth.samples.push_back(sample);
    for (; image < image_stamps_ns.size() &&
           static_cast<double>(image_stamps_ns[image]) * 1e-9 <= t_s + 1 / options.rate_hz;
         ++image) {
      const double image_s = static_cast<double>(image_stamps_ns[image]) * 1e-9;
      truth.states.push_back({image_stamps_ns[image], world_from_room * path.RoomFromBody(image_s),
                              world_from_room.linear() * path.VelocityInRoom(image_s), gyro_bias,
                              accel_bias});
    }
    gyro_bias += Normal(random, walk_step * imu.gyro_bias_walk);
    accel_bias += Normal(random, walk_step * imu.accel_bias_walk);
  }
  return truth;
}

Camera StatedCamera(Camera camera, const ImuSimulation& options, std::uint64_t seed) {
  Random random({.seed = seed, .object = kWrongSource});
  const auto signs = [&] {
    const auto sign = [&] { return random.Uniform() < 0.5 ? -1.0 : 1.0; };
    const double x = sign(), y = sign(), z = sign();
    return Vector3d(x, y, z);
  };
  const Vector3d turn = options.wrong_rotation_rad * signs();
  Isometry3d stated = SyntheticBodyFromCam();
  if (turn.norm() > 0)
    stated.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * stated.linear();
  stated.translation() += options.wrong_translation_m * signs();
  camera.body_from_cam = stated;
  return camera;
}

Status WriteImuFiles(const std::filesystem::path& folder, const ImuTruth& truth) {
  std::string readings = "# t[s],wx,wy,wz[rad/s],ax,ay,az[m/s^2] (body)\n";
  for (const ImuSample& s : truth.samples) {
    const Vector3d &w = s.angular_velocity_rad_s, &a = s.specific_force_m_s2;
    readings += Row(s.stamp_ns, std::array{w.x(), w.y(), w.z(), a.x(), a.y(), a.z()});
  }
  std::string states =
      "# t[s, of the image],px,py,pz,qx,qy,qz,qw "
      "(world_from_body),vx,vy,vz,bgx,bgy,bgz,bax,bay,baz\n";
  for (const ReferenceState& s : truth.states) {
    const Vector3d p = s.world_from_body.translation(), &v = s.velocity_in_world;
    const Eigen::Quaterniond q(s.world_from_body.linear());
    const Vector3d &g = s.gyro_bias, &a = s.accel_bias;
    states += Row(s.stamp_ns, std::array{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w(), v.x(),
                                         v.y(), v.z(), g.x(), g.y(), g.z(), a.x(), a.y(), a.z()});
  }
  const ImuCalibration& imu = truth.calibration;
  Status status = WriteFileAtomically(folder / "imu.csv", readings);
  if (status.ok()) status = WriteFileAtomically(folder / "groundtruth.csv", states);
  if (status.ok())
    status = WriteJson(folder / "imu.json", {{"rate_hz", imu.rate_hz},
                                             {"gyro_noise_density", imu.gyro_noise_density},
                                             {"accel_noise_density", imu.accel_noise_density},
                                             {"gyro_bias_walk", imu.gyro_bias_walk},
                                             {"accel_bias_walk", imu.accel_bias_walk},
                                             {"time_offset_s", imu.time_offset_s},
                                             {"gravity_m_s2", imu.gravity_m_s2}});
  return status;
}

}  // namespace plumbline
