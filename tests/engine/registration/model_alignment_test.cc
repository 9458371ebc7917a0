// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/model_alignment.h"
#include "engine/geometry/random_vector.h"
#include "engine/registration/scale_fit.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/registration/model_refinement.h"
#include "tests/support/alignment_case.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class ModelAlignmentTest : public testing::Test {
 protected:
  std::shared_ptr<const ModelDatabase> models_ = MakeFurnitureDatabase();
  const CadModel& chair_ = models_->model(ModelId{1});  // with arm rests: no symmetry
  std::shared_ptr<const ModelSurface> surface_ = ModelSurface::Prepare(chair_.mesh).value();
  const Eigen::Vector3d up_ = Eigen::Vector3d(0.2, -0.4, 0.7).normalized();

  Eigen::Isometry3d Truth() const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = UprightFrame(-up_).WorldFromObjectRotation(0.8);
    pose.translation() = Eigen::Vector3d(1, -2, 0.5);
    return pose;
  }

  /// Points of the whole surface at the true pose, with normals of the faces.
  TriangleMesh CleanScan(int count, double noise_m, bool upper_half_only = false) const {
    const auto samples = SampleSurface(chair_.mesh, count, 99).value();
    Random random({.seed = 5});
    TriangleMesh scan;
    for (std::size_t i = 0; i < samples.points.size(); ++i) {
      const auto face = surface_->face(samples.triangles[i]);
      if (upper_half_only && samples.points[i].x() > 0) continue;
      const Eigen::Vector3d noise = noise_m * GaussianVector<3>(random);
      scan.vertices.push_back((Truth() * samples.points[i] + noise).cast<float>());
      scan.normals.push_back((Truth().linear() * face.normal).cast<float>());
    }
    return scan;
  }

  Result<ModelAlignment> Align(const TriangleMesh& scan, const Eigen::Isometry3d& start,
                               const AlignOptions& options) const {
    return AlignModel(*ScanTarget::Prepare(scan).value(), *surface_, start, up_, options);
  }

  Eigen::Isometry3d Start(double turn, const Eigen::Vector3d& offset) const {
    Eigen::Isometry3d start = Truth();
    start.linear() = Eigen::AngleAxisd(turn, up_) * start.linear();
    start.translation() += offset;
    return start;
  }
};

TEST_F(ModelAlignmentTest, AScaledModelComesBackWithItsScale) {
  for (const double scale : {0.96, 1.0, 1.05}) {
    TriangleMesh scan = CleanScan(20000, 0.002);
    for (Eigen::Vector3f& point : scan.vertices) {
      const Eigen::Vector3d in_model = Truth().inverse() * point.cast<double>();
      point = (Truth() * Eigen::Vector3d(scale * in_model)).cast<float>();
    }
    const auto target = ScanTarget::Prepare(scan).value();
    const auto start = Start(0.03, {0.01, -0.008, 0.006});
    const auto wide = FitScale(*target, *surface_, 1, start, up_,
                               FreeMotion::kAzimuthAndTranslation, {.mean = 1, .std = 1});
    ASSERT_TRUE(wide.ok()) << wide.error().message;
    EXPECT_TRUE(wide->converged);
    EXPECT_NEAR(wide->scale, scale, 0.002);
    EXPECT_NEAR(wide->scale, scale, 4 * wide->scale_std) << "as it says itself";
    EXPECT_LT(wide->scale_std, 0.005);
    EXPECT_THAT(wide->scan_from_model, IsometryNear(Truth(), 0.2, 0.002));
    // Without the data there would be the prior.
    const auto certain = FitScale(*target, *surface_, 1, start, up_,
                                  FreeMotion::kAzimuthAndTranslation, {.mean = 1, .std = 1e-5});
    EXPECT_NEAR(certain->scale, 1, 1e-3);
    EXPECT_LT(certain->scale_std, 2e-5);
  }
}

TEST_F(ModelAlignmentTest, AnEmptyPlaceHasNoScale) {
  const auto target = ScanTarget::Prepare(CleanScan(3000, 0)).value();
  const auto fit =
      FitScale(*target, *surface_, 1, Start(0, {5, 0, 0}), up_, FreeMotion::kAzimuthAndTranslation);
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.error().code, ErrorCode::kDegenerate);
}

