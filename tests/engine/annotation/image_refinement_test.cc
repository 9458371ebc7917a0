// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/image_refinement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/random_vector.h"
#include "tests/engine/annotation/checked_room.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

/// Six drawn images around a seat that stands at `truth`. With `pose_noise_m` the cameras are not
/// quite where they are said to be.
std::shared_ptr<const AnnotationImages> DrawnAround(const OutlineModel& model,
                                                    const Eigen::Isometry3d& truth,
                                                    double pose_noise_m = 0,
                                                    std::uint64_t seed = 0) {
  std::vector<AnnotationImage> images;
  for (int i = 0; i < 6; ++i) {
    const double angle = kRadPerDeg * 28 * i;
    const Eigen::Isometry3d cam_at =
        LookAt({2 * std::cos(angle), 2 * std::sin(angle), 1.3 + 0.1 * (i % 2)}, {0, 0, 0.4});
    images.push_back(DrawnImage(i, model, truth, truth * cam_at));
    Random random({seed, static_cast<std::uint32_t>(i)});
    for (int k = 0; k < 3; ++k) {
      images.back().scan_from_cam.translation()[k] += pose_noise_m * random.Gaussian();
    }
  }
  return AnnotationImages::FromImages(TestCamera(), std::move(images));
}

/// `pose` turned about up through its origin and shifted.
Eigen::Isometry3d Moved(const Eigen::Isometry3d& pose, const Eigen::Vector3d& up, double turn_deg,
                        const Eigen::Vector3d& shift) {
  Eigen::Isometry3d moved = pose;
  moved.linear() = Eigen::AngleAxisd(turn_deg * kRadPerDeg, up) * pose.linear();
  moved.translation() += shift;
  return moved;
}

class RefineSeat : public testing::Test {
 protected:
  const Eigen::Vector3d up_{0, 0, 1};
  const Eigen::Isometry3d truth_ = Eigen::Isometry3d::Identity();
  std::shared_ptr<const OutlineModel> seat_ = OutlineModel::Prepare(SeatMesh()).value();
};

TEST_F(RefineSeat, ComesBackFromFiveCentimetresAndFiveDegrees) {
  const auto images = DrawnAround(*seat_, truth_);
  for (const double turn_deg : {5.0, -5.0}) {
    const Eigen::Isometry3d start = Moved(truth_, up_, turn_deg, {0.03, -0.04, 0.01});
    const auto refined = RefineByImages(*images, *seat_, start, up_, {});
    ASSERT_TRUE(refined.ok()) << refined.error().message;
    // Edges are whole pixels of 4 mm; hundreds of them average out.
    EXPECT_THAT(refined->scan_from_object, IsometryNear(truth_, 0.1, 0.001));
    EXPECT_EQ(refined->stop, RefinementStop::kConverged);
    EXPECT_GT(refined->agreement_after, 0.9);
    EXPECT_LT(refined->agreement_before, 0.5);
    EXPECT_NEAR(refined->azimuth_rad, -turn_deg * kRadPerDeg, 0.003);
    EXPECT_NEAR(refined->height_m, -0.01, 0.001);
    EXPECT_EQ(refined->images, 6);
  }
}

TEST_F(RefineSeat, KeepsUprightExactlyForAnyGravity) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    Random random({7, i});
    const UprightFrame upright(GaussianVector<3>(random));
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    truth.linear() = upright.WorldFromObjectRotation(random.Uniform(-3, 3));
    truth.translation() = Eigen::Vector3d(1, -2, 3);
    const auto images = DrawnAround(*seat_, truth);
    const Eigen::Isometry3d start =
        Moved(truth, upright.up_in_world(), 3, 0.03 * Eigen::Vector3d::Ones());
    const auto refined = RefineByImages(*images, *seat_, start, upright.up_in_world(), {});
    ASSERT_TRUE(refined.ok());
    EXPECT_LT(upright.Tilt(refined->scan_from_object.linear()), 1e-9);
    EXPECT_THAT(refined->scan_from_object, IsometryNear(truth, 0.1, 0.001));
  }
}

TEST_F(RefineSeat, StaysOnTheFloorIfToldTo) {
  const auto images = DrawnAround(*seat_, truth_);
  ImageRefinementOptions options;
  options.motion = FreeMotion::kAzimuthAndHorizontal;
  const Eigen::Isometry3d start = Moved(truth_, up_, 4, {0.02, 0.03, 0});
  const auto refined = RefineByImages(*images, *seat_, start, up_, {}, options);
  ASSERT_TRUE(refined.ok());
  EXPECT_NEAR(refined->scan_from_object.translation().z(), 0, 1e-12);
  EXPECT_NEAR(refined->covariance(2, 2), 0, 1e-15);
  EXPECT_THAT(refined->scan_from_object, IsometryNear(truth_, 0.1, 0.001));
}

