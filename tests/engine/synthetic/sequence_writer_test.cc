// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/sequence_writer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/geometry/angles.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_database.h"
#include "engine/synthetic/walk.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

SyntheticOptions SmallOptions() {
  SyntheticOptions options;
  options.seed = 3;
  options.frames = 4;
  options.width = 320;
  options.height = 167;
  options.samples_per_pixel = 1;
  options.light_rays = 4;
  options.light_spacing = 10;
  // Any gravity: nothing may assume that an axis is up.
  options.world_from_room = Eigen::Translation3d(3, -2, 5) *
                            Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -0.5).normalized());
  return options;
}

std::map<std::string, std::string> HashesOf(const fs::path& folder) {
  std::map<std::string, std::string> hashes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      hashes[fs::relative(entry.path(), folder).string()] = *HashFile(entry.path());
  }
  return hashes;
}

/// Checks that every pixel of a mask, at its depth, lies within the instance it names; returns the
/// number of instances seen. Rows have the pose of their frame unless another is given.
std::size_t InstancesWhereTheTruthHasThem(
    const fs::path& path, int frames,
    const std::function<Eigen::Isometry3d(int frame, int row)>& pose_of_row = {}) {
  const auto sequence = OpenSequence(path);
  const auto truth = ReadGroundTruth(path / "ground_truth.json");
  const auto models = ModelDatabase::Load(path / "models");
  EXPECT_TRUE(sequence.ok() && truth.ok() && models.ok());
  if (!sequence.ok() || !truth.ok() || !models.ok()) return 0;
  const PinholeCamera& camera = (*sequence)->camera();
  std::set<int> seen;
  for (int frame = 0; frame < frames; ++frame) {
    const std::string name = "00000" + std::to_string(frame) + ".png";
    const cv::Mat mask = cv::imread((path / "masks" / name).string(), cv::IMREAD_UNCHANGED);
    const cv::Mat depth = cv::imread((path / "depth" / name).string(), cv::IMREAD_UNCHANGED);
    EXPECT_TRUE(mask.type() == CV_16U && depth.type() == CV_16U);
    EXPECT_TRUE(mask.size() == depth.size() &&
                mask.size() == cv::Size(camera.width, camera.height));
    for (int y = 0; y < mask.rows; ++y) {
      const Eigen::Isometry3d world_from_cam =
          pose_of_row ? pose_of_row(frame, y) : *(*sequence)->world_from_cam(frame);
      for (int x = 0; x < mask.cols; ++x) {
        const int number = mask.at<std::uint16_t>(y, x);
        if (number == 0) continue;
        seen.insert(number);
        const GroundTruthInstance& instance =
            truth->instances.at(static_cast<std::size_t>(number - 1));
        const double z = depth.at<std::uint16_t>(y, x) / 1000.0;
        const Eigen::Vector2d bearing = camera.Bearing({x, y});
        const Eigen::Vector3d in_object = instance.world_from_object.inverse() * world_from_cam *
                                          Eigen::Vector3d(bearing.x() * z, bearing.y() * z, z);
        Eigen::AlignedBox3d bounds =
            Scaled((*models)->model(*(*models)->Find(instance.model)).bounds, instance.scale);
        bounds.min().array() -= 0.003;  // depth is rounded to millimetres
        bounds.max().array() += 0.003;
        if (bounds.contains(in_object)) continue;
        ADD_FAILURE() << instance.id << " at " << x << ", " << y << " of frame " << frame;
        return 0;
      }
    }
  }
  return seen.size();
}

/// One small sequence for all tests that only read it.
class SyntheticSequence : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const auto summary = WriteSyntheticSequence(SmallOptions(), path(), {});
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    EXPECT_EQ(summary->frames, 4);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static fs::path path() { return folder_->path() / "sequence"; }
  static TemporaryFolder* folder_;
};
TemporaryFolder* SyntheticSequence::folder_ = nullptr;

TEST_F(SyntheticSequence, OpensWithAllItsCompanions) {
  const auto opened = OpenSequence(path());
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  const Sequence& sequence = **opened;
  EXPECT_TRUE(sequence.warnings().empty()) << sequence.warnings().front();
  ASSERT_EQ(sequence.num_frames(), 4);
  EXPECT_EQ(sequence.camera(), SyntheticCamera(SmallOptions()).pinhole);
  EXPECT_TRUE(sequence.has_edges());
  EXPECT_TRUE(sequence.has_proposals());
  ASSERT_TRUE(sequence.models_folder() && sequence.ground_truth_file() && sequence.scene_file());
  EXPECT_TRUE(ModelDatabase::Load(*sequence.models_folder()).ok());
  for (int i = 0; i < 4; ++i) {
    const auto frame = sequence.ReadFrame(i);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame->image.size(), cv::Size(320, 167));
    EXPECT_TRUE(frame->world_from_cam.has_value());
    const auto edges = sequence.ReadEdges(i);
    ASSERT_TRUE(edges.ok() && edges->has_value());
    EXPECT_GT(cv::countNonZero((*edges)->probability), 1000);
    const auto proposals = sequence.ReadProposals(i);
    ASSERT_TRUE(proposals.ok() && proposals->has_value());
    for (const Detection& detection : **proposals) {
      EXPECT_GE(detection.box.x0, 0);
      EXPECT_GE(detection.box.y0, 0);
      EXPECT_LE(detection.box.x1, 319);
      EXPECT_LE(detection.box.y1, 166);
    }
  }
}