TEST_F(ModelAlignmentTest, IndependentCleanSamplesAreMetToAFractionOfAMillimetre) {
  const auto aligned = Align(CleanScan(30000, 0), Start(2.5, {0.15, 0.1, -0.12}), {});
  ASSERT_TRUE(aligned.ok()) << aligned.error().message;
  const AlignCandidate& best = aligned->candidates[0];
  EXPECT_THAT(best.scan_from_model, IsometryNear(Truth(), 0.02, 0.0002));
  EXPECT_GT(best.fitness, 0.97);
  EXPECT_TRUE(best.converged);
  EXPECT_EQ(aligned->symmetry_order, 1);
}

TEST_F(ModelAlignmentTest, HalfOfANoisySurfaceIsEnough) {
  const auto aligned = Align(CleanScan(30000, 0.005, true), Start(-1.2, {-0.1, 0.15, 0.1}), {});
  ASSERT_TRUE(aligned.ok()) << aligned.error().message;
  EXPECT_THAT(aligned->candidates[0].scan_from_model, IsometryNear(Truth(), 0.3, 0.002));
}

TEST_F(ModelAlignmentTest, LockedDirectionsStayExactlyForEveryMotion) {
  const TriangleMesh scan = CleanScan(8000, 0.005);
  const UprightFrame upright(-up_);
  for (const FreeMotion motion : {FreeMotion::kAzimuth, FreeMotion::kAzimuthAndHorizontal,
                                  FreeMotion::kAzimuthAndTranslation}) {
    AlignOptions options;
    options.motion = motion;
    const Eigen::Vector3d offset =
        motion == FreeMotion::kAzimuth ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(0.05, 0.02, 0);
    const Eigen::Isometry3d start = Start(1, offset);
    const auto aligned = Align(scan, start, options);
    ASSERT_TRUE(aligned.ok());
    for (const AlignCandidate& candidate : aligned->candidates) {
      EXPECT_LE(upright.Tilt(candidate.scan_from_model.linear()), 1e-9);
      const Eigen::Vector3d moved = candidate.scan_from_model.translation() - start.translation();
      if (motion == FreeMotion::kAzimuth) {
        EXPECT_LE(moved.norm(), 1e-12);
      }
      if (motion == FreeMotion::kAzimuthAndHorizontal) {
        EXPECT_LE(std::abs(moved.dot(up_)), 1e-12);
      }
    }
  }
}

/// Errors along the normals of a scan: what fusion leaves, a smooth field of waves in any
/// direction, and independent noise.
struct ScanErrors {
  double smooth_m, longest_wave_m, noise_m;
  bool one_side = false;  ///< Half of the surface is not in the scan.
};

TriangleMesh ScanWithErrors(const SurfaceSamples& samples, const ModelSurface& surface,
                            const Eigen::Isometry3d& scan_from_model, const ScanErrors& errors,
                            Random& random) {
  constexpr int kWaves = 8;
  Eigen::Matrix<double, 4, kWaves> waves;
  for (int k = 0; k < kWaves; ++k) {
    const Eigen::Vector3d direction = GaussianVector<3>(random);
    const double length_m = errors.longest_wave_m * random.Uniform(0.5, 1);
    waves.col(k) << direction.normalized() * 2 * std::numbers::pi / length_m,
        random.Uniform(0, 2 * std::numbers::pi);
  }
  TriangleMesh scan;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3d normal = surface.face(samples.triangles[i]).normal;
    const double field = (waves.transpose() * samples.points[i].homogeneous()).array().cos().sum() *
                         std::sqrt(2.0 / kWaves);
    const double off = errors.smooth_m * field + errors.noise_m * random.Gaussian();
    if (errors.one_side && samples.points[i].x() > 0) continue;
    scan.vertices.push_back((scan_from_model * (samples.points[i] + off * normal)).cast<float>());
    scan.normals.push_back((scan_from_model.linear() * normal).cast<float>());
  }
  return scan;
}

