// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/image_check.h"

#include <set>

#include <gtest/gtest.h>

#include "engine/annotation/check_frames.h"
#include "tests/engine/annotation/checked_room.h"

namespace plumbline {
namespace {

Eigen::Isometry3d Shifted(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

class DrawnSeat : public testing::Test {
 protected:
  ImageCheck Check(const Eigen::Isometry3d& pose, const Occluders& occluders = {}) const {
    return CheckImage(image_, TestCamera(), *seat_, pose, occluders);
  }

  std::shared_ptr<const OutlineModel> seat_ = OutlineModel::Prepare(SeatMesh()).value();
  AnnotationImage image_ =
      DrawnImage(7, *seat_, Eigen::Isometry3d::Identity(), LookAt({2, 1, 1.4}, {0, 0, 0.4}), {});
};

TEST_F(DrawnSeat, AgreesWithItsOwnEdges) {
  const ImageCheck check = Check(Eigen::Isometry3d::Identity());
  EXPECT_EQ(check.frame, 7);
  EXPECT_GT(check.agreement, 0.9);
  EXPECT_LT(check.median_offset_px, 0.5);  // Edges are whole pixels.
  EXPECT_EQ(check.hits.size(), check.outline.samples.size());
}

TEST_F(DrawnSeat, AgreesLessTheFartherItIsMoved) {
  double last = 1;
  for (const double shift : {0.0, 0.01, 0.02, 0.06}) {
    const double agreement = Check(Shifted(0, shift, 0)).agreement;
    EXPECT_LT(agreement, last) << shift;
    last = agreement;
  }
  EXPECT_LT(last, 0.3);
}

TEST_F(DrawnSeat, SaysHowManyPixelsTheEdgeIsAway) {
  // 1 cm to the right of a camera 2.4 m away: 2.3 px, for lines that stand upright.
  const Eigen::Vector3d right = image_.scan_from_cam.linear().col(0);
  const ImageCheck check = Check(Shifted(0.01 * right.x(), 0.01 * right.y(), 0.01 * right.z()));
  std::vector<double> along_x;
  for (std::size_t i = 0; i < check.hits.size(); ++i) {
    const Eigen::Vector2f& normal = check.outline.samples[i].normal;
    if (check.hits[i].strength > 0 && std::abs(normal.x()) > 0.99f) {
      along_x.push_back(check.hits[i].offset_px * normal.x());
    }
  }
  ASSERT_GT(along_x.size(), 20u);
  std::nth_element(along_x.begin(), along_x.begin() + along_x.size() / 2, along_x.end());
  EXPECT_NEAR(along_x[along_x.size() / 2], -2.3, 0.5);
}

TEST_F(DrawnSeat, DoesNotCountEdgesOfAnotherDirection) {
  AnnotationImage turned = image_;
  turned.edges.angle = image_.edges.angle.clone();
  turned.edges.angle.forEach<std::uint8_t>(
      [](std::uint8_t& angle, const int*) { angle = static_cast<std::uint8_t>(angle + 128); });
  const ImageCheck check =
      CheckImage(turned, TestCamera(), *seat_, Eigen::Isometry3d::Identity(), {});
  EXPECT_LT(check.agreement, 0.2);
}

TEST_F(DrawnSeat, IsNotJudgedByWhatIsHidden) {
  const Eigen::Isometry3d board_pose =
      image_.scan_from_cam * Eigen::Translation3d(-0.5, 0.5, 1.2) *
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX());
  const Occluders occluders{
      nullptr, {{OutlineModel::Prepare(BoxMesh({1.0f, 0.02f, 1.0f})).value(), board_pose}}};
  const Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  image_ = DrawnImage(7, *seat_, truth, image_.scan_from_cam, occluders);
  EXPECT_GT(Check(truth, occluders).agreement, 0.9);
  EXPECT_LT(Check(truth).agreement, 0.75);
  EXPECT_LT(Check(truth, occluders).visible_px, 0.8 * Check(truth).visible_px);
}

TEST_F(DrawnSeat, IsTheSameOnAllCores) {
  const auto images = AnnotationImages::FromImages(TestCamera(), {image_, image_, image_});
  const auto checks = CheckImages(*images, *seat_, Shifted(0.01, 0, 0), {});
  ASSERT_EQ(checks.size(), 3u);
  EXPECT_EQ(checks[2].agreement, Check(Shifted(0.01, 0, 0)).agreement);
  EXPECT_DOUBLE_EQ(MeanAgreement(checks), checks[0].agreement);
}

TEST(CheckFrames, LieAllAroundAndAreTheSameEveryTime) {
  const auto sequence = ArcSequence(120, 340, 2.2);
  const auto seat = OutlineModel::Prepare(SeatMesh()).value();
  const AnnotationDocument document;
  const auto choose = [&] {
    return ChooseCheckFrames(*sequence, document, *seat, Eigen::Isometry3d::Identity(), {});
  };
  const auto frames = choose();
  ASSERT_TRUE(frames.ok());
  ASSERT_EQ(frames->size(), 8u);
  std::set<int> sectors;
  for (const CheckFrame& frame : *frames) {
    sectors.insert(static_cast<int>((frame.bearing_rad + 3.15) / 6.3 * 8));
    EXPECT_NEAR(frame.distance_m, 2.4, 0.2);
    EXPECT_EQ(frame.visible, 1);
  }
  EXPECT_GE(sectors.size(), 6u);
  const auto again = choose();
  for (std::size_t i = 0; i < frames->size(); ++i) {
    EXPECT_EQ((*again)[i].frame, (*frames)[i].frame);
  }
}

TEST(CheckFrames, DoNotLookThroughAWall) {
  const auto sequence = ArcSequence(60, 180, 2.2);  // x > 0 first, then x < 0, all y >= 0.
  const auto seat = OutlineModel::Prepare(SeatMesh()).value();
  const Occluders occluders{nullptr,
                            {{OutlineModel::Prepare(BoxMesh({0.05f, 4, 3})).value(),
                              Eigen::Isometry3d(Eigen::Translation3d(0.8, 0, 0))}}};
  const auto frames =
      ChooseCheckFrames(*sequence, {}, *seat, Eigen::Isometry3d::Identity(), occluders);
  ASSERT_TRUE(frames.ok());
  ASSERT_FALSE(frames->empty());
  for (const CheckFrame& frame : *frames) EXPECT_GT(frame.frame, 22) << frame.visible;
}

TEST(CheckFrames, AreNoneWhereNothingShows) {
  const auto seat = OutlineModel::Prepare(SeatMesh()).value();
  const auto frames =
      ChooseCheckFrames(*ArcSequence(20, 90, 2.2), {}, *seat, Shifted(0, 0, 30), {});
  ASSERT_TRUE(frames.ok());
  EXPECT_TRUE(frames->empty());
}

TEST(AnnotationImages, LeavesOutTornFramesWithAWarning) {
  const auto sequence = ArcSequence(5, 40, 2);
  const auto images = AnnotationImages::Load(sequence, {}, {0, 2, 4}, "");
  ASSERT_TRUE(images.ok());
  EXPECT_EQ((*images)->images().size(), 2u);
  ASSERT_EQ((*images)->warnings().size(), 1u);
  EXPECT_NE((*images)->warnings()[0].find("000000.png"), std::string::npos);
  EXPECT_EQ(AnnotationImages::Load(sequence, {}, {0}, "gradient").error().code,
            ErrorCode::kNotFound);
}

}  // namespace
}  // namespace plumbline
