// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/imu_simulator.h"

#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/tracks_file.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/sequence_writer.h"
#include "engine/synthetic/walk.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

SyntheticOptions TracksOnly(const ImuSimulation& imu, double seconds) {
  SyntheticOptions options;
  options.seed = 3;
  options.rate_hz = 20;
  options.frames = static_cast<int>(seconds * options.rate_hz);
  options.width = 640;
  options.height = 480;
  options.imu = imu;
  options.tracks_only = true;
  return options;
}

TEST(BodyPath, ItsDerivativesAreThoseOfItsPoses) {
  const auto swing = [](double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = (Eigen::AngleAxisd(std::sin(1.3 * t), Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(0.4 * std::sin(2.1 * t), Vector3d::UnitX()))
                        .toRotationMatrix();
    pose.translation() << std::sin(0.7 * t), std::cos(1.1 * t), 0.2 * std::sin(3 * t);
    return pose;
  };
  const BodyPath path(swing, 2);
  constexpr double kStep = 1e-5;
  for (const double t : {-0.5, 0.0, 0.4321, 1.01, 1.9999}) {
    const Eigen::Isometry3d a = path.RoomFromBody(t - kStep), b = path.RoomFromBody(t),
                            c = path.RoomFromBody(t + kStep);
    EXPECT_LT((b.translation() - swing(t).translation()).norm(), 5e-5);
    EXPECT_LT((path.VelocityInRoom(t) - (c.translation() - a.translation()) / (2 * kStep)).norm(),
              1e-7);
    EXPECT_LT((path.AccelerationInRoom(t) -
               (path.VelocityInRoom(t + kStep) - path.VelocityInRoom(t - kStep)) / (2 * kStep))
                  .norm(),
              1e-3);  // the jerk jumps at knots
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.linear().transpose() * c.linear()));
    EXPECT_LT((path.AngularVelocityInBody(t) - turn.angle() * turn.axis() / (2 * kStep)).norm(),
              1e-7);
  }
}

TEST(BodyPath, ARestEndsSmoothly) {
  EXPECT_EQ(TimeAfterRest(1.5, 2), 0);
  EXPECT_DOUBLE_EQ(TimeAfterRest(7, 2), 4.5);
  EXPECT_NEAR(TimeAfterRest(3 + 1e-9, 2), TimeAfterRest(3 - 1e-9, 2), 1e-8);
  EXPECT_EQ(TimeAfterRest(-0.5, 0), -0.5);
}

/// Dead reckoning by the trapezoidal rule, written for this test alone: attitude as a quaternion,
/// gravity along -z.
void ReckonAndCompare(const fs::path& folder, double true_offset_s, double seconds) {
  const auto sequence = OpenSequence(folder);
  const auto states = ReadReferenceStates(folder / "groundtruth.csv");
  ASSERT_TRUE(sequence.ok() && states.ok());
  const auto imu = (*sequence)->ReadImu();
  ASSERT_TRUE(imu.ok());
  const ReferenceState& start = states->states.front();
  const auto imu_ns = [&](std::int64_t stamp) { return stamp + std::llround(true_offset_s * 1e9); };
  std::size_t k = 0;
  while (imu->samples[k].stamp_ns < imu_ns(start.stamp_ns)) ++k;
  ASSERT_EQ(imu->samples[k].stamp_ns, imu_ns(start.stamp_ns));
  Eigen::Quaterniond attitude(start.world_from_body.linear());
  Vector3d position = start.world_from_body.translation(), velocity = start.velocity_in_world;
  int compared = 0;
  for (std::size_t i = 1; i < states->states.size(); ++i) {
    const ReferenceState& truth = states->states[i];
    if (truth.stamp_ns > seconds * 1e9) break;
    for (; imu->samples[k].stamp_ns < imu_ns(truth.stamp_ns); ++k) {
      const ImuSample &a = imu->samples[k], &b = imu->samples[k + 1];
      const double dt = static_cast<double>(b.stamp_ns - a.stamp_ns) * 1e-9;
      const Vector3d turn = (a.angular_velocity_rad_s + b.angular_velocity_rad_s) * dt / 2;
      const Vector3d before = attitude * a.specific_force_m_s2 + Vector3d(0, 0, -9.81);
      attitude = attitude * Eigen::Quaterniond(Eigen::AngleAxisd(
                                turn.norm(), turn.norm() > 0 ? turn.normalized() : turn));
      const Vector3d after = attitude * b.specific_force_m_s2 + Vector3d(0, 0, -9.81);
      position += velocity * dt + (2 * before + after) * dt * dt / 6;
      velocity += (before + after) * dt / 2;
    }
    ASSERT_EQ(imu->samples[k].stamp_ns, imu_ns(truth.stamp_ns));
    ++compared;
    const double t_s = static_cast<double>(truth.stamp_ns) * 1e-9;
    EXPECT_LT((position - truth.world_from_body.translation()).norm(), 2e-4 * (1 + t_s)) << t_s;
    EXPECT_LT(attitude.angularDistance(Eigen::Quaterniond(truth.world_from_body.linear())),
              1e-5 * (1 + t_s))
        << t_s;
    EXPECT_LT((velocity - truth.velocity_in_world).norm(), 1e-3) << t_s;
  }
  EXPECT_GT(compared, 150);
}

