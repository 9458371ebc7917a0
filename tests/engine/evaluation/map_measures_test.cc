// SPDX-License-Identifier: Apache-2.0
// What is told of a map beside its own measures: surfaces by every reference, and the criteria of
// other benchmarks.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/evaluation/box_detection.h"
#include "engine/evaluation/placement_success.h"
#include "engine/evaluation/surface_references.h"
#include "engine/geometry/angles.h"
#include "tests/engine/evaluation/test_scene.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

EvaluationOptions Few() {
  EvaluationOptions options;
  options.samples = 4000;
  return options;
}

MapEvaluation Evaluated(const std::vector<EstimatedObject>& map, const GroundTruth& truth,
                        const TriangleMesh* scan = nullptr) {
  return EvaluateMap(map, truth, *TestDatabase(), scan, Few()).value();
}

SurfaceReferences Compared(const std::vector<EstimatedObject>& map, const GroundTruth& truth,
                           const TriangleMesh* scan) {
  return CompareSurfaces(map, truth, *TestDatabase(), scan, Evaluated(map, truth, scan), Few())
      .value();
}

GroundTruth OneTable() {
  GroundTruth truth;
  truth.instances = {{"table_0", "table", "dining table", UprightPose(0, 0, 0, 0), true}};
  return truth;
}

/// The upper side of the table, 1.6 x 0.8 m at 0.75 m, alone.
TriangleMesh TableTop() {
  TriangleMesh scan;
  scan.vertices = {
      {-0.8f, -0.4f, 0.75f}, {0.8f, -0.4f, 0.75f}, {0.8f, 0.4f, 0.75f}, {-0.8f, 0.4f, 0.75f}};
  scan.triangles = {{0, 1, 2}, {0, 2, 3}};
  return scan;
}

TEST(CompareSurfaces, JudgesAgainstTheScanWhatOfItWasScanned) {
  const GroundTruth truth = OneTable();
  const TriangleMesh scan = TableTop();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object.translation().z() = 0.02;
  const SurfaceReferences surfaces = Compared(map, truth, &scan);
  ASSERT_TRUE(surfaces.scanned);
  // Of the box, the top was scanned, and of its sides what lies within 1 cm of the edge.
  const double top = 1.6 * 0.8, rim = 2 * (1.6 + 0.8) * 0.01;
  const double all = 2 * top + 2 * (1.6 + 0.8) * 0.75;
  EXPECT_NEAR(surfaces.scanned->share, (top + rim) / all, 0.025)
      << "three deviations of 4 000 samples";
  // The rim is 0 to 2 cm off, and 2 % of what is judged.
  EXPECT_NEAR(surfaces.scanned->distance.to_triangle.median_m, 0.02, 1e-6);
  EXPECT_NEAR(surfaces.scanned->distance.to_triangle.mean_m, 0.02, 4e-4);
}

TEST(CompareSurfaces, DecidesWhatWasScannedWithoutTheError) {
  // The same part of the table is judged wherever the estimate stands: errors are not cut off at
  // the radius of the decision.
  const GroundTruth truth = OneTable();
  const TriangleMesh scan = TableTop();
  std::vector<double> shares;
  for (const double up_m : {0.0, 0.02, 0.1, 0.3}) {
    std::vector<EstimatedObject> map = PerfectMap(truth);
    map[0].world_from_object.translation().z() = up_m;
    const SurfaceReferences surfaces = Compared(map, truth, &scan);
    EXPECT_NEAR(surfaces.scanned->distance.to_triangle.median_m, up_m, 1e-6);
    shares.push_back(surfaces.scanned->share);
  }
  for (const double share : shares) EXPECT_NEAR(share, shares[0], 1e-12);
}

TEST(CompareSurfaces, ShowsWhatPosedMeshesHide) {
  // The scan says that the table is 2 cm lower than the annotator put its model. A map that agrees
  // with the annotator has no error against his model and 2 cm against the scan.
  const GroundTruth truth = OneTable();
  TriangleMesh scan = TableTop();
  for (Eigen::Vector3f& vertex : scan.vertices) vertex.z() -= 0.02f;
  const SurfaceReferences surfaces = Compared(PerfectMap(truth), truth, &scan);
  EXPECT_LT(surfaces.posed.to_triangle.max_m, 1e-6);
  EXPECT_NEAR(surfaces.scanned->distance.to_triangle.median_m, 0.02, 1e-6);
}

