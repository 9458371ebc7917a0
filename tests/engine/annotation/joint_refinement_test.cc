// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/joint_refinement.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "tests/engine/annotation/checked_room.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

PoseCovariance Diagonal(double x_m, double y_m, double z_m, double turn_rad) {
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.diagonal() << x_m * x_m, y_m * y_m, z_m * z_m, 0, 0, turn_rad * turn_rad;
  return covariance;
}

Eigen::Isometry3d PoseAt(const Eigen::Vector3d& place, double azimuth_deg) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      Eigen::AngleAxisd(azimuth_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = place;
  return pose;
}

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

TEST(FusePoses, EachDirectionIsTakenFromTheOneThatKnowsIt) {
  const KnownPose by_scan{PoseAt({1, 2, 0.1}, 10), Diagonal(0.001, 1, 0.001, 0.5)};
  const KnownPose by_images{PoseAt({1.01, 2.02, 0.11}, 12), Diagonal(1, 0.001, 1, 0.001)};
  const FusedPose fused =
      FusePoses(by_scan, by_images, kUp, FreeMotion::kAzimuthAndTranslation, {0, 0, 0});
  EXPECT_THAT(fused.together.scan_from_object,
              IsometryNear(PoseAt({1, 2.02, 0.1}, 12), 0.01, 1e-4));
  EXPECT_EQ(fused.conflict, 1);
  const PoseDeviations deviations = DeviationsOf(fused.together.covariance, kUp);
  EXPECT_NEAR(deviations.horizontal_m, 0.001 * std::sqrt(2), 1e-6);
  EXPECT_NEAR(deviations.height_m, 0.001, 1e-6);
  EXPECT_NEAR(deviations.azimuth_rad, 0.001, 1e-6);
  EXPECT_NEAR(fused.apart.azimuth_rad, 2 * kRadPerDeg, 1e-9);
  EXPECT_NEAR(fused.apart_expected.height_m, 1, 0.01);
}

// Against the sum of both squared distances, written out: nothing nearby has less.
TEST(FusePoses, IsThePoseOfGreatestLikelihood) {
  Random random({5, 0});
  const Eigen::Vector3d middle(0.2, -0.1, 0.4);
  const auto covariance = [&] {
    Eigen::Matrix<double, 6, 4> from_move = Eigen::Matrix<double, 6, 4>::Zero();
    from_move.topLeftCorner<3, 3>().setIdentity();
    from_move(5, 3) = 1;
    Eigen::Matrix4d root;
    for (double& entry : root.reshaped()) entry = 0.01 * random.Gaussian();
    return PoseCovariance(from_move * root * root.transpose() * from_move.transpose());
  };
  const KnownPose a{PoseAt({0.3, 0.1, 0}, 20), covariance()};
  const KnownPose b{PoseAt({0.303, 0.098, 0.002}, 20.3), covariance()};
  const auto squared = [&](const KnownPose& known, const Eigen::Isometry3d& pose) {
    Eigen::Vector4d off;
    off << pose.translation() - known.scan_from_object.translation(),
        WrapAngle(UprightFrame(-kUp).Azimuth(pose.linear()) -
                  UprightFrame(-kUp).Azimuth(known.scan_from_object.linear()));
    Eigen::Matrix<double, 4, 6> move = Eigen::Matrix<double, 4, 6>::Zero();
    move.topLeftCorner<3, 3>().setIdentity();
    move(3, 5) = 1;
    const Eigen::Matrix4d of_move = move * known.covariance * move.transpose();
    return off.dot(of_move.inverse() * off);
  };
  const auto cost = [&](const Eigen::Isometry3d& pose) {
    return squared(a, pose) + squared(b, pose);
  };
  const FusedPose fused = FusePoses(a, b, kUp, FreeMotion::kAzimuthAndTranslation, middle);
  const Eigen::Isometry3d& best = fused.together.scan_from_object;
  for (int axis = 0; axis < 4; ++axis) {
    for (const double step : {1e-3, -1e-3}) {
      Eigen::Vector3d shift = Eigen::Vector3d::Zero();
      if (axis < 3) shift[axis] = step;
      Eigen::Isometry3d other = best;
      other.linear() = Eigen::AngleAxisd(axis == 3 ? step : 0, kUp) * best.linear();
      other.translation() += shift;
      EXPECT_GT(cost(other), cost(best)) << axis;
    }
  }
}

