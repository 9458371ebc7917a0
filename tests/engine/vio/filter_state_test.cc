// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/filter_state.h"

#include <gtest/gtest.h>

#include "engine/sensor/pose_estimate.h"
#include "engine/vio/rotation.h"
#include "engine/vio/start_state.h"
#include "engine/vio/track_rows.h"

namespace plumbline {
namespace {

FilterState StartedState() {
  InertialState inertial;
  inertial.world_from_body = RotationExp({0.2, -0.1, 0.7});
  inertial.velocity_in_world << 0.5, 0.8, -0.1;
  inertial.position_in_world << 2, -1, 1.5;
  Camera camera;
  camera.pinhole = {640, 480, 400, 400, 320, 240};
  camera.body_from_cam = Eigen::Translation3d(0.03, 0.01, -0.02) * Eigen::Isometry3d::Identity();
  StartSpread spread;
  spread.yaw_rad = 0.1;
  spread.position_m = 0.5;
  return MakeStart(inertial, camera, 0, spread, {});
}

TEST(FilterState, AStartSpeaksOfThePlainErrorsThatWereGiven) {
  const auto covariance = StartedState().PoseCovariance(1);
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.5, 1e-9);
  EXPECT_NEAR(std::sqrt(covariance(5, 5)), 0.1, 1e-9);
  EXPECT_NEAR(covariance(0, 5), 0, 1e-9);
}

TEST(FilterState, ACloneIsThePoseOfNowAndIsLaterWhereTheOffsetIsLarger) {
  FilterState state = StartedState();
  const Eigen::Vector3d turn(0.3, -0.6, 0.9);
  const int before = state.size();
  const PoseClone& clone = state.AddClone(0, turn, 0, 0, 0);
  EXPECT_EQ(clone.row, before);
  // d pose / d offset = cov(clone, offset) / var(offset)
  const double variance = state.covariance()(kTimeOffset, kTimeOffset);
  const Eigen::Matrix<double, 6, 1> slope =
      state.covariance().block<6, 1>(before, kTimeOffset) / variance;
  constexpr double kStep = 1e-6;
  const ImuSegment segment{0, 1000, turn, {0, 0, 9.81}, 1};
  const InertialState later = Integrate(state.inertial(), std::span(&segment, 1), {}).state;
  const Eigen::Isometry3d moved = Moved(clone.world_from_body, slope * kStep);
  EXPECT_LT((moved.linear() - later.world_from_body).norm(), 1e-9);
  EXPECT_LT((moved.translation() - later.position_in_world).norm(), 1e-10);  // half g step^2
}

TEST(FilterState, AnUpdateIsThatOfTheTextbookAndRemovingRowsIsMarginalisation) {
  FilterState state = StartedState();
  state.AddClone(0, {0, 0, 0}, 0, 0, 0);
  const int first = state.clones()[0].row;
  state.AddClone(1, {0, 0, 0}, 0, 1e-3, 0);
  const Eigen::MatrixXd P = state.covariance();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, 6);
  H << 1, 2, 0, -1, 0.5, 0, 0, 1, 3, 0, 0, 2;
  const RowRange rows[] = {{first, 6}};
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(2, P.cols());
  whole.middleCols(first, 6) = H;
  const Eigen::MatrixXd S = whole * P * whole.transpose() + Eigen::MatrixXd::Identity(2, 2);
  const Eigen::MatrixXd expected = P - P * whole.transpose() * S.inverse() * whole * P;
  ASSERT_TRUE(state.Update(H, rows, Eigen::Vector2d::Zero(), NoiseOf::kImages));
  EXPECT_LT((state.covariance() - expected).norm(), 1e-10);
  state.RemoveClone(0);
  EXPECT_EQ(state.size(), P.rows() - 6);
  EXPECT_LT((state.covariance().bottomRightCorner(6, 6) - expected.bottomRightCorner(6, 6)).norm(),
            1e-10);
}

