// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/pose_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/mapping/likelihood.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

PoseCovariance Covariance(double position_m, double rotation_rad) {
  PosePerturbation deviations;
  deviations << Eigen::Vector3d::Constant(position_m), Eigen::Vector3d::Constant(rotation_rad);
  return deviations.cwiseAbs2().asDiagonal();
}

TEST(ImageShifts, HaveTheMomentsOfProjectionsByPosesThatErr) {
  const Eigen::Isometry3d world_from_cam = LookAt({2, 1, 1.5}, {0, 0, 0.5});
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  const Eigen::Vector3d point(0.1, -0.2, 0.4);
  const PoseCovariance covariance = Covariance(0.01, 0.3 * 3.14159 / 180);
  const PoseUncertainty own{.own = covariance}, exact;
  const std::vector<ImageShift> shifts =
      ImageShiftsOf(point, {world_from_cam, own}, {world_from_cam, exact}, camera);
  ASSERT_EQ(shifts.size(), 5u);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  double sum = 0;
  for (const ImageShift& shift : shifts) {
    const Eigen::Vector2d s(shift.x_px, shift.y_px);
    sum += shift.weight;
    mean += shift.weight * s;
    second += shift.weight * s * s.transpose();
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_LT(mean.norm(), 1e-9);

  Random random(RandomKey{3, 0, 0, 0});
  const Eigen::Vector2d right = camera.Project(world_from_cam.inverse() * point);
  Eigen::Matrix2d drawn = Eigen::Matrix2d::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    PosePerturbation error;
    for (int k = 0; k < 6; ++k) error[k] = std::sqrt(covariance(k, k)) * random.Gaussian();
    const Eigen::Vector2d off =
        camera.Project(Perturbed(world_from_cam, error).inverse() * point) - right;
    drawn += off * off.transpose() / kDraws;
  }
  EXPECT_LT((second - drawn).norm(), 0.03 * drawn.norm());
}

TEST(ImageShifts, AreNotMadeForWhatIsExactOrHardlyErrs) {
  const Eigen::Isometry3d world_from_cam = LookAt({2, 1, 1.5}, {0, 0, 0.5});
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  const Eigen::Vector3d in_front(0, 0, 0.5), behind(4, 2, 2.5);
  const auto shifts = [&](const PoseCovariance& own, const Eigen::Vector3d& point) {
    return ImageShiftsOf(point, {world_from_cam, {.own = own}}, {world_from_cam, {}}, camera);
  };
  EXPECT_TRUE(shifts(PoseCovariance::Zero(), in_front).empty());
  EXPECT_TRUE(shifts(Covariance(1e-4, 1e-5), in_front).empty());
  EXPECT_TRUE(shifts(Covariance(0.01, 0.01), behind).empty());
  EXPECT_FALSE(shifts(Covariance(0.01, 0.01), in_front).empty());
}

TEST(ImageShifts, OfADriftAreAsLargeWhicheverOfTwoViewsKnowsBetterAndAddToOwnErrors) {
  const Eigen::Isometry3d world_from_cam = LookAt({2, 1, 1.5}, {0, 0, 0.5});
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  const Eigen::Vector3d point(0.1, -0.2, 0.4);
  const auto spread = [&](const PoseUncertainty& view, const PoseUncertainty& reference) {
    double sum = 0;
    for (const ImageShift& shift :
         ImageShiftsOf(point, {world_from_cam, view}, {world_from_cam, reference}, camera))
      sum += shift.weight * (shift.x_px * shift.x_px + shift.y_px * shift.y_px);
    return sum;
  };
  const PoseUncertainty early{.drift = Covariance(0.02, 0.001)};
  PoseUncertainty late{.drift = 2 * early.drift};
  const double drifted = spread(late, early);
  EXPECT_NEAR(drifted, spread({.own = early.drift}, {}), 1e-9 * drifted);
  EXPECT_NEAR(spread(early, late), drifted, 1e-9 * drifted) << "corrected by as much";
  EXPECT_EQ(spread(early, early), 0);
  late.own = Covariance(0.01, 0.002);
  EXPECT_NEAR(spread(late, early), drifted + spread({.own = late.own}, {}), 1e-9 * drifted);
}

TEST(DriftAt, ATurnOfTheWholeWorldMovesNoPointBetweenTwoViews) {
  const Eigen::Isometry3d here = LookAt({2, 1, 1.5}, {0, 0, 0.5}),
                          there = LookAt({-3, 2, 1.2}, {0, 0, 0.5});
  // An error common to both, as it shows in each: what turns about the origin moves a camera.
  const PoseCovariance world = Covariance(0.03, 0.02), zero = PoseCovariance::Zero();
  const PoseUncertainty at_here{.drift = MovedBy(here.translation(), world)},
      at_there{.drift = MovedBy(there.translation(), world)};
  EXPECT_GT((at_here.drift - at_there.drift).norm(), 0.1 * world.norm());
  EXPECT_LT(DriftAt({0.1, -0.2, 0.4}, {here, at_here}, {there, at_there}).norm(), 1e-12);
  // What one alone has turned by moves what is far by more.
  const PoseUncertainty turned{.drift = Covariance(0, 0.01)}, exact{.drift = zero};
  const Eigen::Vector3d far = here * Eigen::Vector3d(0, 0, 4);
  const PoseCovariance moved = DriftAt(far, {here, turned}, {here, exact});
  EXPECT_NEAR(moved.diagonal().head<3>().sum(), 2 * 0.04 * 0.04, 1e-9);
}