TEST(FusePoses, WhatContradictsWidensAndWhatIsLockedStays) {
  const KnownPose a{PoseAt({0, 0, 0.3}, 0), Diagonal(0.001, 0.001, 0, 0.001)};
  const KnownPose b{PoseAt({0.03, 0, 0.3}, 0), Diagonal(0.001, 0.001, 0, 0.001)};
  const FusedPose fused = FusePoses(a, b, kUp, FreeMotion::kAzimuthAndHorizontal, {0.1, 0, 0});
  EXPECT_EQ(fused.together.scan_from_object.translation().z(), 0.3);
  EXPECT_NEAR(fused.together.scan_from_object.translation().x(), 0.015, 1e-6);
  // 3 cm where 1.4 mm was expected, along one of three directions.
  EXPECT_NEAR(fused.conflict, 0.03 / 0.001 / std::sqrt(6.0), 0.1);
  EXPECT_NEAR(std::sqrt(fused.together.covariance(0, 0)), fused.conflict * 0.001 / std::sqrt(2.0),
              1e-5);
  EXPECT_EQ(fused.together.covariance(2, 2), 0);
}

class RefineSeatJointly : public testing::Test {
 protected:
  using Seen = std::function<bool(const Eigen::Vector3f& in_object)>;

  /// What was scanned of the seat where it stood, with 2 mm of noise.
  std::shared_ptr<const ScanTarget> Scan(const Eigen::Isometry3d& at, const Seen& seen) const {
    Random random({11, 0});
    TriangleMesh cloud;
    for (std::size_t i = 0; i < surface_->samples().points.size(); ++i) {
      const Eigen::Vector3f& point = surface_->samples().points[i];
      if (!seen(point)) continue;
      const Eigen::Vector3f normal = at.linear().cast<float>() * surface_->samples().normals[i];
      cloud.vertices.push_back(at.cast<float>() * point +
                               static_cast<float>(0.002 * random.Gaussian()) * normal);
      cloud.normals.push_back(normal);
    }
    return ScanTarget::Prepare(cloud).value();
  }

  /// Nine drawn images of it; the cameras are all `off` from where they are said to be.
  HeldOutImages Images(const Eigen::Vector3d& off) const {
    std::vector<AnnotationImage> images;
    for (int i = 0; i < 9; ++i) {
      const double angle = kRadPerDeg * 20 * i;
      const Eigen::Isometry3d cam_at =
          LookAt({2 * std::cos(angle), 2 * std::sin(angle), 1.3 + 0.1 * (i % 2)}, {0, 0, 0.4});
      images.push_back(DrawnImage(i, *outline_, truth_, cam_at));
      images.back().scan_from_cam.translation() += off;
    }
    return HoldOutEveryThird(AnnotationImages::FromImages(TestCamera(), std::move(images)));
  }

  JointRefinement Refine(const std::shared_ptr<const ScanTarget>& scan,
                         const HeldOutImages& images) const {
    RefinementEvidence evidence;
    evidence.scan = scan.get();
    evidence.surface = surface_.get();
    evidence.images = images.used.get();
    evidence.held_out = images.held_out.get();
    evidence.outline = outline_.get();
    JointRefinementOptions options;
    options.images.camera_std_m = kUsualCameraStd_m;
    options.images.camera_turn_std_deg = kUsualCameraTurnStd_deg;
    const auto refined = RefineJointly(evidence, start_, kUp, options);
    EXPECT_TRUE(refined.ok()) << refined.error().message;
    return refined.ok() ? *refined : JointRefinement{};
  }

  static Eigen::Vector3d Off(const JudgedPose& pose) {
    return pose.estimate.scan_from_object.translation();
  }

  const TriangleMesh mesh_ = SeatMesh();
  const Eigen::Isometry3d truth_ = Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d start_ = PoseAt({0.02, -0.025, 0.01}, 3);
  std::shared_ptr<const ModelSurface> surface_ = ModelSurface::Prepare(mesh_).value();
  std::shared_ptr<const OutlineModel> outline_ = OutlineModel::Prepare(mesh_).value();
};