TEST(CompareSurfaces, AlignsByThePaperOntoTheScanAlone) {
  // A corner of three scanned walls fixes all six degrees of freedom: the paper's ICP takes the
  // shift away, and what is left is of other surfaces.
  const GroundTruth truth = OneTable();
  const TriangleMesh scan = BoxMesh(1.6, 0.8, 0.75, 12);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object.translation() = Eigen::Vector3d(0.03, -0.02, 0.04);
  const SurfaceReferences surfaces = Compared(map, truth, &scan);
  ASSERT_TRUE(surfaces.paper);
  EXPECT_LT(surfaces.paper->distance.to_plane.max_m, 1e-5);
  EXPECT_EQ(surfaces.paper->matched, 1);
  EXPECT_LT(*surfaces.paper->mean.translation_m, 1e-5);
  EXPECT_LT(surfaces.visma->to_triangle.max_m, 1e-5);
  EXPECT_GT(surfaces.posed.to_triangle.mean_m, 0.01) << "that row is not aligned";
  EXPECT_GT(surfaces.scanned->distance.to_triangle.mean_m, 0.01);
}

TEST(CompareSurfaces, CountsSpuriousObjectsInFull) {
  const GroundTruth truth = OneTable();
  const TriangleMesh scan = TableTop();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map.push_back({"9", "table", "dining table", UprightPose(0, 0, 3, 0)});
  const SurfaceReferences surfaces = Compared(map, truth, &scan);
  // Half of the samples lie on it (three deviations: 95); of the other half a share was scanned.
  EXPECT_NEAR(surfaces.scanned->distance.to_triangle.samples, 2000 * (1 + surfaces.scanned->share),
              140);
  EXPECT_GT(surfaces.scanned->distance.to_triangle.max_m, 2);
}

TEST(CompareSurfaces, TurnsASymmetricModelToTheSideThatWasScanned) {
  // One narrow side of the table was scanned. The estimate stands the other way round, which looks
  // the same.
  const GroundTruth truth = OneTable();
  TriangleMesh scan;
  scan.vertices = {{0.8f, -0.4f, 0}, {0.8f, 0.4f, 0}, {0.8f, 0.4f, 0.75f}, {0.8f, -0.4f, 0.75f}};
  scan.triangles = {{0, 1, 2}, {0, 2, 3}};
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(0, 0, 0, 180);
  const SurfaceReferences surfaces = Compared(map, truth, &scan);
  EXPECT_GT(surfaces.scanned->share, 0.08);
  EXPECT_LT(surfaces.scanned->distance.to_triangle.median_m, 1e-5);
}

TEST(CompareSurfaces, HasNoRowThatNeedsAScanWithoutOne) {
  const SurfaceReferences surfaces = Compared(PerfectMap(OneTable()), OneTable(), nullptr);
  EXPECT_FALSE(surfaces.scanned);
  EXPECT_FALSE(surfaces.paper);
  EXPECT_FALSE(surfaces.visma);
  const nlohmann::json json = SurfacesToJson(surfaces);
  EXPECT_TRUE(json["scanned"].is_null());
  EXPECT_TRUE(json["posed"]["mean_m"].is_number());
  EXPECT_TRUE(json["posed"]["to_plane"]["mean_m"].is_number());
}

TEST(CompareSurfaces, TellsAllRowsAsJson) {
  const GroundTruth truth = OneTable();
  const TriangleMesh scan = TableTop();
  const nlohmann::json json = SurfacesToJson(Compared(PerfectMap(truth), truth, &scan));
  EXPECT_TRUE(json["scanned"]["share"].is_number());
  for (const char* row : {"scanned", "posed", "paper", "visma"})
    EXPECT_TRUE(json[row]["median_m"].is_number()) << row;
  EXPECT_TRUE(json["paper"]["mean_translation_m"].is_number());
  EXPECT_EQ(json["paper"]["alignment"].size(), 4u);
}

TEST(MeasurePlacement, CountsByTheLimitsOfScan2Cad) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.19, 0, 0, 30 + 19);  // just inside
  map[1].world_from_object = UprightPose(-1, 0.2, 0, -100 + 21);
  map[2].scale = 1.21;
  map[3].world_from_object = UprightPose(0, 0, 0, 5 + 180);    // a table looks the same so
  map[4].world_from_object = UprightPose(0.3, 0.1, 0.75, 77);  // a mug is round
  const PlacementSuccess placement =
      MeasurePlacement(Evaluated(map, truth), truth, *TestDatabase());
  EXPECT_EQ(placement.all.truths, 5);
  EXPECT_EQ(placement.all.right, 3);
  EXPECT_EQ(placement.by_category.at("chair").right, 1);
  EXPECT_EQ(placement.by_category.at("chair").truths, 3);
  EXPECT_NEAR(*placement.category_mean, (1.0 / 3 + 1 + 1) / 3, 1e-12);
  const nlohmann::json json = PlacementToJson(placement);
  EXPECT_EQ(json["scan2cad"]["right"], 3);
  EXPECT_EQ(json["scan2cad"]["by_category"]["chair"]["truths"], 3);
}