TEST_F(SyntheticSequence, StandsOnItsFloorInARotatedWorld) {
  const auto sequence = OpenSequence(path());
  ASSERT_TRUE(sequence.ok());
  const Eigen::Vector3d up = SmallOptions().world_from_room.linear().col(2);
  ASSERT_TRUE((*sequence)->gravity_in_world() && (*sequence)->floor_in_world());
  EXPECT_NEAR(((*sequence)->gravity_in_world().value() + up).norm(), 0, 1e-9);
  const Eigen::Vector4d floor = (*sequence)->floor_in_world().value();
  const auto truth = ReadGroundTruth(path() / "ground_truth.json");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_GE(truth->instances.size(), 5u);
  for (const GroundTruthInstance& instance : truth->instances) {
    EXPECT_EQ(DeviationOf(instance).position_m, 0) << "the truth is exact";
    EXPECT_NEAR(instance.world_from_object.linear().col(2).dot(up), 1, 1e-9);
    const double height = floor.head<3>().dot(instance.world_from_object.translation()) + floor[3];
    EXPECT_GE(height, -1e-9);
    const double limit = instance.category == "tv" ? 0.8 : 0.02;  // on a sideboard, on a rug
    EXPECT_LT(height, limit) << instance.id;
  }
  const double eye = floor.head<3>().dot((*sequence)->world_from_cam(0)->translation()) + floor[3];
  EXPECT_GT(eye, 1.2);
  EXPECT_LT(eye, 1.6);
}

TEST_F(SyntheticSequence, MasksAndDepthAreThoseOfTheTruth) {
  EXPECT_GE(InstancesWhereTheTruthHasThem(path(), 4), 3u);
}

TEST_F(SyntheticSequence, ScanLiesWhereTheRoomIs) {
  const auto scan = ReadMesh(path() / "scene.ply");
  ASSERT_TRUE(scan.ok());
  EXPECT_EQ(scan->colors.size(), scan->vertices.size());
  const Eigen::Isometry3d room_from_world = SmallOptions().world_from_room.inverse();
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3f& vertex : scan->vertices)
    bounds.extend(room_from_world * vertex.cast<double>());
  EXPECT_NEAR(bounds.min().z(), 0, 0.01);
  EXPECT_GT(bounds.max().z(), 2.5);
  EXPECT_GT(bounds.sizes().x(), 5);
}

TEST_F(SyntheticSequence, IsTheSameForAnyNumberOfThreads) {
  const TemporaryFolder other;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  ASSERT_TRUE(WriteSyntheticSequence(SmallOptions(), other.path() / "again", {}).ok());
  EXPECT_EQ(HashesOf(path()), HashesOf(other.path() / "again"));
}

TEST_F(SyntheticSequence, TellsSituationsApart) {
  const auto scene = ReadJson(path() / "scene.json");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->at("scene"), "room");
  EXPECT_EQ(scene->at("frames"), 4);
  EXPECT_EQ(scene->at("situations").size(),
            ReadGroundTruth(path() / "ground_truth.json")->instances.size());
}

TEST(SequenceWriter, FilmsWithAnySensor) {
  struct Sensor {
    int width, height;
    double fov_deg;
  };
  for (const Sensor& sensor :
       {Sensor{320, 240, 60}, Sensor{333, 501, 120}, Sensor{1920, 1080, 90}}) {
    SCOPED_TRACE(std::to_string(sensor.width) + "x" + std::to_string(sensor.height));
    SyntheticOptions options = SmallOptions();
    options.frames = 1;
    options.width = sensor.width;
    options.height = sensor.height;
    options.horizontal_fov_rad = sensor.fov_deg * kRadPerDeg;
    const TemporaryFolder folder;
    const auto summary = WriteSyntheticSequence(options, folder.path() / "sequence", {});
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    const auto sequence = OpenSequence(folder.path() / "sequence");
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    const PinholeCamera& camera = (*sequence)->camera();
    EXPECT_EQ(camera.width, sensor.width);
    EXPECT_EQ(camera.height, sensor.height);
    EXPECT_NEAR(2 * std::atan(0.5 * camera.width / camera.fx) / kRadPerDeg, sensor.fov_deg, 1e-6);
    const auto frame = (*sequence)->ReadFrame(0);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame->image.size(), cv::Size(sensor.width, sensor.height));
    const auto edges = (*sequence)->ReadEdges(0);
    ASSERT_TRUE(edges.ok() && edges->has_value());
    // Lines: about as many as the image is wide and high, not as it has pixels.
    EXPECT_GT(cv::countNonZero((*edges)->probability), 2 * (sensor.width + sensor.height));
    EXPECT_GE(InstancesWhereTheTruthHasThem(folder.path() / "sequence", 1), 2u);
  }
}

