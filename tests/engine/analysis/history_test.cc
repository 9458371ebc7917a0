// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/history.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "engine/geometry/angles.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

Eigen::Isometry3d At(double x, double azimuth_deg) {
  Eigen::Isometry3d pose(
      Eigen::AngleAxisd(azimuth_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  pose.translation() = Eigen::Vector3d(x, 0, 0);
  return pose;
}

/// A chair, a table that looks the same from behind, and a round table.
SequenceView Room() {
  SequenceView view;
  view.models = {{"chair", "chair"}, {"desk", "dining table"}, {"round", "dining table"}};
  view.models[1].symmetry_order = 2;
  view.models[2].any_azimuth = true;
  view.truth = {{"c", "chair", At(0, 10)}, {"d", "desk", At(2, 0)}, {"r", "round", At(5, 0)}};
  return view;
}

ObjectReport Object(const char* category, int label, const Eigen::Isometry3d& pose) {
  ObjectReport object;
  object.category = category;
  object.label = {label};
  object.world_from_object = pose;
  return object;
}

/// Of an object that is alone in its frame.
std::optional<TruthError> ErrorOf(ObjectReport object, const SequenceView& view) {
  FrameReport report;
  report.objects = {std::move(object)};
  return ErrorsOf(report, view).front();
}

TEST(TruthError, IsThatOfTheNearestTrueObjectOfTheCategory) {
  const auto error = ErrorOf(Object("chair", 0, At(0.12, 30)), Room());
  ASSERT_TRUE(error);
  EXPECT_EQ(error->truth, "c");
  EXPECT_TRUE(error->model_correct);
  EXPECT_NEAR(error->translation_m, 0.12, 1e-6);
  EXPECT_NEAR(error->azimuth_rad, 20 * kRadPerDeg, 1e-6);
}

TEST(TruthError, CountsAzimuthModuloTheSymmetry) {
  EXPECT_NEAR(ErrorOf(Object("dining table", 1, At(2, 175)), Room())->azimuth_rad, 5 * kRadPerDeg,
              1e-6);
  EXPECT_EQ(ErrorOf(Object("dining table", 2, At(5, 77)), Room())->azimuth_rad, 0);
}

TEST(TruthError, TellsAWrongShape) {
  EXPECT_FALSE(ErrorOf(Object("dining table", 2, At(2, 0)), Room())->model_correct);
}

TEST(TruthError, TellsWhereTheTruthLiesInTheBelief) {
  SequenceView room = Room();
  ObjectReport object = Object("chair", 0, At(0, 10));
  object.covariance.diagonal() = Eigen::Vector4d(0.01, 0.01, 0.01, 0.01);
  EXPECT_NEAR(ErrorOf(object, room)->credible_level, 0, 1e-6);
  object.world_from_object = At(0.15, 20);
  const float near = ErrorOf(object, room)->credible_level;
  object.world_from_object = At(0.3, 40);
  const float far = ErrorOf(object, room)->credible_level;
  EXPECT_GT(near, 0.2);
  EXPECT_LT(near, 0.95);
  EXPECT_GT(far, 0.99);
  // The belief is about the centre: the same turn moves a centre that is off the origin.
  room.models[0].center = Eigen::Vector3d(1, 0, 0);
  object.world_from_object = At(0, 40);
  EXPECT_GT(ErrorOf(object, room)->credible_level, 0.995);
}

TEST(TruthError, LooksForTheTruthInEveryMode) {
  const SequenceView room = Room();
  ObjectReport object = Object("chair", 0, At(0, 190));
  object.covariance.diagonal() = Eigen::Vector4d(0.01, 0.01, 0.01, 0.01);
  EXPECT_GT(ErrorOf(object, room)->credible_level, 0.999) << "it is believed to look the other way";
  object.modes = {{{0}, 0.7, object.world_from_object, 0.173, 0.1},
                  {{0}, 0.3, At(0, 10), 0.173, 0.1}};
  // Student's t of four degrees: the density falls with (1 + d / 2)^-4, so of the first mode
  // squared distances up to d = 2 (sqrt(sqrt(7 / 3)) - 1) are likelier, a share of y^2 (3 - 2 y) of
  // it.
  const TruthError error = *ErrorOf(object, room);
  const double d = 2 * (std::sqrt(std::sqrt(7 / 3.0)) - 1), y = d / (d + 2);
  EXPECT_NEAR(error.credible_level, 0.7 * y * y * (3 - 2 * y), 0.005);
  EXPECT_GT(error.nees, 900) << "of the pose that is reported: pi / .1, squared";
}

TEST(TruthError, KnowsHowWellTheTruthIsKnown) {
  SequenceView room = Room();
  ObjectReport object = Object("chair", 0, At(0.03, 10));
  EXPECT_GT(ErrorOf(object, room)->credible_level, 0.999) << "exact, and no spread claimed";
  room.truth[0].position_std_m = 0.03;
  room.truth[0].azimuth_std_rad = 0.02;
  // .03 m with .03 / sqrt(3) an axis: d2 = 3, with four degrees of freedom.
  EXPECT_NEAR(ErrorOf(object, room)->nees, 3, 1e-3);
  EXPECT_NEAR(ErrorOf(object, room)->credible_level, 1 - std::exp(-1.5) * 2.5, 0.01)
      << "the belief has no spread: what is left is how well the truth is known, a normal number";
}

TEST(TruthError, KnowsThatTheImageItRefersToMayBeElsewhere) {
  SequenceView room = Room();
  ObjectReport object = Object("chair", 0, At(0.03, 10));
  object.reference_frame = 1;
  object.world_from_reference_cam = At(-2, 0);
  room.aligned_pose_covariance.resize(2, Eigen::Matrix<double, 6, 6>::Zero());
  EXPECT_GT(ErrorOf(object, room)->nees, 1e6) << "the other frame's pose is exact";
  // A turn about up moves the object, 2 m away, sideways and turns it: not along x.
  room.aligned_pose_covariance[1](5, 5) = 0.02 * 0.02;
  EXPECT_GT(ErrorOf(object, room)->nees, 1e6);
  room.aligned_pose_covariance[1](0, 0) = 0.03 * 0.03;
  EXPECT_NEAR(ErrorOf(object, room)->nees, 1, 1e-3);
  object.world_from_object = At(0, 10 + 2 / kRadPerDeg * 0.02);
  object.world_from_object.translation().y() = 2 * 2 * 0.02;
  EXPECT_NEAR(ErrorOf(object, room)->nees, 4 + 0.0032 * 0.0032 / 9e-4, 1e-3)
      << "turned by two deviations, and moved; at y = 0.08 a turn also moves it by -0.0032 along x";
}

TEST(TruthError, KnowsWhetherTheShapeIsAQuestion) {
  EXPECT_FALSE(ErrorOf(Object("chair", 0, At(0, 0)), Room())->several_models);
  EXPECT_TRUE(ErrorOf(Object("dining table", 1, At(2, 0)), Room())->several_models);
}

TEST(TruthError, IsNothingFarFromAnyTruthOrForAnotherCategory) {
  EXPECT_FALSE(ErrorOf(Object("chair", 0, At(1.2, 0)), Room()));
  EXPECT_FALSE(ErrorOf(Object("lamp", 0, At(0, 0)), Room()));
}

TEST(Thumbnails, AreSpreadEvenlyAndFew) {
  for (const int size : {1, 63, 64, 65, 150, 10'000}) {
    int wanted = 0;
    for (int i = 0; i < size; ++i) wanted += WantsThumbnail(i, size);
    EXPECT_LE(wanted, kMaxThumbnails) << size;
    EXPECT_GE(wanted, std::min(size, kMaxThumbnails / 2)) << size;
  }
}

}  // namespace
}  // namespace plumbline
