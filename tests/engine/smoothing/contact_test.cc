// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/contact.h"

#include <gtest/gtest.h>

#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

class ContactBetween : public testing::Test {
 protected:
  SolidModel Solid(const char* name) const {
    return SolidModel::Prepare(database_->model(database_->Find(name).value())).value();
  }
  static Eigen::Isometry3d At(double x, double y, double z = 0) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(x, y, z);
    return pose;
  }
  std::shared_ptr<const ModelDatabase> database_ = MakeFurnitureDatabase();
};

TEST_F(ContactBetween, TwoCratesIsAsDeepAsTheyOverlap) {
  const SolidModel crate = Solid("crate");  // 0.4 x 0.24 x 0.3 m
  const auto contact = FindContact(crate, At(0.35, 0.02), crate, At(0, 0));
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact->depth_m, 0.05, 0.003) << "up to how densely the surface is sampled";
  EXPECT_NEAR(contact->direction.x(), 1, 1e-6);
  const auto reverse = FindContact(crate, At(0, 0), crate, At(0.35, 0.02));
  ASSERT_TRUE(reverse);
  EXPECT_NEAR(reverse->direction.x(), -1, 1e-6);
}

TEST_F(ContactBetween, ThingsBesideOneAnotherIsNone) {
  const SolidModel crate = Solid("crate");
  EXPECT_FALSE(FindContact(crate, At(0.41, 0), crate, At(0, 0)));
  EXPECT_FALSE(FindContact(crate, At(0, 0, 0.31), crate, At(0, 0))) << "one stands on the other";
  EXPECT_FALSE(FindContact(crate, At(3, 0), crate, At(0, 0)));
}

TEST_F(ContactBetween, AChairUnderATableIsNone) {
  // Its back stays outside, the seat is below the top and between the legs.
  EXPECT_FALSE(FindContact(Solid("chair"), At(-0.55, 0), Solid("table"), At(0, 0)));
}

}  // namespace
}  // namespace plumbline
