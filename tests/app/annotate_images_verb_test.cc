// SPDX-License-Identifier: Apache-2.0
// The commands of `annotate` that look at images, as a script meets them.

#include <cmath>
#include <cstdio>

#include <opencv2/imgcodecs.hpp>

#include "engine/dataset/json_fields.h"
#include "engine/geometry/angles.h"
#include "engine/models/mesh_file.h"
#include "tests/app/annotate_command.h"
#include "tests/engine/annotation/checked_room.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// A seat in the origin, six images of its edges, and a project in which it stands elsewhere.
class AnnotateImages : public AnnotateCommand {
 protected:
  void SetUp() override {
    const auto seat = OutlineModel::Prepare(SeatMesh()).value();
    std::string trajectory;
    for (int i = 0; i < 6; ++i) {
      const double angle = 0.5 * i;
      const Eigen::Isometry3d pose =
          LookAt({2 * std::cos(angle), 2 * std::sin(angle), 1.3}, {0, 0, 0.4});
      const AnnotationImage drawn = DrawnImage(i, *seat, Eigen::Isometry3d::Identity(), pose);
      const Eigen::Quaterniond q(pose.linear());
      char line[256];
      std::snprintf(line, sizeof(line), "%.1f %.12f %.12f %.12f %.12f %.12f %.12f %.12f\n", 0.1 * i,
                    pose.translation().x(), pose.translation().y(), pose.translation().z(), q.x(),
                    q.y(), q.z(), q.w());
      trajectory += line;
      Picture("edges/" + FrameName(i) + ".png", drawn.edges.probability);
      Picture("edges/" + FrameName(i) + "_angle.png", drawn.edges.angle);
      Picture("color/" + FrameName(i) + ".png", cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90)));
    }
    Write("walk/camera.json", R"({"model": "pinhole", "width": 640, "height": 480, "fx": 554,
        "fy": 554, "cx": 319.5, "cy": 239.5, "rate_hz": 10})");
    Write("walk/trajectory.txt", trajectory);
    Write("models/models.json", R"({"units": "m", "models": [{"name": "seat", "file": "seat.ply",
        "category": "chair", "support": "floor"}]})");
    ASSERT_TRUE(WritePly(folder_.path() / "models" / "seat.ply", SeatMesh()).ok());
    Write("edits.json", R"([{"edit": "inputs", "scan": "", "models": "models", "sequence": "walk"},
        {"edit": "gravity", "gravity": [0, 0, -1], "floor": [0, 0, 1, 0]},
        {"edit": "add", "instance": {"id": "seat_0", "model": "seat", "category": "chair",
         "scan_from_object": [[1,0,0,0.03],[0,1,0,-0.04],[0,0,1,0.01],[0,0,0,1]]}}])");
    ASSERT_EQ(Run("apply room.json edits.json --create"), 0) << Output();
  }

  void Picture(const std::string& name, const cv::Mat& picture) const {
    const auto file = folder_.path() / "walk" / name;
    std::filesystem::create_directories(file.parent_path());
    ASSERT_TRUE(cv::imwrite(file, picture));
  }
};

