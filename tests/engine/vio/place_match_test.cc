// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/place_match.h"
#include "engine/geometry/random_vector.h"

#include <gtest/gtest.h>

#include "engine/vio/past_correction.h"

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/vio/drift.h"
#include "engine/vio/loop_closer.h"
#include "engine/vio/trajectory_correction.h"

namespace plumbline {
namespace {

/// Two views of one cloud of points, the second by a filter that has drifted.
class PlaceMatchTest : public testing::Test {
 protected:
  static constexpr double kYaw = 4 * kRadPerDeg;

  PlaceMatchTest() {
    camera_.model = CameraModel::kRadialTangential;
    camera_.pinhole = {640, 480, 400, 398, 322, 238};
    camera_.distortion = {-0.28, 0.07, 2e-4, 2e-5};
    Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();
    body_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    body_from_cam.translation() << 0.05, -0.03, 0.02;
    older_.body_from_cam = seen_.body_from_cam = body_from_cam;
    older_.world_from_body.linear() =
        Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
    older_.world_from_body.translation() << 1, 2, 1.5;
    truth_.linear() =
        Eigen::AngleAxisd(0.15, Eigen::Vector3d(0.2, -1, 2).normalized()).toRotationMatrix();
    truth_.translation() << 1.3, 1.8, 1.6;
    seen_.world_from_body = truth_;
    seen_.world_from_body.linear() =
        Eigen::AngleAxisd(-kYaw, Eigen::Vector3d::UnitZ()) * truth_.linear();
    seen_.world_from_body.translation() += Eigen::Vector3d(0.8, -0.5, 0.1);
    AddPoints();
  }

  /// Points in front of both, with descriptors of their own; a corner for each where it is seen.
  void AddPoints() {
    const DistortedCamera lens(camera_);
    Random random({7});
    for (int i = 0; i < 80; ++i) {
      const Eigen::Vector3d point(random.Uniform(3.5, 6), random.Uniform(0, 4),
                                  random.Uniform(0.5, 2.8));
      const auto view = lens.Project((truth_ * seen_.body_from_cam).inverse() * point);
      if (!view) continue;
      const Eigen::Vector2d pixel = view->pixel + 0.7 * GaussianVector<2>(random);
      cv::Mat row(1, 32, CV_8U), again;
      for (int k = 0; k < 32; ++k) row.at<uchar>(0, k) = static_cast<uchar>(random.Index(256));
      again = row.clone();
      for (int k = 0; k < 12; ++k)
        again.at<uchar>(0, static_cast<int>(random.Index(32))) ^=
            static_cast<uchar>(1u << random.Index(8));
      older_.point_of_row.push_back(static_cast<int>(older_.points_in_body.size()));
      older_.points_in_body.push_back(older_.world_from_body.inverse() * point);
      older_.point_descriptors.push_back(row);
      seen_.corners.push_back({pixel, *lens.Unproject(pixel), 1});
      seen_.descriptors.push_back(again);
    }
  }

  std::optional<PlaceMatch> Locate(const std::vector<PointMatch>& matches) const {
    return LocateByPoints(DistortedCamera(camera_), camera_.pinhole.fx, older_, seen_, matches, {});
  }

