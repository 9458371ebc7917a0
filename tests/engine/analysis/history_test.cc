// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/history.h"

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
  EXPECT_GT(ErrorOf(object, room)->credible_level, 0.999);
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