TEST_F(AnnotateImages, RefinesAPoseAndSavesIt) {
  ASSERT_EQ(Run("refine room.json --json refined.json"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("1 of 1 moved"));
  const auto pose = IsometryFromJson(Json("room.json")["instances"][0]["scan_from_object"]);
  ASSERT_TRUE(pose);
  EXPECT_THAT(*pose, IsometryNear(Eigen::Isometry3d::Identity(), 0.1, 0.001));
  const nlohmann::json result = Json("refined.json")[0];
  EXPECT_EQ(result["id"], "seat_0");
  EXPECT_NEAR(result["horizontal_m"].get<double>(), 0.05, 0.001);
  EXPECT_NEAR(result["height_m"].get<double>(), -0.01, 0.001);
  EXPECT_GT(result["agreement_after"], 0.9);
  EXPECT_EQ(result["covariance"].size(), 4u);
}

TEST_F(AnnotateImages, RefinesOnTheFramesThatItIsGiven) {
  ASSERT_EQ(Run("refine room.json --among 1:5:2 --json refined.json"), 0) << Output();
  const nlohmann::json result = Json("refined.json")[0];
  EXPECT_LE(result["images"].get<int>() + result["held_out"].get<int>(), 2) << "frames 1 and 3";
  EXPECT_GT(result["agreement_after"], 0.9);
  ASSERT_EQ(Run("check room.json --among 4: --json check.json"), 0) << Output();
  for (const nlohmann::json& frame : Json("check.json")["images"][0]["frames"])
    EXPECT_GE(frame["frame"].get<int>(), 4);
  EXPECT_EQ(Run("refine room.json --among 5:2"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("selects no frames"));
  EXPECT_EQ(Run("refine room.json --among 900: --by images"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("no image shows it"));
}

TEST_F(AnnotateImages, TurnsWhatStandsTheWrongWayRoundWhenAskedTo) {
  Write("turn.json", R"([{"edit": "change", "id": "seat_0",
      "scan_from_object": [[0,-1,0,0.03],[1,0,0,-0.04],[0,0,1,0],[0,0,0,1]]}])");
  ASSERT_EQ(Run("apply room.json turn.json"), 0) << Output();
  const auto turned_by = [&] {
    const auto pose = IsometryFromJson(Json("room.json")["instances"][0]["scan_from_object"]);
    return kDegPerRad * std::atan2(pose->linear()(1, 0), pose->linear()(0, 0));
  };
  ASSERT_EQ(Run("refine room.json"), 0) << Output();
  EXPECT_NEAR(turned_by(), 90, 15) << "it refines where it stands";
  ASSERT_EQ(Run("refine room.json --all-azimuths --json refined.json"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("turned, where the images prefer it"));
  EXPECT_NEAR(turned_by(), 0, 0.2);
  EXPECT_EQ(Json("refined.json")[0]["turned_by_images"], true);
  // What stands right stays.
  ASSERT_EQ(Run("refine room.json --all-azimuths --json refined.json"), 0) << Output();
  EXPECT_EQ(Json("refined.json")[0]["turned_by_images"], false);
  EXPECT_EQ(Run("refine room.json --all-azimuths --by scan"), 1);
}

TEST_F(AnnotateImages, SaysHowWellThePosesAgree) {
  ASSERT_EQ(Run("check room.json --json before.json"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("agreement"));
  ASSERT_EQ(Run("refine room.json --instance seat_0"), 0) << Output();
  ASSERT_EQ(Run("check room.json --json after.json"), 0) << Output();
  const double before = Json("before.json")["images"][0]["agreement"],
               after = Json("after.json")["images"][0]["agreement"];
  EXPECT_LT(before, 0.5);
  EXPECT_GT(after, 0.9);
  ASSERT_EQ(Run("check room.json --frames 0 --json none.json"), 0);
  EXPECT_EQ(Json("none.json")["images"].size(), 0u);
}

TEST_F(AnnotateImages, LeavesLockedObjectsAlone) {
  Write("lock.json", R"([{"edit": "change", "id": "seat_0", "locked": true}])");
  ASSERT_EQ(Run("apply room.json lock.json"), 0);
  const std::string before = ReadFile(folder_.path() / "room.json").value();
  EXPECT_EQ(Run("refine room.json"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("0 of 0 moved"));
  EXPECT_EQ(Run("refine room.json --instance seat_0"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("locked"));
  EXPECT_EQ(Run("refine room.json --instance sofa"), 1);
  EXPECT_EQ(ReadFile(folder_.path() / "room.json").value(), before);
}

TEST_F(AnnotateImages, NeedsASequence) {
  Write("inputs.json", R"([{"edit": "inputs", "scan": "", "models": "models", "sequence": ""}])");
  ASSERT_EQ(Run("apply room.json inputs.json"), 0);
  EXPECT_EQ(Run("refine room.json"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("names no scan and no sequence"));
  EXPECT_EQ(Run("check room.json"), 0);
}

}  // namespace
}  // namespace plumbline
