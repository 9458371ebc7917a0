// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/kitti_measures.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

const UprightFrame kUpright(Eigen::Vector3d(0, 0, -1));

Eigen::Isometry3d CarPose(double x, double y, double azimuth_rad, double z = 0) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitZ());
}

KittiBox BoxAt(double x, double azimuth_rad = 0,
               std::optional<KittiLevel> level = KittiLevel::kEasy) {
  return {BoxOf(Eigen::Vector3d(4, 2, 1.5), CarPose(x, 0, azimuth_rad), kUpright), azimuth_rad,
          level};
}
KittiCandidate CandidateAt(double x, double score, double azimuth_rad = 0) {
  KittiCandidate candidate;
  static_cast<KittiBox&>(candidate) = BoxAt(x, azimuth_rad);
  candidate.score = score;
  return candidate;
}
KittiPrecision Measured(std::vector<KittiCandidate> candidates, std::vector<KittiBox> truths,
                        KittiLevel level = KittiLevel::kHard) {
  return KittiPrecisionOf(std::move(candidates), truths, KittiOverlap::kVolume, 0.7, level);
}

TEST(KittiMeasures, OverlapOfShiftedBoxesByTheClosedForm) {
  const StandingBox a = BoxAt(0).box, b = BoxAt(1).box;
  EXPECT_NEAR(BaseIou(a, b), 3.0 / 5, 1e-12);
  EXPECT_NEAR(Iou(a, b), 3.0 / 5, 1e-12);
  const StandingBox lifted = BoxOf(Eigen::Vector3d(4, 2, 1.5), CarPose(0, 0, 0, 0.5), kUpright);
  EXPECT_NEAR(BaseIou(a, lifted), 1, 1e-12);
  EXPECT_NEAR(Iou(a, lifted), 1.0 / 2, 1e-12);
  // A square turned by 45 degrees shares an octagon of 2 (sqrt(2) - 1) of its area.
  const double octagon = 2 * (std::numbers::sqrt2 - 1);
  const auto square = [](double azimuth) {
    return BoxOf(Eigen::Vector3d(1, 1, 1), CarPose(3, -2, azimuth), kUpright);
  };
  EXPECT_NEAR(BaseIou(square(0), square(std::numbers::pi / 4)), octagon / (2 - octagon), 1e-12);
}

TEST(KittiMeasures, OverlapFromAboveEqualsThatOfOpenCvsRotatedRectangles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int overlapping = 0;
  for (int i = 0; i < 300; ++i) {
    const auto draw = [&] {
      const Eigen::Vector3d size(4 + uniform(random), 1.8 + 0.3 * uniform(random), 1.5);
      return std::pair(size, Eigen::Vector3d(2 * uniform(random), 1.5 * uniform(random),
                                             std::numbers::pi * uniform(random)));
    };
    const auto [size_a, pose_a] = draw();
    const auto [size_b, pose_b] = draw();
    const StandingBox a = BoxOf(size_a, CarPose(pose_a.x(), pose_a.y(), pose_a.z()), kUpright),
                      b = BoxOf(size_b, CarPose(pose_b.x(), pose_b.y(), pose_b.z()), kUpright);
    const auto rectangle = [](const Eigen::Vector3d& size, const Eigen::Vector3d& pose) {
      return cv::RotatedRect({static_cast<float>(pose.x()), static_cast<float>(pose.y())},
                             {static_cast<float>(size.x()), static_cast<float>(size.y())},
                             static_cast<float>(pose.z() * kDegPerRad));
    };
    std::vector<cv::Point2f> shared, hull;
    cv::rotatedRectangleIntersection(rectangle(size_a, pose_a), rectangle(size_b, pose_b), shared);
    double area = 0;
    if (shared.size() > 2) {
      cv::convexHull(shared, hull);
      area = cv::contourArea(hull);
    }
    const double together = size_a.x() * size_a.y() + size_b.x() * size_b.y() - area;
    EXPECT_NEAR(BaseIou(a, b), area / together, 2e-4) << i;  // OpenCV's corners are floats
    overlapping += area > 0.5;
  }
  EXPECT_GT(overlapping, 100);
}

TEST(KittiMeasures, AllFoundInTheRightDirectionIsOne) {
  const KittiPrecision p =
      Measured({CandidateAt(0, 0.9), CandidateAt(10, 0.5)}, {BoxAt(0), BoxAt(10)});
  for (const double value : {p.ap_40, p.ap_11, p.aos_40, p.aos_11}) EXPECT_NEAR(value, 1, 1e-12);
  EXPECT_EQ(p.found, 2);
  EXPECT_EQ(p.wrong, 0);
}