TEST_F(RefineSeatJointly, AWholeScanIsNotDraggedAwayByCamerasThatAreOff) {
  const auto scan = Scan(truth_, [](const auto&) { return true; });
  const HeldOutImages images = Images({0.008, 0.006, 0});
  ASSERT_EQ(images.used->images().size(), 6u);
  ASSERT_EQ(images.held_out->images().size(), 3u);
  const JointRefinement refined = Refine(scan, images);
  ASSERT_TRUE(refined.by_scan && refined.by_images && refined.together);
  EXPECT_GT(Off(*refined.by_images).norm(), 0.007);
  EXPECT_LT(Off(*refined.by_scan).norm(), 0.001);
  EXPECT_LT(Off(*refined.together).norm(), 0.001);
  EXPECT_FALSE(refined.Contradict());
  EXPECT_EQ(refined.best, RefineBy::kBoth);
  // What the images say of themselves holds although no residual shows it.
  const PoseDeviations known = DeviationsOf(refined.by_images->estimate.covariance, kUp);
  EXPECT_GT(known.horizontal_m, 0.01);
  EXPECT_NEAR(refined.apart.horizontal_m, 0.01, 0.0015);
}

TEST_F(RefineSeatJointly, TheImagesGiveWhatTheScanDoesNotShow) {
  // Only the seat's top was scanned: its height is known, and nothing else.
  const auto scan = Scan(truth_, [](const Eigen::Vector3f& p) {
    return std::abs(p.z() - 0.4f) < 1e-3f && std::abs(p.x()) < 0.15f && std::abs(p.y()) < 0.12f;
  });
  const JointRefinement refined = Refine(scan, Images({0, 0, 0.01}));
  ASSERT_TRUE(refined.together.has_value());
  EXPECT_GT(std::abs(Off(*refined.by_images).z()), 0.008);
  EXPECT_LT(std::abs(Off(*refined.together).z()), 0.001) << "from the scan";
  EXPECT_LT(Off(*refined.together).head<2>().norm(), 0.002) << "from the images";
  EXPECT_LT(std::abs(refined.together->change.azimuth_rad + 3 * kRadPerDeg), 0.3 * kRadPerDeg);
  EXPECT_EQ(refined.best, RefineBy::kBoth);
}

TEST_F(RefineSeatJointly, WhereBothContradictTheImagesHeldOutDecide) {
  // It was moved between the scan and the film.
  const auto scan = Scan(PoseAt({-0.05, 0.03, 0}, -8), [](const auto&) { return true; });
  const JointRefinement refined = Refine(scan, Images({0, 0, 0}));
  ASSERT_TRUE(refined.together.has_value());
  EXPECT_TRUE(refined.Contradict());
  EXPECT_EQ(refined.best, RefineBy::kImages);
  EXPECT_GT(refined.by_images->agreement_held_out.value(), 0.8);
  EXPECT_LT(refined.by_scan->agreement_held_out.value(), 0.5);
}

TEST_F(RefineSeatJointly, OneAloneDecidesWhereThereIsOnlyOne) {
  const auto scan = Scan(truth_, [](const auto&) { return true; });
  const JointRefinement by_scan = Refine(scan, {});
  EXPECT_EQ(by_scan.best, RefineBy::kScan);
  EXPECT_EQ(by_scan.Of(RefineBy::kBoth), nullptr);
  EXPECT_LT(Off(*by_scan.Of(RefineBy::kScan)).norm(), 0.001);
  const JointRefinement by_images = Refine(nullptr, Images({0, 0, 0}));
  EXPECT_EQ(by_images.best, RefineBy::kImages);
  EXPECT_LT(Off(*by_images.Of(RefineBy::kImages)).norm(), 0.002);
  const auto elsewhere = Scan(PoseAt({5, 0, 0}, 0), [](const auto&) { return true; });
  const JointRefinement without = Refine(elsewhere, Images({0, 0, 0}));
  EXPECT_EQ(without.best, RefineBy::kImages);
  EXPECT_FALSE(without.scan_problem.empty());
  EXPECT_EQ(RefineJointly({}, start_, kUp).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace plumbline