/// The squared error of the four free parameters by their covariance: 4 on average where it is
/// right. At the model's middle, where shift and turn are apart.
double NormalisedErrorSquared(const AlignCandidate& found, const Eigen::Isometry3d& truth,
                              const Eigen::Vector3d& up, const Eigen::Vector3d& middle) {
  const Eigen::Vector3d lever = found.scan_from_model.linear() * middle;
  Eigen::Matrix<double, 4, 6> of_middle = Eigen::Matrix<double, 4, 6>::Zero();
  of_middle.topLeftCorner<3, 3>().setIdentity();
  of_middle.topRightCorner<3, 3>() << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(),
      -lever.x(), 0;
  of_middle.bottomRightCorner<1, 3>() = up.transpose();
  Eigen::Vector4d error;
  error << found.scan_from_model * middle - truth * middle,
      WrapAngle(UprightFrame(-up).Azimuth(found.scan_from_model.linear()) -
                UprightFrame(-up).Azimuth(truth.linear()));
  const Eigen::Matrix4d covariance = of_middle * found.covariance * of_middle.transpose();
  return error.dot(covariance.ldlt().solve(error));
}

TEST_F(ModelAlignmentTest, CovarianceIsHonestForIndependentAndForFusedScans) {
  const auto samples = SampleSurface(chair_.mesh, 12000, 99).value();
  const auto mean_of = [&](const ScanErrors& errors) {
    constexpr int kRuns = 24;
    double sum = 0;
    for (std::uint32_t run = 0; run < kRuns; ++run) {
      Random random({.seed = 11, .frame = run});
      AlignOptions options;
      options.starts = 1;
      const auto aligned = Align(ScanWithErrors(samples, *surface_, Truth(), errors, random),
                                 Start(0.02, {0.01, 0, 0.01}), options);
      EXPECT_TRUE(aligned.ok());
      sum += NormalisedErrorSquared(aligned->candidates[0], Truth(), up_, chair_.center());
    }
    std::printf("smooth %.1f mm, waves to %.1f m, noise %.1f mm%s: %.2f\n", 1e3 * errors.smooth_m,
                errors.longest_wave_m, 1e3 * errors.noise_m, errors.one_side ? ", one side" : "",
                sum / kRuns);
    return sum / kRuns;
  };
  // 4 +- 0.6 where independent; the covariance itself is estimated from some 20 patches.
  for (const bool one_side : {false, true}) {
    const double independent = mean_of({0, 0.4, 0.003, one_side});
    EXPECT_GT(independent, 2.5);
    EXPECT_LT(independent, 6);
    for (const double longest_wave_m : {0.2, 0.4, 0.8}) {
      const double fused = mean_of({0.003, longest_wave_m, 0.0005, one_side});
      EXPECT_GT(fused, 1.2);
      EXPECT_LT(fused, 7);
    }
  }
}

TEST_F(ModelAlignmentTest, SixDegreesOfFreedomAlsoFindTheTilt) {
  AlignOptions options;
  options.motion = FreeMotion::kRigid;
  Eigen::Isometry3d start = Start(0.2, {0.03, 0, 0.02});
  start.linear() = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()) * start.linear();
  const auto aligned = Align(CleanScan(30000, 0), start, options);
  ASSERT_TRUE(aligned.ok());
  EXPECT_THAT(aligned->candidates[0].scan_from_model, IsometryNear(Truth(), 0.02, 0.0002));
}

TEST_F(ModelAlignmentTest, ThePointToPointEndAlsoKeepsUprightAndComesNear) {
  const auto target = ScanTarget::Prepare(CleanScan(30000, 0.002)).value();
  const Eigen::Isometry3d start = Start(0.02, {0.005, 0.005, 0.005});
  const AlignmentCrop crop = CropScan(*target, *surface_, start, up_, 0.2);
  ConstrainedPose pose(start, up_, FreeMotion::kAzimuthAndTranslation);
  AlignFinely(crop, *surface_, IcpResidual::kPointToPoint, 200, pose);
  EXPECT_LE(UprightFrame(-up_).Tilt(pose.scan_from_model().linear()), 1e-9);
  EXPECT_THAT(pose.scan_from_model(), IsometryNear(Truth(), 0.3, 0.003));
}

TEST_F(ModelAlignmentTest, IsTheSameOnOneThreadAndOnMany) {
  const AlignmentCase test = MakeAlignmentCase(*models_, ModelId{1}, 3);
  const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
  const auto align = [&] {
    return AlignModel(*target, *surface_, test.start, test.up_in_scan, {}).value();
  };
  const ModelAlignment many = align();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ModelAlignment single = align();
  ASSERT_EQ(many.candidates.size(), single.candidates.size());
  for (std::size_t i = 0; i < many.candidates.size(); ++i) {
    EXPECT_EQ(many.candidates[i].scan_from_model.matrix(),
              single.candidates[i].scan_from_model.matrix());
    EXPECT_EQ(many.candidates[i].covariance, single.candidates[i].covariance);
  }
}