TEST(ImuSimulator, WithoutNoiseItsReadingsLeadAlongTheTruePoses) {
  const TemporaryFolder folder;
  ImuSimulation imu;
  imu.noise = imu.gyro_bias_std_rad_s = imu.accel_bias_std_m_s2 = 0;
  imu.rest_s = 1;
  imu.tremor = 1;
  imu.rate_hz = 1000;  // trapezoids follow a tremor of 12 Hz to 0.1 %
  imu.time_offset_s = 0.01;
  ASSERT_TRUE(WriteSyntheticSequence(TracksOnly(imu, 10), folder.path(), {}).ok());
  ReckonAndCompare(folder.path(), imu.time_offset_s, 10);
}

/// How far the pixels of long tracks are from where their point would be seen, root mean square of
/// each axis [px]: the point in which the rays from the given poses meet.
double OffOnePoint(
    const fs::path& folder,
    const std::function<Eigen::Isometry3d(std::int64_t stamp_ns, double row_px)>& world_from_cam) {
  const auto sequence = OpenSequence(folder);
  const auto tracks = ReadTracksFile(folder / "tracks.csv");
  EXPECT_TRUE(sequence.ok() && tracks.ok());
  if (!sequence.ok() || !tracks.ok()) return -1;
  EXPECT_FALSE((*sequence)->has_images());
  const PinholeCamera& camera = (*sequence)->camera();
  struct Sight {
    Eigen::Isometry3d world_from_cam;
    Eigen::Vector2d pixel;
  };
  std::map<std::int64_t, std::vector<Sight>> sights;
  for (const TrackedImage& image : tracks->images) {
    EXPECT_GT(image.points.size(), 60u);
    for (const TrackedPoint& point : image.points)
      sights[point.id].push_back({world_from_cam(image.stamp_ns, point.pixel.y()), point.pixel});
  }
  double sum = 0;
  int count = 0;
  for (const auto& [id, seen] : sights) {
    if (seen.size() < 40) continue;
    Eigen::Matrix3d across = Eigen::Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (const Sight& sight : seen) {
      const Vector3d ray =
          sight.world_from_cam.linear() * camera.Bearing(sight.pixel).homogeneous().normalized();
      const Eigen::Matrix3d off_ray = Eigen::Matrix3d::Identity() - ray * ray.transpose();
      across += off_ray;
      right += off_ray * sight.world_from_cam.translation();
    }
    const Vector3d point = across.ldlt().solve(right);
    for (const Sight& sight : seen) {
      sum += (camera.Project(sight.world_from_cam.inverse() * point) - sight.pixel).squaredNorm();
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  return std::sqrt(sum / (2 * count));
}

TEST(ImuSimulator, TracksArePixelsOfOnePointFromTheTruePoses) {
  const TemporaryFolder folder;
  ImuSimulation imu;
  imu.wrong_translation_m = 0.02;
  ASSERT_TRUE(WriteSyntheticSequence(TracksOnly(imu, 3), folder.path(), {}).ok());
  const auto sequence = OpenSequence(folder.path());
  ASSERT_TRUE(sequence.ok());
  const Camera& stated = (*sequence)->calibration().cameras.front().camera;
  EXPECT_EQ(stated.rolling_shutter_s, 0);
  const Vector3d off = stated.body_from_cam->translation() - SyntheticBodyFromCam().translation();
  EXPECT_NEAR(off.cwiseAbs().minCoeff(), 0.02, 1e-9);
  EXPECT_NEAR(off.cwiseAbs().maxCoeff(), 0.02, 1e-9);
  int frame = -1;
  std::int64_t last_ns = -1;
  const double rms = OffOnePoint(folder.path(), [&](std::int64_t stamp_ns, double) {
    if (stamp_ns != last_ns) ++frame;
    last_ns = stamp_ns;
    return *(*sequence)->world_from_cam(frame);
  });
  EXPECT_NEAR(rms, 1, 0.1);  // noise of 1 px on each axis
}

TEST(ImuSimulator, TracksOfARollingShutterAreSeenAtTheTimesOfTheirRows) {
  const TemporaryFolder folder;
  ImuSimulation imu;
  imu.tremor = 3;
  SyntheticOptions options = TracksOnly(imu, 3);
  options.rolling_shutter_s = 0.2;  // of less, a smooth walk hides most in where the points are
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path(), {}).ok());
  const auto sequence = OpenSequence(folder.path());
  ASSERT_TRUE(sequence.ok());
  EXPECT_EQ((*sequence)->calibration().cameras.front().camera.rolling_shutter_s, 0.2);
  const Room room = FurnishRoom(options).value();
  const Walk walk = Walk::Plan(room, options.seed, options.rate_hz).value();
  const BodyPath path = PathOfBody(walk, imu, options.seed, options.frames / options.rate_hz);
  const auto pose_at = [&](double t_s) { return path.RoomFromBody(t_s) * SyntheticBodyFromCam(); };
  EXPECT_LT(((*sequence)->world_from_cam(7)->translation() - pose_at(0.35).translation()).norm(),
            1e-8);  // the trajectory is of the middle rows
  const double by_rows = OffOnePoint(folder.path(), [&](std::int64_t stamp_ns, double row_px) {
    return pose_at(static_cast<double>(stamp_ns) * 1e-9 + 0.2 * (row_px / 479 - 0.5));
  });
  const double by_middle = OffOnePoint(folder.path(), [&](std::int64_t stamp_ns, double) {
    return pose_at(static_cast<double>(stamp_ns) * 1e-9);
  });
  EXPECT_NEAR(by_rows, 1, 0.1);
  EXPECT_GT(by_middle, 1.3);
}

TEST(ImuSimulator, AnImuThatIsGivenUpLeavesNoFiles) {
  const TemporaryFolder folder;
  SyntheticOptions options = TracksOnly({}, 1);
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path(), {}).ok());
  EXPECT_TRUE(fs::exists(folder.path() / "imu.csv"));
  options.imu.reset();
  EXPECT_FALSE(WriteSyntheticSequence(options, folder.path(), {}).ok());  // tracks need an IMU
  options.tracks_only = false;
  options.frames = 1;
  options.width = 160;
  options.height = 100;
  options.light_rays = 4;
  options.light_spacing = 20;
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path(), {}).ok());
  for (const char* name : {"imu.csv", "imu.json", "groundtruth.csv", "tracks.csv"})
    EXPECT_FALSE(fs::exists(folder.path() / name)) << name;
}

}  // namespace
}  // namespace plumbline