  Camera camera_;
  PlaceFrame older_, seen_;
  Eigen::Isometry3d truth_ = Eigen::Isometry3d::Identity();
};

TEST_F(PlaceMatchTest, FindsWhereAKnownPlaceIsSeenFrom) {
  const auto matches = MatchPoints(older_, seen_);
  ASSERT_GT(matches.size(), 60u);
  for (const PointMatch& match : matches) EXPECT_EQ(match.point, match.corner);
  const auto place = Locate(matches);
  ASSERT_TRUE(place.has_value());
  EXPECT_GT(place->inliers, 50);
  // 70 points of 0.7 px at 4 m: 1 mm across and a few along; three standard deviations of 1.5 px.
  EXPECT_LT((place->position_in_world - truth_.translation()).norm(), 0.04);
  EXPECT_NEAR(place->yaw_rad, kYaw, 0.3 * kRadPerDeg);
  Eigen::Vector4d error;
  error << place->position_in_world - truth_.translation(), place->yaw_rad - kYaw;
  EXPECT_LT(error.dot(place->covariance.inverse() * error), 18.5);
}

TEST_F(PlaceMatchTest, SurvivesMismatches) {
  auto matches = MatchPoints(older_, seen_);
  const int count = static_cast<int>(matches.size());
  for (int i = 0; i < count * 2 / 5; ++i)
    matches[static_cast<std::size_t>(i)].corner = (i * 7 + 13) % count;
  const auto place = Locate(matches);
  ASSERT_TRUE(place.has_value());
  EXPECT_LT((place->position_in_world - truth_.translation()).norm(), 0.06);
}

TEST_F(PlaceMatchTest, TurnsAwayAPlaceThatLeans) {
  seen_.world_from_body.linear() =
      Eigen::AngleAxisd(8 * kRadPerDeg, Eigen::Vector3d::UnitX()) * seen_.world_from_body.linear();
  EXPECT_FALSE(Locate(MatchPoints(older_, seen_)).has_value());
}

TEST_F(PlaceMatchTest, TurnsAwayPointsThatDoNotAgreeOrLieTogether) {
  auto matches = MatchPoints(older_, seen_);
  const auto good = matches;
  Random random({3});
  for (PointMatch& match : matches)
    match.corner = static_cast<int>(random.Index(static_cast<std::uint32_t>(seen_.corners.size())));
  EXPECT_FALSE(Locate(matches).has_value());
  EXPECT_FALSE(Locate({good.begin(), good.begin() + 10}).has_value());
}

TEST(HandedOn, TheHeadingTurnsWhatIsFarOffAndTheTiltDoesNot) {
  PoseCovariance first = PoseCovariance::Zero();
  first.diagonal() << 1e-4, 1e-4, 1e-4, 1e-2, 1e-2, 1e-4;
  const Eigen::Matrix4d later = HandedOn({1, 0, 0}, first, {31, 0, 0});
  EXPECT_NEAR(later(1, 1), 1e-4 + 900 * 1e-4, 1e-9) << "across";
  EXPECT_NEAR(later(2, 2), 1e-4, 1e-9) << "up";
  EXPECT_NEAR(later(3, 3), 1e-4, 1e-12);
}

TEST(DriftBetween, IsTheGrowthAtThePlaceOfTheLater) {
  PlaceFrame from, to;
  to.world_from_body.translation() << 10, 0, 0;
  from.covariance.diagonal().setConstant(1e-4);
  // What turns the world at `from` moves `to` sideways: it is common to both, and no drift.
  to.covariance = MovedBy({10, 0, 0}, from.covariance);
  const double floor = DriftBetween(from, from, 3)(0, 0);
  EXPECT_NEAR(DriftBetween(from, to, 3)(1, 1), floor, 1e-12);
  to.covariance(1, 1) += 0.04;
  EXPECT_NEAR(DriftBetween(from, to, 3)(1, 1), floor + 9 * 0.04, 1e-9);
}

TEST(TrajectoryCorrection, ChangesEvenlyBetweenKeyFramesAndKeepsTheFiltersTilt) {
  TrajectoryMoves::Node a, b;
  a.stamp_ns = 1'000'000'000;
  a.corrected = {0, {0, 0, 0}};
  b.stamp_ns = 2'000'000'000;
  b.filter_position_in_world = {2, 0, 0};
  b.corrected = {0.1, {2.2, 0.1, 0}};
  const TrajectoryCorrection correction(
      {a, b}, {Eigen::Matrix4d::Zero(), Eigen::Vector4d::Constant(0.04).asDiagonal()});
  EXPECT_TRUE(correction.At(500'000'000, {0, 0, 0}).matrix().isIdentity(1e-12));
  EXPECT_LT((correction.At(b.stamp_ns, {2, 0, 0}) * Eigen::Vector3d(2, 0, 0) -
             b.corrected.position_in_world)
                .norm(),
            1e-12);
  const Eigen::Isometry3d half = correction.At(1'500'000'000, {1, 0, 0});
  EXPECT_NEAR(std::atan2(half(1, 0), half(0, 0)), 0.05, 1e-12);
  // Carried by a: (1, 0, 0); by b: (2.2, 0.1, 0) less a step of 1 m, turned by 0.1.
  const Eigen::Vector3d expected(0.5 * (1 + 2.2 - std::cos(0.1)), 0.5 * (0.1 - std::sin(0.1)), 0);
  EXPECT_LT((half * Eigen::Vector3d(1, 0, 0) - expected).norm(), 1e-12);
  PoseCovariance of_filter = PoseCovariance::Identity();
  of_filter(3, 3) = 0.25;
  const PoseCovariance covariance = correction.CovarianceAt(1'500'000'000, of_filter);
  EXPECT_DOUBLE_EQ(covariance(0, 0), 0.02);
  EXPECT_DOUBLE_EQ(covariance(5, 5), 0.02);
  EXPECT_DOUBLE_EQ(covariance(3, 3), 0.25);
}

/// A walk along x whose filter takes it for longer than it is: loops were closed at images 10 and
/// 20.
TEST(PastCorrection, MovesWhatWasToldBeforeWithWhatWasKnownThen) {
  const auto filter = [](int image) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(0.05 * image, Eigen::Vector3d(1, 2, 3).normalized()));
    pose.pretranslate(Eigen::Vector3d(0.1 * image, 0, 1.5));
    return pose;
  };
  const auto moves = [&](int images, double by) {
    std::vector<TrajectoryMoves::Node> nodes;
    for (const int image : {0, images / 2, images}) {
      TrajectoryMoves::Node& node = nodes.emplace_back();
      node.stamp_ns = image;
      node.filter_position_in_world = filter(image).translation();
      node.corrected = {by * image,
                        node.filter_position_in_world - Eigen::Vector3d(by * image, 0, 0)};
    }
    return TrajectoryMoves(std::move(nodes));
  };
  std::vector<PastCorrection> all;
  for (const auto& [image, by] : {std::pair{10, 0.01}, std::pair{20, 0.02}}) {
    const TrajectoryMoves past = moves(image, by);
    const auto& newest = past.nodes().back();
    all.push_back(
        {image, image / 10, MoveTo(newest.corrected, newest.filter_position_in_world), past});
  }
  for (int image = 0; image < 20; ++image) {
    const Eigen::Isometry3d told_from_filter =
        image < 10 ? Eigen::Isometry3d::Identity() : all[0].present.AsIsometry();
    const Eigen::Isometry3d told = told_from_filter * filter(image);
    const PoseWhenTold when{image, image, told, told.translation()};
    const Eigen::Isometry3d expected =
        all[1].past.At(image, filter(image).translation()) * filter(image);
    EXPECT_TRUE(CorrectedBy(all[1], all, when).isApprox(expected, 1e-12)) << image;
    if (image < 10) {
      EXPECT_EQ(CorrectedBy(all[0], all, when).matrix(),
                (all[0].past.At(image, told.translation()) * told).matrix());
    }
  }
}

}  // namespace
}  // namespace plumbline