TEST_F(ModelAlignmentTest, AmongClutterFromOneSideTheRightPlaceWins) {
  int good = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const AlignmentCase test = MakeAlignmentCase(*models_, ModelId{1}, 40 + seed);
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    const auto aligned = AlignModel(*target, *surface_, test.start, test.up_in_scan, {});
    ASSERT_TRUE(aligned.ok());
    const Eigen::Isometry3d& found = aligned->candidates[0].scan_from_model;
    EXPECT_LE(UprightFrame(-test.up_in_scan).Tilt(found.linear()), 1e-9);
    good += (found.translation() - test.scan_from_model.translation()).norm() < 0.02;
  }
  EXPECT_GE(good, 5);
}

TEST_F(ModelAlignmentTest, AChairOfWhichOnlyTheBackIsSeenStandsOnTheFloor) {
  AlignmentCaseOptions under_table;
  under_table.under_table = true;
  AlignOptions options;
  options.standing = Standing::kOnSupport;
  int good = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const AlignmentCase test = MakeAlignmentCase(*models_, ModelId{1}, 60 + seed, under_table);
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    const auto aligned = AlignModel(*target, *surface_, test.start, test.up_in_scan, options);
    ASSERT_TRUE(aligned.ok());
    const AlignCandidate& best = aligned->candidates[0];
    EXPECT_LE(UprightFrame(-test.up_in_scan).Tilt(best.scan_from_model.linear()), 1e-9);
    good += best.stands &&
            (best.scan_from_model.translation() - test.scan_from_model.translation()).norm() < 0.02;
  }
  EXPECT_GE(good, 5);
}

TEST_F(ModelAlignmentTest, AFloorThatIsKnownHelpsWhereItWasNotScanned) {
  // The upper part of the back alone: by itself it slides along up.
  TriangleMesh scan = CleanScan(30000, 0.003);
  const TriangleMesh all = scan;
  scan.vertices.clear();
  scan.normals.clear();
  for (std::size_t i = 0; i < all.vertices.size(); ++i) {
    const double height = up_.dot(all.vertices[i].cast<double>() - Truth().translation());
    if (height < 0.5 || height > 0.8) continue;
    scan.vertices.push_back(all.vertices[i]);
    scan.normals.push_back(all.normals[i]);
  }
  AlignOptions options;
  options.standing = Standing::kOnSupport;
  options.floor_in_scan = (Eigen::Vector4d() << up_, -up_.dot(Truth().translation())).finished();
  const auto aligned = Align(scan, Start(1, 0.15 * up_), options);
  ASSERT_TRUE(aligned.ok());
  EXPECT_TRUE(aligned->candidates[0].stands);
  for (const AlignCandidate& candidate : aligned->candidates) {
    const double height_m =
        up_.dot(candidate.scan_from_model.translation() - Truth().translation());
    // What stands is on the floor exactly; the rest is not near it.
    EXPECT_NEAR(candidate.stands ? height_m : 0, 0, 1e-12);
    EXPECT_TRUE(candidate.stands || std::abs(height_m) > 0.02);
  }
}

TEST_F(ModelAlignmentTest, AFloorHoldsWhatStandsOnItButNotWhatIsFixed) {
  // The scan is 1.5 cm above the floor that is known: scans are less flat than floors.
  const TriangleMesh scan = CleanScan(15000, 0.003);
  AlignOptions options;
  options.standing = Standing::kOnSupport;
  options.floor_in_scan =
      (Eigen::Vector4d() << up_, -up_.dot(Truth().translation()) + 0.015).finished();
  const auto height_m = [&](const Result<ModelAlignment>& aligned) {
    return up_.dot(aligned->candidates[0].scan_from_model.translation() - Truth().translation());
  };
  const auto standing = Align(scan, Start(1, {0.1, 0, 0.05}), options);
  ASSERT_TRUE(standing.ok());
  EXPECT_NEAR(height_m(standing), -0.015, 1e-12);
  EXPECT_NEAR(DeviationsOf(standing->candidates[0].covariance, up_).height_m, 0, 1e-9);
  const Eigen::Isometry3d start = Start(1, 0.01 * up_);
  options.motion = FreeMotion::kAzimuthAndHorizontal;
  EXPECT_NEAR(height_m(Align(scan, start, options)), 0.01, 1e-12) << "its height was given";
}

