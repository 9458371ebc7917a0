// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/annotator_agreement.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "tests/engine/evaluation/test_scene.h"

namespace plumbline {
namespace {

GroundTruthInstance& Named(GroundTruth& truth, const std::string& id) {
  for (GroundTruthInstance& instance : truth.instances) {
    if (instance.id == id) return instance;
  }
  throw std::out_of_range(id);
}

TEST(CompareAnnotators, TellsEachObjectsDifferenceInTheLevelFrame) {
  GroundTruth first = TestTruth(), second = TestTruth();
  // The scan lies on its side: up is +y.
  Eigen::Isometry3d scan_from_level = Eigen::Isometry3d::Identity();
  scan_from_level.linear() =
      Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Named(first, "chair_A").world_from_object = UprightPose(1.03, 0.04, 0.02, 33);
  Named(first, "table_0").world_from_object = UprightPose(0, 0, 0, 187);  // 2 degrees, by symmetry
  Named(second, "chair_B").id = "seat_7";
  for (GroundTruth* truth : {&first, &second}) {
    truth->gravity_in_world = {0, -1, 0};
    for (GroundTruthInstance& instance : truth->instances)
      instance.world_from_object = scan_from_level * instance.world_from_object;
  }
  first.gravity_in_world = scan_from_level.linear() * Eigen::Vector3d(0, 0, -1);
  const AnnotatorAgreement agreement = CompareAnnotators(first, second, TestDatabase().get());
  ASSERT_EQ(agreement.objects.size(), 5u);
  const AgreedObject& chair = agreement.objects[0];
  EXPECT_NEAR(chair.horizontal_m(), 0.05, 1e-9);
  EXPECT_NEAR(chair.difference_m.z(), 0.02, 1e-9);
  EXPECT_NEAR(*chair.azimuth_rad * kDegPerRad, 3, 1e-6);
  EXPECT_NEAR(chair.position_std_m, std::sqrt((0.0025 + 0.0004) / 2), 1e-9);
  EXPECT_NEAR(*chair.azimuth_std_rad * kDegPerRad, 3 / std::sqrt(2), 1e-6);
  EXPECT_EQ(agreement.objects[1].second.id, "seat_7");
  EXPECT_TRUE(agreement.objects[1].copied);
  EXPECT_NEAR(*agreement.objects[3].azimuth_rad * kDegPerRad, 2, 1e-6);
  EXPECT_FALSE(agreement.objects[4].azimuth_rad.has_value()) << "a round mug";
}

TEST(CompareAnnotators, FindsTheDeviationOfOneAnnotatorFromTheDifferencesOfTwo) {
  constexpr double kSigma_m = 0.01, kHeightSigma_m = 0.004, kSigma_rad = 0.02;
  Random random({.seed = 5});
  GroundTruth first, second;
  for (int i = 0; i < 400; ++i) {
    for (GroundTruth* truth : {&first, &second}) {
      const auto pose = UprightPose(
          3.0 * i + kSigma_m * random.Gaussian(), kSigma_m * random.Gaussian(),
          kHeightSigma_m * random.Gaussian(), kSigma_rad * kDegPerRad * random.Gaussian());
      truth->instances.push_back({"chair_" + std::to_string(i), "chair", "chair", pose});
    }
  }
  const PooledDeviation fine = CompareAnnotators(first, second, nullptr).fine;
  EXPECT_EQ(fine.objects, 400);
  // The deviation of a deviation from n differences is 1 / sqrt(2 n) of it: 3.5 %, 2.5 % for two
  // coordinates; four of them.
  EXPECT_NEAR(fine.horizontal_m, kSigma_m, 0.10 * kSigma_m);
  EXPECT_NEAR(fine.height_m, kHeightSigma_m, 0.14 * kHeightSigma_m);
  EXPECT_NEAR(fine.azimuth_std_rad, kSigma_rad, 0.14 * kSigma_rad);
  EXPECT_NEAR(fine.position_std_m,
              std::sqrt(2 * fine.horizontal_m * fine.horizontal_m + fine.height_m * fine.height_m),
              1e-12);
}

TEST(CompareAnnotators, ListsWhatOnlyOneOfThemPlaced) {
  GroundTruth first = TestTruth(), second = TestTruth();
  Named(first, "mug_0").world_from_object = UprightPose(0.3, 0.9, 0.75, 0);  // too far to be it
  second.instances.erase(second.instances.begin());
  const AnnotatorAgreement agreement = CompareAnnotators(first, second, TestDatabase().get(), 0.5);
  EXPECT_EQ(agreement.objects.size(), 3u);
  ASSERT_EQ(agreement.only_first.size(), 2u);
  EXPECT_EQ(agreement.only_first[0].id, "chair_A");
  ASSERT_EQ(agreement.only_second.size(), 1u);
  EXPECT_EQ(agreement.only_second[0].id, "mug_0");
}

/// Three fine chairs, of which the last was moved by more than the others, a coarse one, and a
/// copied one.
class ExportedDeviations : public testing::Test {
 protected:
  ExportedDeviations() {
    for (int i = 0; i < 5; ++i) {
      const std::string id = "chair_" + std::to_string(i);
      const double off_m = i == 4 ? 0 : i == 2 ? 0.03 : 0.002;
      first_.instances.push_back({id, "chair", "chair", UprightPose(2 * i, 0, 0, 0), i != 3});
      second_.instances.push_back(
          {id, "chair", "chair", UprightPose(2 * i + off_m, 0, 0, i == 4 ? 0 : 1), true});
    }
  }
  GroundTruth first_, second_;
};

TEST_F(ExportedDeviations, ArePooledByQualityAndNeverBelowTheObjectsOwn) {
  SetDeviations(CompareAnnotators(first_, second_, nullptr), first_);
  const double pooled = std::sqrt((2 * 0.002 * 0.002 + 0.03 * 0.03) / 6);
  EXPECT_NEAR(*first_.instances[0].position_std_m, pooled, 1e-12);
  EXPECT_NEAR(*first_.instances[2].position_std_m, 0.03 / std::numbers::sqrt2, 1e-12);
  EXPECT_NEAR(*first_.instances[0].azimuth_std_rad * kDegPerRad, 1 / std::numbers::sqrt2, 1e-9);
  EXPECT_FALSE(first_.instances[3].position_std_m) << "the only coarse one";
  EXPECT_FALSE(first_.instances[4].position_std_m) << "a copy";
}

TEST_F(ExportedDeviations, AnotherModelDoesNotCount) {
  second_.instances[0].model = "stool";
  const AnnotatorAgreement agreement = CompareAnnotators(first_, second_, nullptr);
  ASSERT_EQ(agreement.objects.size(), 5u) << "paired by category";
  EXPECT_FALSE(agreement.objects[0].same_model);
  EXPECT_EQ(agreement.fine.objects, 2);
  SetDeviations(agreement, first_);
  EXPECT_FALSE(first_.instances[1].position_std_m) << "two objects are too few";
}

}  // namespace
}  // namespace plumbline