TEST(KittiMeasures, PrecisionIsInterpolatedOverBothSetsOfRecalls) {
  // By falling score: right, wrong, right; of two true boxes. Precision 1 up to recall 1/2, then
  // 2/3: 20 and 20 of 40 places, 6 (0 .. 0.5) and 5 of 11.
  const KittiPrecision p = Measured(
      {CandidateAt(0, 0.9), CandidateAt(50, 0.8), CandidateAt(10, 0.7)}, {BoxAt(0), BoxAt(10)});
  EXPECT_NEAR(p.ap_40, (20 + 20 * 2 / 3.0) / 40, 1e-12);
  EXPECT_NEAR(p.ap_11, (6 + 5 * 2 / 3.0) / 11, 1e-12);
  // Found last, one of two is missing at first: places beyond the recall reached are 0.
  const KittiPrecision half = Measured({CandidateAt(0, 0.9)}, {BoxAt(0), BoxAt(10)});
  EXPECT_NEAR(half.ap_40, 20.0 / 40, 1e-12);
  EXPECT_NEAR(half.ap_11, 6.0 / 11, 1e-12);
}

TEST(KittiMeasures, OrientationCountsByItsSimilarity) {
  for (const double turned : {0.0, 0.4, std::numbers::pi}) {
    const KittiPrecision p =
        Measured({CandidateAt(0, 0.9, turned == 0.4 ? 0.05 : turned)}, {BoxAt(0)});
    const double by = turned == 0.4 ? 0.05 : turned;
    EXPECT_NEAR(p.ap_40, 1, 1e-12);
    EXPECT_NEAR(p.aos_40, 0.5 * (1 + std::cos(by)), 1e-12);
  }
}

TEST(KittiMeasures, ABoxCountsOnceAndSecondsAreWrong) {
  const KittiPrecision p = Measured({CandidateAt(0, 0.9), CandidateAt(0.1, 0.8)}, {BoxAt(0)});
  EXPECT_EQ(p.found, 1);
  EXPECT_EQ(p.wrong, 1);
  EXPECT_NEAR(p.ap_40, 1, 1e-12) << "the second comes after full recall";
}

TEST(KittiMeasures, HarderBoxesNeitherCountNorMayBeMissed) {
  const std::vector<KittiBox> truths = {BoxAt(0), BoxAt(10, 0, KittiLevel::kHard),
                                        BoxAt(20, 0, std::nullopt)};
  const std::vector<KittiCandidate> candidates = {CandidateAt(20, 0.95), CandidateAt(10, 0.9),
                                                  CandidateAt(0, 0.8)};
  const KittiPrecision easy = Measured(candidates, truths, KittiLevel::kEasy),
                       hard = Measured(candidates, truths, KittiLevel::kHard);
  EXPECT_EQ(easy.truths, 1);
  EXPECT_EQ(easy.wrong, 0);
  EXPECT_NEAR(easy.ap_40, 1, 1e-12);
  EXPECT_EQ(hard.truths, 2);
  EXPECT_NEAR(hard.ap_40, 1, 1e-12);
  // A wrong candidate that is too small to count is not wrong.
  KittiCandidate small = CandidateAt(40, 0.99);
  small.level = std::nullopt;
  EXPECT_EQ(Measured({small, CandidateAt(0, 0.8)}, truths, KittiLevel::kEasy).wrong, 0);
}

TEST(KittiMeasures, EqualScoresAreTakenTogether) {
  const std::vector<KittiBox> truths = {BoxAt(0)};
  const double one = Measured({CandidateAt(0, 0.5), CandidateAt(30, 0.5)}, truths).ap_40,
               other = Measured({CandidateAt(30, 0.5), CandidateAt(0, 0.5)}, truths).ap_40;
  EXPECT_NEAR(one, 0.5, 1e-12);
  EXPECT_NEAR(other, 0.5, 1e-12);
}

TEST(KittiMeasures, LevelsFollowHeightAndTruncation) {
  KittiViews views;
  views.camera = {1242, 375, 721.5, 721.5, 620.5, 187};
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along +x
  world_from_cam.translation() << 0, 0, 1.65;
  views.cam_from_world = {world_from_cam.inverse()};
  const auto level = [&](double x, double y) {
    return LevelIn(views, BoxOf(Eigen::Vector3d(4, 2, 1.5), CarPose(x, y, 0), kUpright), kUpright);
  };
  // A height of 1.5 m shows as 40 px at 27 m and 25 px at 43 m (its near end counts: 2 m nearer).
  EXPECT_EQ(level(27, 0), KittiLevel::kEasy);
  EXPECT_EQ(level(31, 0), KittiLevel::kModerate);
  EXPECT_EQ(level(44, 0), KittiLevel::kModerate);
  EXPECT_EQ(level(48, 0), std::nullopt);
  EXPECT_EQ(level(-10, 0), std::nullopt) << "behind the camera";
  // The image ends at 0.86 m a metre. From 6.6/12 = 0.55 to 8.6/8 = 1.08 a metre, 41 % are cut off;
  // from 8/12 = 0.67 to 10/8 = 1.25, 67 %.
  EXPECT_EQ(level(10, 7.6), KittiLevel::kHard);
  EXPECT_EQ(level(10, 9), std::nullopt);
  EXPECT_EQ(level(10, 14), std::nullopt);
}

}  // namespace
}  // namespace plumbline