TEST_F(ModelAlignmentTest, RefiningGoesStepByStepFromWhereItIs) {
  const auto target = ScanTarget::Prepare(CleanScan(30000, 0)).value();
  const Eigen::Isometry3d start = Start(0.05, {0.03, 0.02, -0.02});
  std::vector<ModelRefinement> steps;
  const auto refined =
      RefineModel(*target, *surface_, start, up_, FreeMotion::kAzimuthAndTranslation,
                  [&](const ModelRefinement& now) { steps.push_back(now); });
  ASSERT_TRUE(refined.ok()) << refined.error().message;
  EXPECT_THAT(refined->scan_from_model, IsometryNear(Truth(), 0.02, 0.0002));
  EXPECT_TRUE(refined->converged);
  EXPECT_LT(refined->fit.rmse_m, refined->before.rmse_m);
  ASSERT_EQ(steps.size(), static_cast<std::size_t>(refined->iterations));
  EXPECT_EQ(steps.back().scan_from_model.matrix(), refined->scan_from_model.matrix());
  const PoseChange change = ChangeBetween(start, refined->scan_from_model, up_);
  EXPECT_NEAR(change.azimuth_rad, -0.05, 1e-3);
  EXPECT_NEAR(change.tilt_rad, 0, 1e-9);
  EXPECT_NEAR(change.height_m, -up_.dot(Eigen::Vector3d(0.03, 0.02, -0.02)), 1e-3);
  const auto nowhere = RefineModel(*target, *surface_, Start(0, {9, 9, 9}), up_,
                                   FreeMotion::kAzimuthAndTranslation, [](const auto&) {});
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kDegenerate);
}

TEST_F(ModelAlignmentTest, TellsHowFarPointsAreFromTheScan) {
  const auto target = ScanTarget::Prepare(CleanScan(30000, 0)).value();
  const std::vector<Eigen::Vector3f> points = {chair_.mesh.vertices[0], {0, 0, 9}};
  const auto distances = DistancesToScan(*target, points, Truth(), 0.1);
  ASSERT_EQ(distances.size(), 2u);
  EXPECT_GE(distances[0], 0);
  EXPECT_LT(distances[0], 0.02f);
  EXPECT_EQ(distances[1], -1);
}

TEST_F(ModelAlignmentTest, WhatHangsIsFoundWhereItHangs) {
  // 25 cm above a floor; the model is told to stand, but all of it is seen up there.
  TriangleMesh scan = CleanScan(15000, 0.003);
  const Eigen::Matrix3d level = UprightFrame(-up_).upright_rotation();
  for (int i = 0; i < 120; ++i) {
    for (int k = 0; k < 120; ++k) {
      const Eigen::Vector3d on_floor(0.015 * i - 0.9, 0.015 * k - 0.9, -0.25);
      scan.vertices.push_back((Truth().translation() + level * on_floor).cast<float>());
      scan.normals.push_back(up_.cast<float>());
    }
  }
  for (const Standing standing : {Standing::kAnywhere, Standing::kOnSupport}) {
    AlignOptions options;
    options.standing = standing;
    const auto aligned = Align(scan, Start(1, {0.1, 0, 0.05}), options);
    ASSERT_TRUE(aligned.ok());
    EXPECT_THAT(aligned->candidates[0].scan_from_model, IsometryNear(Truth(), 0.2, 0.002));
    EXPECT_FALSE(aligned->candidates[0].stands);
  }
}

TEST_F(ModelAlignmentTest, CandidatesAreRankedAndDistinct) {
  const auto aligned = Align(CleanScan(20000, 0.002), Start(1, {0.1, 0, 0}), {});
  ASSERT_TRUE(aligned.ok());
  const auto& candidates = aligned->candidates;
  ASSERT_GT(candidates.size(), 1u);
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    EXPECT_GE(candidates[i - 1].score, candidates[i].score);
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::Isometry3d between =
          candidates[k].scan_from_model.inverse() * candidates[i].scan_from_model;
      EXPECT_TRUE(Eigen::AngleAxisd(between.linear()).angle() > 0.087 ||
                  (between * surface_->middle() - surface_->middle()).norm() > 0.02);
    }
  }
}