/// Cameras along a way that drift by one share of it, all looking at a point.
class LongerWay : public testing::Test {
 protected:
  static constexpr double kShareStd = 0.02;
  LongerWay() {
    for (int i = 0; i < 6; ++i) {
      ways_.emplace_back(0.3 * i, 0.1 * i * i, 0.02 * i);
      cameras_.push_back(LookAt(Eigen::Vector3d(-1, -2, 1.4) + ways_.back(), point_));
      PoseUncertainty uncertainty;
      uncertainty.drift.topLeftCorner<3, 3>() =
          kShareStd * kShareStd * ways_.back() * ways_.back().transpose();
      uncertainties_.push_back(uncertainty);
    }
    for (std::size_t i = 1; i < cameras_.size(); ++i)
      views_.push_back({{cameras_[i], uncertainties_[i]}, 1.0 + 0.2 * static_cast<double>(i)});
  }
  Eigen::Matrix3d Told(double size_std) const {
    return SharedError(point_, views_, {cameras_[0], uncertainties_[0]}, size_std);
  }
  const Eigen::Vector3d point_{0.5, 1.5, 0.4};
  std::vector<Eigen::Vector3d> ways_;
  std::vector<Eigen::Isometry3d> cameras_;
  std::vector<PoseUncertainty> uncertainties_;
  std::vector<WeightedView> views_;
};

TEST_F(LongerWay, MovesAPointAsTriangulationByItDoes) {
  const Eigen::Matrix3d told = Told(1e3);
  Random random(RandomKey{5, 0, 0, 0});
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 4000;
  for (int draw = 0; draw < kDraws; ++draw) {
    const double share = kShareStd * random.Gaussian();
    // The point nearest to all lines of sight, from where the cameras are believed to be.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const Eigen::Vector3d ray = (point_ - cameras_[i].translation()).normalized();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
      normal += across;
      right += across * (cameras_[i].translation() + share * ways_[i]);
    }
    const Eigen::Vector3d off = normal.inverse() * right - point_;
    found += off * off.transpose() / kDraws;
  }
  EXPECT_LT((found - told).norm(), 0.06 * told.norm());
  EXPECT_NEAR(std::sqrt(told.trace()), kShareStd * (point_ - cameras_[0].translation()).norm(),
              1e-9);
}

TEST_F(LongerWay, IsLimitedByASizeThatIsKnownAndNothingWherePosesAreExact) {
  EXPECT_NEAR(Told(kShareStd).trace(), Told(1e3).trace() / 2, 1e-3 * Told(1e3).trace());
  EXPECT_LT(Told(1e-4).trace(), 1e-4 * Told(1e3).trace());
  for (PoseUncertainty& uncertainty : uncertainties_) uncertainty = {};
  EXPECT_TRUE(Told(0.02).isZero(0));
  EXPECT_TRUE(SharedError(point_, {}, {cameras_[0], uncertainties_[0]}, 0.02).isZero(0));
}

/// The edge term of poses across the line of sight of a view that is 6 px off.
class ShiftedView : public testing::Test {
 protected:
  ShiftedView() {
    MappingScene& scene = MappingScene::Get();
    const PlacedModel placed = scene.Place("chair", 0, 0, 30);
    const Eigen::Isometry3d world_from_cam = LookAt({1.6, 1.2, 1.3}, {0, 0, 0.4});
    input_ = scene.Input(0, world_from_cam, {&placed, 1});
    truth_ = scene.Hypothesis(placed);
    view_.camera = scene.camera();
    view_.camera.cx += 6;
    view_.cam_from_world = world_from_cam.inverse();
    view_.table = input_.table.get();
  }
  float EdgeTerm(const ScoringView& view) const {
    MappingScene& scene = MappingScene::Get();
    return Evaluate(*scene.scorer(), view, scene.map(), nullptr, {&truth_, 1}, std::nullopt, {})
        .front()
        .phi_edge;
  }
  MapperInput input_;
  PoseHypothesis truth_;
  ScoringView view_;
};

TEST_F(ShiftedView, CostsLittleWhereItIsTold) {
  ScoringView told = view_, exact = view_;
  exact.camera = MappingScene::Get().camera();
  for (const auto& [x, y, weight] :
       {std::tuple{0., 0., 1. / 3}, std::tuple{6., 0., 1. / 6}, std::tuple{-6., 0., 1. / 6},
        std::tuple{0., 6., 1. / 6}, std::tuple{0., -6., 1. / 6}})
    told.shifts.push_back({x, y, weight});
  const float right = EdgeTerm(exact), off = EdgeTerm(view_), marginal = EdgeTerm(told);
  EXPECT_LT(off, 0.5f * right);
  // One of the five is right: log(1/6) / beta below it.
  EXPECT_GT(marginal, right - static_cast<float>(std::log(6.0) / MapperOptions{}.beta));
  EXPECT_LT(marginal, right);
}

}  // namespace
}  // namespace plumbline