TEST(FilterState, ErrorsOfImagesAreToldAsManyTimesAndThoseOfTheStartAndOfRestOnce) {
  constexpr double kInflation = 9;
  FilterState state = StartedState();
  const CalibratedMatrix start = state.covariance();
  EXPECT_TRUE(state.InflatedCovariance(kInflation).isApprox(start)) << "no image was seen yet";

  // Joseph's form, which holds for any gain, of measurements that err by three of what the gain
  // takes them to; then of one that errs by what it says.
  Eigen::MatrixXd truth = start;
  const auto expect = [&](const Eigen::MatrixXd& whole, double noise_variance) {
    const Eigen::MatrixXd P = state.covariance();
    const Eigen::MatrixXd S = whole * P * whole.transpose() + Eigen::MatrixXd::Identity(2, 2);
    const Eigen::MatrixXd K = P * whole.transpose() * S.inverse();
    const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(P.rows(), P.rows()) - K * whole;
    truth = left * truth * left.transpose() + noise_variance * K * K.transpose();
  };
  Eigen::MatrixXd H(2, 6);
  H << 40, 20, 0, -10, 5, 0, 0, 10, 30, 0, 0, 20;
  const RowRange rows[] = {{kPhi, 6}};
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(2, kCalibratedSize);
  whole.middleCols(kPhi, 6) = H;
  for (const NoiseOf noise : {NoiseOf::kImages, NoiseOf::kRest, NoiseOf::kImages}) {
    expect(whole, noise == NoiseOf::kImages ? kInflation : 1);
    ASSERT_TRUE(state.Update(H, rows, Eigen::Vector2d::Zero(), noise));
    EXPECT_LT((state.InflatedCovariance(kInflation) - truth).norm(), 1e-9 * truth.norm());
    const ImuSegment segment{0, 100'000'000, {0.1, 0.2, 0}, {0, 0, 9.8}, 1};
    IntegrationNoise shaking;
    shaking.accel_density = 0.01;
    const Integration moved = Integrate(state.inertial(), std::span(&segment, 1), shaking);
    Eigen::MatrixXd transition = Eigen::MatrixXd::Identity(kCalibratedSize, kCalibratedSize);
    transition.topLeftCorner<kInertialSize, kInertialSize>() = moved.transition;
    truth = transition * truth * transition.transpose();
    truth.topLeftCorner<kInertialSize, kInertialSize>() += moved.noise;
    state.Propagate(moved);
    EXPECT_LT((state.InflatedCovariance(kInflation) - truth).norm(), 1e-9 * truth.norm());
  }
  EXPECT_GT(state.InflatedCovariance(kInflation)(kPhi, kPhi), state.covariance()(kPhi, kPhi));
  EXPECT_TRUE(state.InflatedCovariance(1).isApprox(state.covariance()));
}

TEST(FilterState, WhatAPoseAndAPointOfImagesErrByGrowsWithThem) {
  FilterState state = StartedState();
  state.AddClone(0, {0, 0, 0}, 0, 1e-3, 2e-3);
  const int clone = state.clones()[0].row;
  EXPECT_NEAR(state.covariance_by_images()(clone, clone), 1e-6, 1e-15);
  EXPECT_NEAR(state.covariance_by_images()(kPhi, kPhi), 0, 1e-15) << "of the clone alone";
  StatePoint point;
  const RowRange rows[] = {{clone, 6}};
  const Eigen::Matrix3d by_point = 100 * Eigen::Matrix3d::Identity();
  state.AddPoint(point, Eigen::MatrixXd::Zero(3, 6), rows, by_point, Eigen::Vector3d::Zero());
  const int row = state.points()[0].row;
  EXPECT_NEAR(state.covariance_by_images()(row, row), 1e-4, 1e-12);
  state.Creep({row, 2}, 3e-4);
  EXPECT_NEAR(state.covariance_by_images()(row, row), 4e-4, 1e-12);
  state.RemoveClone(0);
  EXPECT_EQ(state.covariance_by_images().rows(), state.size());
  EXPECT_NEAR(state.covariance_by_images()(state.points()[0].row, state.points()[0].row), 4e-4,
              1e-12);
}

TEST(FilterState, TheCovarianceOfAPoseIsOfTheErrorThatFilesState) {
  // An error drawn in the filter's chart, read in that of PosePerturbation.
  const FilterState state = StartedState();
  Eigen::Matrix<double, 6, 1> error;
  error << 1e-5, -2e-5, 3e-5, 2e-5, 1e-5, -1e-5;
  const Eigen::Isometry3d pose = state.inertial().pose();
  const PosePerturbation plain = PerturbationBetween(pose, Moved(pose, error));
  const Eigen::Vector3d expected =
      error.tail<3>() + error.head<3>().cross(state.inertial().position_in_world);
  EXPECT_LT((plain.head<3>() - expected).norm(), 1e-8);  // the square of the error, times 2 m
  EXPECT_LT((plain.tail<3>() - error.head<3>()).norm(), 1e-12);
}