TEST(ModelSurface, KnowsItsSymmetry) {
  const auto order = [](const TriangleMesh& mesh) {
    return ModelSurface::Prepare(mesh).value()->SymmetryOrder(0.01);
  };
  EXPECT_EQ(order(MakeChair(true)), 1);
  EXPECT_EQ(order(MakeTable()), 2);
  EXPECT_EQ(order(MakeBox({-0.3f, -0.3f, 0}, {0.3f, 0.3f, 0.5f})), 4);
  EXPECT_EQ(order(MakeCylinder(0.1f, 0.3f, 48)), 0);
}

TEST(ModelSurface, NormalsFaceOutWhateverTheOrderOfTheCorners) {
  TriangleMesh box = MakeBox({-0.2f, -0.2f, -0.2f}, {0.2f, 0.2f, 0.2f});
  for (std::size_t i = 0; i < box.triangles.size(); i += 2) {
    std::swap(box.triangles[i][0], box.triangles[i][1]);
  }
  const auto surface = ModelSurface::Prepare(box).value();
  for (std::size_t i = 0; i < surface->samples().points.size(); ++i) {
    EXPECT_GT(surface->samples().points[i].dot(surface->samples().normals[i]), 0.1f);
    EXPECT_FALSE(surface->two_sided()[i]);
  }
}

TEST(ModelSurface, WhatIsInsideIsLeftOut) {
  TriangleMesh nested = MakeBox({-0.2f, -0.2f, -0.2f}, {0.2f, 0.2f, 0.2f});
  Append(MakeBox({-0.1f, -0.1f, -0.1f}, {0.1f, 0.1f, 0.1f}), nested);
  const auto surface = ModelSurface::Prepare(nested).value();
  for (const Eigen::Vector3f& point : surface->samples().points) {
    EXPECT_NEAR(point.cwiseAbs().maxCoeff(), 0.2f, 1e-6f);
  }
}

TEST(ModelSurface, AnOpenSheetHasTwoSides) {
  const auto surface =
      ModelSurface::Prepare(MakeParallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})).value();
  EXPECT_TRUE(surface->face(0).two_sided);
  EXPECT_TRUE(surface->two_sided()[0]);
}

TEST_F(ModelAlignmentTest, AmbiguityOfASymmetricModelIsReported) {
  const auto table = ModelSurface::Prepare(MakeTable()).value();
  const auto samples = SampleSurface(MakeTable(), 20000, 4).value();
  TriangleMesh scan;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    scan.vertices.push_back(samples.points[i].cast<float>());
    scan.normals.push_back(table->face(samples.triangles[i]).normal.cast<float>());
  }
  const auto aligned = AlignModel(*ScanTarget::Prepare(scan).value(), *table,
                                  Eigen::Isometry3d::Identity(), Eigen::Vector3d::UnitZ(), {});
  ASSERT_TRUE(aligned.ok());
  EXPECT_EQ(aligned->symmetry_order, 2);
  ASSERT_GE(aligned->candidates.size(), 2u);
  EXPECT_TRUE(aligned->candidates[1].same_by_symmetry);
}

/// A table's top of 1 x 0.6 m, 3 cm thick, and how a scan has it.
class BluntTop : public testing::Test {
 protected:
  std::shared_ptr<const ModelSurface> surface_ =
      ModelSurface::Prepare(MakeBox({-0.5f, -0.3f, 0.7f}, {0.5f, 0.3f, 0.73f})).value();

