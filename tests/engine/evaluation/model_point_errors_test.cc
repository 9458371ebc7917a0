// SPDX-License-Identifier: Apache-2.0
// The formulas of the BOP benchmark against closed forms.
#include "engine/evaluation/model_point_errors.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "engine/evaluation/bop_recall.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

/// Corners of a box of a x b x c about its middle.
ModelPoints Corners(double a, double b, double c) {
  ModelPoints points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back((i & 1) != 0 ? a / 2 : -a / 2, (i & 2) != 0 ? b / 2 : -b / 2,
                        (i & 4) != 0 ? c / 2 : -c / 2);
  }
  return points;
}

Eigen::Affine3d Posed(double x, double y, double z, double turn_deg = 0) {
  return Eigen::Affine3d(Eigen::Translation3d(x, y, z) *
                         Eigen::AngleAxisd(turn_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()));
}

TEST(ModelPointErrors, AreTheShiftOfAShiftedModel) {
  const ModelPoints points = Corners(1, 1, 1);
  const std::vector<Eigen::Isometry3d> turns = SymmetricTurns({});
  const Eigen::Affine3d truth = Posed(0.3, -2, 4), estimate = Posed(0.3 + 0.03, -2 + 0.04, 4);
  EXPECT_NEAR(AddError(estimate, truth, points), 0.05, 1e-12);
  EXPECT_NEAR(AddSError(estimate, truth, points), 0.05, 1e-6) << "neighbours as floats";
  EXPECT_NEAR(MssdError(estimate, truth, points, turns), 0.05, 1e-12);
}

TEST(ModelPointErrors, OfATurnAreItsChord) {
  // Corners are sqrt(1/2) from the axis: the chord of 90 degrees is 1.
  const ModelPoints points = Corners(1, 1, 0.5);
  EXPECT_NEAR(AddError(Posed(0, 0, 3, 90), Posed(0, 0, 3), points), 1, 1e-12);
  EXPECT_NEAR(AddSError(Posed(0, 0, 3, 90), Posed(0, 0, 3), points), 0, 1e-6) << "the corners swap";
  EXPECT_NEAR(MssdError(Posed(0, 0, 3, 90), Posed(0, 0, 3), points, SymmetricTurns({})), 1, 1e-12);
  const Symmetry four{Eigen::Vector3d::UnitZ(), 4};
  EXPECT_NEAR(MssdError(Posed(0, 0, 3, 90), Posed(0, 0, 3), points, SymmetricTurns(four)), 0,
              1e-12);
  EXPECT_NEAR(MssdError(Posed(0, 0, 3, 120), Posed(0, 0, 3), points, SymmetricTurns(four)),
              2 * std::sqrt(0.5) * std::sin(15 * kRadPerDeg), 1e-12)
      << "30 degrees are left";
}

TEST(ModelPointErrors, OfARoundModelMoveNoPointByMoreThanHalfAStep) {
  const std::vector<Eigen::Isometry3d> turns = SymmetricTurns({Eigen::Vector3d::UnitZ(), 0});
  EXPECT_EQ(turns.size(), 315u) << "ceil(pi / 0.01), as bop_toolkit samples";
  EXPECT_TRUE(turns[0].isApprox(Eigen::Isometry3d::Identity()));
  const ModelPoints points = Corners(1, 1, 1);
  const double largest = MssdError(Posed(0, 0, 0, 33.3), Posed(0, 0, 0), points, turns);
  EXPECT_LE(largest, 2 * std::sqrt(0.5) * std::sin(std::numbers::pi / 315 / 2) + 1e-12);
}

TEST(ModelPointErrors, TakeScalesIntoAccount) {
  // Corners of the unit cube are sqrt(3)/2 from its middle: 10 % more moves each by a tenth.
  const ModelPoints points = Corners(1, 1, 1);
  const Eigen::Affine3d larger = Posed(0, 0, 2) * Eigen::Scaling(1.1);
  EXPECT_NEAR(AddError(larger, Posed(0, 0, 2), points), 0.1 * std::sqrt(0.75), 1e-12);
  EXPECT_NEAR(MssdError(larger, Posed(0, 0, 2), points, SymmetricTurns({})), 0.1 * std::sqrt(0.75),
              1e-12);
}

TEST(ModelPointErrors, ProjectTheNearestPointsFurthest) {
  const PinholeCamera camera{640, 480, 500, 400, 320, 240};
  const ModelPoints points = Corners(1, 1, 1);
  // A shift of 2 cm: the near face, at 3.5 m, moves by f * shift / depth.
  EXPECT_NEAR(MspdError(Posed(0.02, 0, 4), Posed(0, 0, 4), camera, points, SymmetricTurns({})),
              500 * 0.02 / 3.5, 1e-9);
  EXPECT_NEAR(MspdError(Posed(0, 0.02, 4), Posed(0, 0, 4), camera, points, SymmetricTurns({})),
              400 * 0.02 / 3.5, 1e-9);
  EXPECT_EQ(MspdError(Posed(0, 0, 0.4), Posed(0, 0, 4), camera, points, SymmetricTurns({})),
            std::numeric_limits<double>::infinity())
      << "partly behind the camera";
}

