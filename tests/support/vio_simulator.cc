// SPDX-License-Identifier: Apache-2.0
#include "tests/support/vio_simulator.h"

#include <cmath>
#include <map>
#include <optional>

#include "engine/base/random.h"
#include "engine/geometry/random_vector.h"
#include "engine/sensor/distorted_camera.h"

namespace plumbline {
namespace {

constexpr double kStep = 1e-4;  ///< Of numerical derivatives [s].
constexpr double kRamp = 1;     ///< From rest to full motion [s].

std::int64_t ToNs(double seconds) { return std::llround(seconds * 1e9); }

class Path {
 public:
  explicit Path(const VioSimulation& options) : options_(options) {}

  Eigen::Isometry3d At(double t) const {
    const double u = Warped(t);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (Eigen::AngleAxisd(0.9 * std::sin(0.5 * u), Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(0.3 * std::sin(0.9 * u + 0.4), Eigen::Vector3d::UnitY()) *
                     Eigen::AngleAxisd(0.35 * std::sin(0.7 * u), Eigen::Vector3d::UnitX()))
                        .toRotationMatrix();
    if (options_.moves) {
      pose.translation() << 1.5 * std::sin(0.6 * u), 1.2 * std::sin(0.8 * u + 0.5),
          1.5 + 0.4 * std::sin(1.1 * u);
    } else {
      pose.translation() << 0, 0, 1.5;
    }
    return pose;
  }
  Eigen::Vector3d Velocity(double t) const {
    return (At(t + kStep).translation() - At(t - kStep).translation()) / (2 * kStep);
  }
  Eigen::Vector3d Acceleration(double t) const {
    return (At(t + kStep).translation() + At(t - kStep).translation() - 2 * At(t).translation()) /
           (kStep * kStep);
  }
  Eigen::Vector3d AngularVelocity(double t) const {
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(At(t - kStep).linear().transpose() * At(t + kStep).linear()));
    return turn.angle() * turn.axis() / (2 * kStep);
  }

 private:
  /// Time of motion: rests, then speeds up.
  double Warped(double t) const {
    if (options_.rest_s <= 0) return t;
    const double u = t - options_.rest_s;
    return u <= 0 ? 0 : u < kRamp ? u * u / (2 * kRamp) : u - kRamp / 2;
  }
  VioSimulation options_;
};

Eigen::Vector3d Noise(Random& random, double sigma) { return sigma * GaussianVector<3>(random); }

Camera SimulatedCamera(double arm) {
  Camera camera;
  camera.model = CameraModel::kRadialTangential;
  camera.pinhole = {640, 480, 400, 398, 322, 238};
  camera.distortion = {-0.28, 0.07, 2e-4, 2e-5};
  camera.rate_hz = 20;
  Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();  // looks along the body's x
  body_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  body_from_cam.linear() =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized()) * body_from_cam.linear();
  body_from_cam.translation() = arm * Eigen::Vector3d(0.05, -0.03, 0.02);
  camera.body_from_cam = body_from_cam;
  return camera;
}

/// Where the camera sees a point, each row at its own time.
std::optional<Eigen::Vector2d> See(const DistortedCamera& lens, const Camera& camera,
                                   const Path& path, double imu_t, const Eigen::Vector3d& point) {
  double delay = 0;
  for (int round = 0;; ++round) {
    const auto view =
        lens.Project((path.At(imu_t + delay) * *camera.body_from_cam).inverse() * point);
    if (!view) return std::nullopt;
    if (camera.rolling_shutter_s == 0 || round == 4) return view->pixel;
    delay = camera.RowDelay(view->pixel.y());
  }
}

/// Points on the walls, the floor and the ceiling.
std::vector<Eigen::Vector3d> RoomPoints(const VioSimulation& options) {
  Random random({options.seed, 1});
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < options.room_points; ++i) {
    const double z = random.Uniform(0, 4), y = random.Uniform(-4, 4), x = random.Uniform(-4, 4);
    Eigen::Vector3d p(x, y, z);
    const std::uint32_t wall = random.Index(6);
    p[static_cast<int>(wall / 2)] = wall % 2 == 0 ? -4 : 4;
    if (wall / 2 == 2) p.z() = wall % 2 == 0 ? 0 : 4;
    points.push_back(p);
  }
  return points;
}

void SimulateImages(const VioSimulation& options, const Path& path, SimulatedRecording& result) {
  const DistortedCamera camera(result.camera);
  const std::vector<Eigen::Vector3d> points = RoomPoints(options);
  Random random({options.seed, 2});
  std::map<std::size_t, std::int64_t> followed;
  std::int64_t next_id = 0;
  for (int k = 0; k < options.seconds * options.image_hz; ++k) {
    const double t = k / options.image_hz, imu_t = t + options.time_offset_s;
    std::map<std::size_t, Eigen::Vector2d> seen;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = See(camera, result.camera, path, imu_t, points[i]);
      if (pixel && pixel->x() > 0 && pixel->x() < 639 && pixel->y() > 0 && pixel->y() < 479)
        seen[i] = *pixel;
    }
    std::erase_if(followed, [&](const auto& entry) { return seen.count(entry.first) == 0; });
    for (const auto& [i, pixel] : seen) {
      if (options.follow_all) {
        followed[i] = static_cast<std::int64_t>(i);
        continue;
      }
      if (static_cast<int>(followed.size()) >= options.points) break;
      if (followed.count(i) == 0) followed[i] = next_id++;
    }
    TrackedImage image;
    image.stamp_ns = ToNs(t);
    for (const auto& [i, id] : followed) {
      Eigen::Vector2d pixel = seen[i];
      if (t > options.sliding_from_s && static_cast<double>(i % 100) < 100 * options.sliding_share)
        pixel.x() += options.sliding_px * options.image_hz * (t - options.sliding_from_s);
      image.points.push_back({id, pixel + options.pixel_noise_px * GaussianVector<2>(random)});
    }
    result.images.push_back(image);
    result.truth.push_back({image.stamp_ns, path.At(imu_t), path.Velocity(imu_t), options.gyro_bias,
                            options.accel_bias});
  }
}

}  // namespace

SimulatedRecording Simulate(const VioSimulation& options) {
  SimulatedRecording result;
  result.camera = SimulatedCamera(options.arm);
  result.camera.rolling_shutter_s = options.rolling_shutter_s;
  result.imu.rate_hz = options.imu_hz;
  const Path path(options);
  Random random({options.seed, 3});
  const double rate = std::sqrt(options.imu_hz) * options.imu_noise;
  for (int k = 0; k < (options.seconds + 0.5) * options.imu_hz; ++k) {
    const double t = k / options.imu_hz - 0.1;
    ImuSample sample;
    sample.stamp_ns = ToNs(t);
    sample.angular_velocity_rad_s = path.AngularVelocity(t) + options.gyro_bias +
                                    Noise(random, rate * result.imu.gyro_noise_density);
    sample.specific_force_m_s2 =
        path.At(t).linear().transpose() *
            (path.Acceleration(t) + Eigen::Vector3d(0, 0, result.imu.gravity_m_s2)) +
        options.accel_bias + Noise(random, rate * result.imu.accel_noise_density);
    result.samples.push_back(sample);
  }
  SimulateImages(options, path, result);
  return result;
}

}  // namespace plumbline