TEST(MeasurePlacement, CountsAMissedInstanceAsWrong) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map.pop_back();
  map.push_back({"9", "stool", "chair", UprightPose(5, 5, 0, 0)});
  const PlacementSuccess placement =
      MeasurePlacement(Evaluated(map, truth), truth, *TestDatabase());
  EXPECT_EQ(placement.all.right, 4);
  EXPECT_EQ(placement.all.truths, 5);
  EXPECT_EQ(placement.add.right, 4);
  EXPECT_EQ(MeasurePlacement(Evaluated({}, truth), truth, *TestDatabase()).all.right, 0);
}

TEST(MeasurePlacement, PassesAddForOneOfAKindAndAddSForWhatIsSymmetric) {
  GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.05, 0, 0, 30);         // 5 cm of a diameter of 1.2 m
  map[1].world_from_object = UprightPose(-1, 0.2, 0, -100 + 90);  // ADD is the chord
  map[2].model = "stool";                                         // the wrong one
  map[3].world_from_object = UprightPose(0, 0, 0, 5 + 180);
  const MapEvaluation evaluation = Evaluated(map, truth);
  EXPECT_EQ(MeasurePlacement(evaluation, truth, *TestDatabase()).add.right, 3);
  EXPECT_NEAR(evaluation.matched[0].add->add_m, 0.05, 1e-9);
  EXPECT_FALSE(evaluation.matched[2].add) << "of another model there are no same points";
  EXPECT_GT(evaluation.matched[3].add->add_m, 0.5);
  EXPECT_LT(evaluation.matched[3].add->add_s_m, 1e-6);
  const nlohmann::json json = EvaluationToJson(evaluation, Few());
  EXPECT_NEAR(json["objects"][0]["add_m"].get<double>(), 0.05, 1e-9);
  EXPECT_TRUE(json["objects"][2]["add_s_m"].is_null());
}

BoxDetection Detected(const std::vector<EstimatedObject>& map, const GroundTruth& truth) {
  return MeasureDetection(map, truth, *TestDatabase(), Evaluated({}, truth), Few()).value();
}

/// Two stools of 0.4 x 0.4 x 0.5 m.
GroundTruth TwoStools() {
  GroundTruth truth;
  truth.instances = {{"a", "stool", "chair", UprightPose(0, 0, 0, 0), true},
                     {"b", "stool", "chair", UprightPose(2, 0, 0, 0), true}};
  return truth;
}

TEST(MeasureDetection, GivesTheAreaUnderPrecisionAndRecall) {
  const GroundTruth truth = TwoStools();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  EXPECT_NEAR(*Detected(map, truth).at_50.mean, 1, 1e-12);
  // Right, wrong, right: precision 1 up to recall 1/2, then 2/3.
  map[0].probability = 0.9;
  map[1].probability = 0.5;
  map.push_back({"9", "stool", "chair", UprightPose(5, 0, 0, 0)});
  map[2].probability = 0.7;
  EXPECT_NEAR(*Detected(map, truth).at_50.mean, 0.5 * 1 + 0.5 * 2 / 3, 1e-12);
  EXPECT_EQ(Detected(map, truth).candidates, 3);
  // A second box on what is found already is wrong, and wrong last it costs nothing.
  map[2].world_from_object = UprightPose(0, 0, 0, 0);
  EXPECT_NEAR(*Detected(map, truth).at_50.mean, 0.5 * 1 + 0.5 * 2 / 3, 1e-12);
  map[2].probability = 0.1;
  EXPECT_NEAR(*Detected(map, truth).at_50.mean, 1, 1e-12);
}

TEST(MeasureDetection, AsksForTheOverlap) {
  const GroundTruth truth = TwoStools();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[1].world_from_object = UprightPose(2.2, 0, 0, 0);  // half of it over: IoU 1/3
  EXPECT_NEAR(*Detected(map, truth).at_25.mean, 1, 1e-12);
  EXPECT_NEAR(*Detected(map, truth).at_50.mean, 0.5, 1e-12);
}

TEST(MeasureDetection, AveragesOverTheCategoriesThatAreThere) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map.erase(map.begin() + 3);  // the table
  const BoxDetection detection = Detected(map, truth);
  EXPECT_NEAR(*detection.at_25.mean, 2.0 / 3, 1e-12);
  EXPECT_EQ(detection.at_25.by_category.at("dining table"), 0);
  const nlohmann::json json = DetectionToJson(detection);
  EXPECT_EQ(json["iou_25"]["by_category"]["chair"], 1.0);
  EXPECT_EQ(*Detected({}, truth).at_50.mean, 0);
}

}  // namespace
}  // namespace plumbline