TEST_F(RefineSeat, ForgivesAHiddenHalf) {
  // A board hides the left half from every camera; it is known.
  const auto board = OutlineModel::Prepare(BoxMesh({0.02f, 3, 0.6f})).value();
  std::vector<AnnotationImage> images;
  const Occluders occluders{nullptr, {{board, Eigen::Isometry3d(Eigen::Translation3d(0.7, 0, 0))}}};
  for (int i = 0; i < 6; ++i) {
    const double angle = kRadPerDeg * (16 * i - 40);
    images.push_back(DrawnImage(
        i, *seat_, truth_, LookAt({2 * std::cos(angle), 2 * std::sin(angle), 1.2}, {0, 0, 0.4}),
        occluders));
  }
  const auto drawn = AnnotationImages::FromImages(TestCamera(), std::move(images));
  const Eigen::Isometry3d start = Moved(truth_, up_, -4, {0.03, 0.03, -0.02});
  const auto refined = RefineByImages(*drawn, *seat_, start, up_, occluders);
  ASSERT_TRUE(refined.ok());
  EXPECT_THAT(refined->scan_from_object, IsometryNear(truth_, 0.2, 0.002));
}

TEST_F(RefineSeat, KnowsHowFarItMayBeWrong) {
  // Cameras are off by 4 mm, each on its own: thousands of samples share six errors.
  constexpr int kRuns = 12;
  double squares = 0, variances = 0, turn_squares = 0, turn_variances = 0;
  ImageRefinementOptions options;
  options.starts = 1;
  for (int run = 0; run < kRuns; ++run) {
    const auto images = DrawnAround(*seat_, truth_, 0.004, static_cast<std::uint64_t>(run));
    const auto refined = RefineByImages(*images, *seat_, truth_, up_, {}, options);
    ASSERT_TRUE(refined.ok());
    squares += refined->scan_from_object.translation().squaredNorm();
    variances += refined->covariance.topLeftCorner<3, 3>().trace();
    const double turn = UprightFrame(-up_).Azimuth(refined->scan_from_object.linear());
    turn_squares += turn * turn;
    turn_variances += refined->covariance(5, 5);
  }
  // Of 36 squares the mean is good to a quarter; too careful is better than too sure.
  const double ratio = std::sqrt(squares / variances);
  EXPECT_GT(ratio, 0.35);
  EXPECT_LT(ratio, 1.5);
  const double turn_ratio = std::sqrt(turn_squares / turn_variances);
  EXPECT_GT(turn_ratio, 0.2);
  EXPECT_LT(turn_ratio, 1.6);
}

TEST_F(RefineSeat, DoesNotTurnWhatLooksTheSameFromAllSides) {
  const auto ball = OutlineModel::Prepare(MakeSphere(0.3f, 24)).value();
  const auto images = DrawnAround(*ball, truth_);
  const auto refined =
      RefineByImages(*images, *ball, Moved(truth_, up_, 0, {0.03, 0.02, 0}), up_, {});
  ASSERT_TRUE(refined.ok());
  EXPECT_LT(refined->scan_from_object.translation().norm(), 0.003);
  EXPECT_GT(std::sqrt(refined->covariance(5, 5)), 2 * kRadPerDeg);
}

TEST_F(RefineSeat, SaysWhatItCannotDo) {
  const auto images = DrawnAround(*seat_, truth_);
  const auto far = RefineByImages(*images, *seat_, Moved(truth_, up_, 0, {0, 0, 20}), up_, {});
  EXPECT_EQ(far.error().code, ErrorCode::kDegenerate);
  ImageRefinementOptions rigid;
  rigid.motion = FreeMotion::kRigid;
  EXPECT_EQ(RefineByImages(*images, *seat_, truth_, up_, {}, rigid).error().code,
            ErrorCode::kInvalidInput);
  std::stop_source stop;
  stop.request_stop();
  WorkContext work;
  work.stop = stop.get_token();
  EXPECT_EQ(RefineByImages(*images, *seat_, truth_, up_, {}, {}, work).error().code,
            ErrorCode::kCancelled);
}

TEST_F(RefineSeat, IsTheSameEveryTime) {
  const auto images = DrawnAround(*seat_, truth_, 0.003, 5);
  const Eigen::Isometry3d start = Moved(truth_, up_, 3, {0.02, 0.03, 0.01});
  const auto a = RefineByImages(*images, *seat_, start, up_, {});
  const auto b = RefineByImages(*images, *seat_, start, up_, {});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->scan_from_object.matrix(), b->scan_from_object.matrix());
  EXPECT_EQ(a->covariance, b->covariance);
}

}  // namespace
}  // namespace plumbline