/// A plane of `width` pixels from column `from` on, `depth_m` away.
cv::Mat Plane(int from, int width, float depth_m) {
  cv::Mat image = cv::Mat::zeros(10, 40, CV_32F);
  image.colRange(from, from + width) = depth_m;
  return image;
}

TEST(VsdErrors, CountPixelsThatAreNotInBoth) {
  // 10 columns each, 4 shared, equally far: 12 of 16 columns differ.
  const VsdImages images{Plane(6, 10, 2), Plane(0, 10, 2), Plane(0, 40, 2)};
  const std::vector<double> taus = {0.05, 0.5};
  for (const double error : VsdErrors(images, 1, taus)) EXPECT_NEAR(error, 12.0 / 16, 1e-12);
}

TEST(VsdErrors, CountPixelsThatAreTooFarOff) {
  const VsdImages images{Plane(0, 10, 2.1f), Plane(0, 10, 2), Plane(0, 40, 3)};
  const std::vector<double> taus = {0.05, 0.25};
  const std::vector<double> errors = VsdErrors(images, 0.5, taus);
  EXPECT_EQ(errors[0], 1) << "10 cm are a fifth of the diameter";
  EXPECT_EQ(errors[1], 0);
}

TEST(VsdErrors, LeaveOutWhatTheSceneHides) {
  // The left half of both lies behind something that is 1 m away.
  cv::Mat scene = Plane(0, 40, 2);
  scene.colRange(0, 5) = 1.0f;
  EXPECT_EQ(VsdErrors({Plane(0, 10, 2), Plane(0, 10, 2), scene}, 1, kBopShares)[0], 0);
  EXPECT_EQ(VisiblePixels(Plane(0, 10, 2), scene), 5 * 10);
  // Behind it everything: nothing shows, and that is an error of 1.
  scene.setTo(1.0f);
  EXPECT_EQ(VsdErrors({Plane(0, 10, 2), Plane(0, 10, 2), scene}, 1, kBopShares)[0], 1);
  // Where nothing was measured, things show.
  EXPECT_EQ(VisiblePixels(Plane(0, 10, 2), cv::Mat::zeros(10, 40, CV_32F)), 10 * 10);
  // Within 15 mm behind the scene still counts; 16 mm does not.
  EXPECT_EQ(VisiblePixels(Plane(0, 10, 2.0149f), Plane(0, 40, 2)), 100);
  EXPECT_EQ(VisiblePixels(Plane(0, 10, 2.016f), Plane(0, 40, 2)), 0);
}

TEST(VsdErrors, SeeTheEstimateWhereTheTruthShows) {
  // The estimate lies 10 cm behind the truth, which the scene is: hidden by it, but the truth shows
  // there, so both count and 10 cm of a diameter of 1 m are below a tau of .15, above one of .1.
  const VsdImages images{Plane(0, 10, 2.1f), Plane(0, 10, 2), Plane(0, 40, 2)};
  EXPECT_EQ(VsdErrors(images, 1, kBopShares)[0], 1);
  EXPECT_EQ(VsdErrors(images, 1, kBopShares)[2], 0);
}

TEST(RayLengths, GrowTowardsTheCorners) {
  const PinholeCamera camera{40, 10, 20, 20, 10, 5};
  const cv::Mat lengths = RayLengths(Plane(0, 40, 2), camera);
  EXPECT_NEAR(lengths.at<float>(5, 10), 2, 1e-6);
  EXPECT_NEAR(lengths.at<float>(5, 30), 2 * std::numbers::sqrt2, 1e-6) << "45 degrees to the side";
  EXPECT_EQ(RayLengths(cv::Mat::zeros(10, 40, CV_32F), camera).at<float>(0, 0), 0);
}

TEST(BopRecallOf, AveragesOverThresholdsAndTargets) {
  BopErrors perfect{std::vector<double>(10, 0.0), 0, 0};
  BopErrors middling{std::vector<double>(10, 0.3), 0.3, 30};  // right from .35 on: 4 of 10
  const BopRecall recall = BopRecallOf({perfect, middling}, 4);
  EXPECT_EQ(recall.targets, 4);
  EXPECT_EQ(recall.estimated, 2);
  for (const double share : {recall.vsd, recall.mssd, recall.mspd, recall.average()})
    EXPECT_NEAR(share, (1 + 0.4) / 4, 1e-12);
  EXPECT_EQ(BopRecallOf({}, 0).average(), 0);
}

}  // namespace
}  // namespace plumbline