  /// Its upper side and, where asked for, its rims, all of them so much further out; the points err
  /// by 2 mm.
  static TriangleMesh Scan(float out_m, bool rims) {
    const TriangleMesh box =
        MakeBox({-0.5f - out_m, -0.3f - out_m, 0.7f}, {0.5f + out_m, 0.3f + out_m, 0.73f});
    const SurfaceSamples samples = SampleSurface(box, 60000, 7).value();
    Random random({.seed = 11});
    TriangleMesh scan;
    for (std::size_t i = 0; i < samples.points.size(); ++i) {
      const Eigen::Vector3i& t = box.triangles[static_cast<std::size_t>(samples.triangles[i])];
      const Eigen::Vector3f normal = (box.vertices[t[1]] - box.vertices[t[0]])
                                         .cross(box.vertices[t[2]] - box.vertices[t[0]])
                                         .normalized();
      const bool keep = normal.z() > 0.5f || (rims && std::abs(normal.z()) < 0.5f);
      if (!keep) continue;
      const Eigen::Vector3d noise = GaussianVector<3>(random);
      scan.vertices.push_back((samples.points[i] + 0.002 * noise).cast<float>());
      scan.normals.push_back(normal);
    }
    return scan;
  }

  AlignCandidate Align(const TriangleMesh& scan, FreeMotion motion, double x, double y) const {
    AlignOptions options;
    options.motion = motion;
    options.starts = 1;
    options.search_m = 0.1;
    return AlignModel(*ScanTarget::Prepare(scan).value(), *surface_,
                      Eigen::Isometry3d(Eigen::Translation3d(x, y, 0)), Eigen::Vector3d::UnitZ(),
                      options)
        .value()
        .candidates[0];
  }
};

TEST_F(BluntTop, StandsInTheMiddleOfAScanWhoseRimsAreTooFarOut) {
  // Fused scans are blunt at rims, by 1 to 3 cm. With one scale for all distances, that of the
  // sharp upper side, the model slides along its top until two rims fit and gives up the others.
  const TriangleMesh scan = Scan(0.02f, true);
  for (const FreeMotion motion :
       {FreeMotion::kAzimuthAndHorizontal, FreeMotion::kAzimuthAndTranslation}) {
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.03, -0.02}, {-0.02, 0.03}}) {
      const Eigen::Vector3d at = Align(scan, motion, x, y).scan_from_model.translation();
      // A tenth of what it would be off against one rim.
      EXPECT_NEAR(at.x(), 0, 0.002) << DegreesOfFreedom(motion) << " from " << x << " " << y;
      EXPECT_NEAR(at.y(), 0, 0.002) << DegreesOfFreedom(motion) << " from " << x << " " << y;
    }
  }
}

TEST_F(BluntTop, IsPulledBelowScanThatOverhangsIt) {
  // The upper side alone: nothing faces sideways, but what overhangs an edge is nearer to it than
  // it should be.
  const TriangleMesh scan = Scan(0, false);
  const Eigen::Vector3d at =
      Align(scan, FreeMotion::kAzimuthAndTranslation, 0.025, 0.02).scan_from_model.translation();
  EXPECT_NEAR(at.x(), 0, 0.004) << "twice the noise of the points at the edges";
  EXPECT_NEAR(at.y(), 0, 0.004);
}

TEST_F(ModelAlignmentTest, NothingOutsideTheSearchRadiusIsAnAnswer) {
  AlignOptions options;
  options.starts = 1;
  options.search_m = 0.05;
  const TriangleMesh scan = CleanScan(20000, 0);
  for (const double off_m : {0.04, 0.08, 0.15, 0.3}) {
    const Eigen::Isometry3d start = Start(0.3, {off_m, 0, 0});
    const auto aligned = Align(scan, start, options);
    if (!aligned.ok()) {
      EXPECT_EQ(aligned.error().code, ErrorCode::kDegenerate);
      EXPECT_THAT(aligned.error().message, testing::HasSubstr("within 0.05 m"));
      EXPECT_GT(off_m, 0.05) << "the right place is within reach";
      continue;
    }
    for (const AlignCandidate& candidate : aligned->candidates) {
      EXPECT_LE((candidate.scan_from_model.translation() - start.translation()).norm(), 0.05);
    }
  }
}

TEST_F(ModelAlignmentTest, SaysWhenThereIsNoScanNearTheStart) {
  const auto aligned = Align(CleanScan(5000, 0), Start(0, {5, 5, 5}), {});
  ASSERT_FALSE(aligned.ok());
  EXPECT_EQ(aligned.error().code, ErrorCode::kDegenerate);
  AlignOptions none;
  none.starts = 0;
  EXPECT_FALSE(Align(CleanScan(5000, 0), Start(0, {0, 0, 0}), none).ok());
}

}  // namespace
}  // namespace plumbline