TEST(SequenceWriter, WithARollingShutterEachRowHasThePoseOfItsTime) {
  SyntheticOptions options = SmallOptions();
  options.frames = 3;
  options.rolling_shutter_s = -0.05;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "sequence";
  ASSERT_TRUE(WriteSyntheticSequence(options, path, {}).ok());
  const Room room = FurnishRoom(options).value();
  const Walk walk = Walk::Plan(room, options.seed, options.rate_hz).value();
  const auto pose_of_row = [&](int frame, int row) {
    const double t_s = frame / options.rate_hz - 0.05 * (row / 166.0 - 0.5);
    return options.world_from_room * walk.RoomFromCam(t_s);
  };
  EXPECT_GE(InstancesWhereTheTruthHasThem(path, 3, pose_of_row), 2u);
  const auto sequence = OpenSequence(path);
  ASSERT_TRUE(sequence.ok());
  EXPECT_EQ((*sequence)->calibration().cameras.front().camera.rolling_shutter_s, -0.05);
  EXPECT_LT(((*sequence)->world_from_cam(2)->matrix() - pose_of_row(2, 83).matrix()).norm(), 1e-7);
}

TEST(SequenceWriter, RefusesAFolderWithOtherFiles) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "thesis.tex", "years of work").ok());
  const auto summary = WriteSyntheticSequence(SmallOptions(), folder.path(), {});
  ASSERT_FALSE(summary.ok());
  EXPECT_EQ(summary.error().code, ErrorCode::kInvalidInput);
  EXPECT_NE(summary.error().message.find(folder.path().string()), std::string::npos);
  EXPECT_TRUE(fs::exists(folder.path() / "thesis.tex"));
}

TEST(SequenceWriter, ModelsMayBeWrongInSizeAndTheTruthSaysByHowMuch) {
  const TemporaryFolder folder;
  SyntheticOptions options = SmallOptions();
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path() / "right", {}).ok());
  options.model_error = 0.1;
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path() / "wrong", {}).ok());
  EXPECT_GE(InstancesWhereTheTruthHasThem(folder.path() / "wrong", 4), 2u);
  const auto right = ModelDatabase::Load(folder.path() / "right" / "models").value(),
             wrong = ModelDatabase::Load(folder.path() / "wrong" / "models").value();
  const GroundTruth truth = ReadGroundTruth(folder.path() / "wrong" / "ground_truth.json").value();
  std::set<double> scales;
  for (const GroundTruthInstance& instance : truth.instances) {
    scales.insert(instance.scale);
    const Eigen::Vector3f size = wrong->model(*wrong->Find(instance.model)).bounds.sizes(),
                          true_size = right->model(*right->Find(instance.model)).bounds.sizes();
    EXPECT_LT((instance.scale * size.cast<double>() - true_size.cast<double>()).norm(), 1e-4)
        << instance.id;
  }
  EXPECT_EQ(scales, (std::set<double>{0.9, 1.1}));
}

TEST(SequenceWriter, RefusesSenselessOptions) {
  const TemporaryFolder folder;
  SyntheticOptions options;
  options.frames = 0;
  const auto summary = WriteSyntheticSequence(options, folder.path() / "x", {});
  ASSERT_FALSE(summary.ok());
  EXPECT_NE(summary.error().message.find("frames"), std::string::npos);
}

TEST(SequenceWriter, KeepsAReadableSequenceWhenStopped) {
  const TemporaryFolder folder;
  SyntheticOptions options = SmallOptions();
  options.frames = 50;
  std::stop_source stop;
  WorkContext context;
  context.stop = stop.get_token();
  context.report = [&](const Progress& progress) {
    if (progress.stage == "frames" && progress.done == 3) stop.request_stop();
  };
  const auto summary = WriteSyntheticSequence(options, folder.path() / "part", context);
  ASSERT_FALSE(summary.ok());
  EXPECT_EQ(summary.error().code, ErrorCode::kCancelled);
  const auto sequence = OpenSequence(folder.path() / "part");
  ASSERT_TRUE(sequence.ok());
  EXPECT_GE((*sequence)->num_frames(), 3);
  EXPECT_LT((*sequence)->num_frames(), 50);
  EXPECT_TRUE((*sequence)->warnings().empty());
}

}  // namespace
}  // namespace plumbline