TEST(TrackRows, WhatIsLeftOfATrackDoesNotSpeakOfItsPointNorOfTheGauge) {
  Camera described;
  described.pinhole = {640, 480, 400, 400, 320, 240};
  const DistortedCamera camera(described);
  FilterState state = StartedState();
  std::vector<Observation> sights;
  const Eigen::Vector3d point =
      state.inertial().pose() * (state.body_from_cam() * Eigen::Vector3d(0.3, -0.2, 3));
  for (int k = 0; k < 5; ++k) {
    state.AddClone(k, {0, 0, 0}, 0, 0, 0);
    const ImuSegment segment{k * 100'000'000, (k + 1) * 100'000'000, {0.1, 0.2, 0}, {0, 0, 9.8}, 1};
    state.Propagate(Integrate(state.inertial(), std::span(&segment, 1), {}));
    sights.push_back({k, {320, 240}, {0, 0, 1}});
  }
  const ColumnLayout layout(state, false);
  const auto rows =
      RowsOfTrack(camera, state, layout, sights, std::vector<bool>(5, true), point, PixelModel());
  ASSERT_TRUE(rows.has_value());
  const SplitRows split = SplitOffPoint(*rows);
  EXPECT_EQ(split.residual.size(), 7);
  Eigen::MatrixXd gauge = Eigen::MatrixXd::Zero(layout.size(), 4);
  for (int k = 0; k < 5; ++k) {
    gauge(layout.clone(k) + 2, 0) = 1;  // turn about z
    gauge.block<3, 3>(layout.clone(k) + 3, 1).setIdentity();
  }
  EXPECT_LT((split.by_state * gauge).norm(), 1e-9 * split.by_state.norm());
  Eigen::MatrixXd jacobian = split.by_state;
  Eigen::VectorXd residual = split.residual;
  Compress(jacobian, residual);
  EXPECT_LT((jacobian.transpose() * residual - split.by_state.transpose() * split.residual).norm(),
            1e-8 * split.residual.norm() * split.by_state.norm());
}

TEST(TrackRows, APatchThatCreepsIsARandomWalkOnTopOfTheNoise) {
  Camera described;
  described.pinhole = {640, 480, 400, 400, 320, 240};
  const DistortedCamera camera(described);
  FilterState state = StartedState();
  std::vector<Observation> sights;
  const Eigen::Vector3d point =
      state.inertial().pose() * (state.body_from_cam() * Eigen::Vector3d(0.3, -0.2, 3));
  for (int k = 0; k < 4; ++k) {
    state.AddClone(k, {0, 0, 0}, 0, 0, 0);
    sights.push_back({k, {320 + 3.0 * k, 240 - 2.0 * k * k}, {0, 0, 1}});
  }
  const ColumnLayout layout(state, false);
  PixelModel pixels;
  pixels.noise_px = 2;
  const std::vector<bool> all(4, true);
  const auto plain = RowsOfTrack(camera, state, layout, sights, all, point, pixels);
  pixels.creep_px = 0.5;
  const auto white = RowsOfTrack(camera, state, layout, sights, all, point, pixels);
  ASSERT_TRUE(plain && white);
  // r' C^-1 r of the pixels themselves: 4 px^2 of each sight, 0.25 px^2 more with each step.
  Eigen::Matrix4d covariance;
  covariance << 4, 0, 0, 0, 0, 4.25, 0.25, 0.25, 0, 0.25, 4.5, 0.5, 0, 0.25, 0.5, 4.75;
  double expected = 0;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Vector4d r;
    for (int k = 0; k < 4; ++k) r[k] = 2 * plain->residual[2 * k + axis];
    expected += r.dot(covariance.inverse() * r);
  }
  EXPECT_NEAR(white->residual.squaredNorm(), expected, 1e-9 * expected);
}

}  // namespace
}  // namespace plumbline
