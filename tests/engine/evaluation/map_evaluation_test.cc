// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/map_evaluation.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "tests/engine/evaluation/test_scene.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

MapEvaluation Evaluate(const std::vector<EstimatedObject>& map, const GroundTruth& truth,
                       EvaluationOptions options = {}, const TriangleMesh* scan = nullptr) {
  options.samples = 20000;
  Result<MapEvaluation> result = EvaluateMap(map, truth, *TestDatabase(), scan, options);
  PLB_CHECK(result.ok()) << result.error().message;
  return std::move(*result);
}

TEST(EvaluateMap, FindsNothingWrongWithAPerfectMap) {
  const GroundTruth truth = TestTruth();
  const MapEvaluation evaluation = Evaluate(PerfectMap(truth), truth);
  EXPECT_EQ(evaluation.matched.size(), 5u);
  EXPECT_TRUE(evaluation.missed.empty());
  EXPECT_TRUE(evaluation.spurious.empty());
  EXPECT_LT(evaluation.surface.max_m, 1e-6);
  EXPECT_LT(evaluation.surface_normal.max_m, 1e-6);
  EXPECT_LT(evaluation.completeness.max_m, 1e-6);
  EXPECT_EQ(evaluation.surface.samples, 20000);
  EXPECT_LT(*evaluation.mean_all.translation_m, 1e-12);
  EXPECT_LT(*evaluation.mean_all.rotation_rad, 1e-7);
  for (const MatchedObject& object : evaluation.matched) EXPECT_TRUE(object.model_correct);
}

TEST(EvaluateMap, AveragesFineInstancesAndAllApart) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.03, 0, 0, 36);         // fine: 3 cm, 6 degrees
  map[2].world_from_object = UprightPose(0.1, 1.3, 0, 180 + 20);  // coarse: 10 cm, 20 degrees
  map[3].world_from_object = UprightPose(0, 0, 0, 5 + 180);       // fine: symmetric, no error
  map[4].world_from_object =
      UprightPose(0.3, 0.15, 0.75, 90);  // coarse and round: 5 cm, no rotation
  const MapEvaluation evaluation = Evaluate(map, truth);
  EXPECT_NEAR(*evaluation.mean.translation_m, 0.03 / 3, 1e-9);
  EXPECT_NEAR(*evaluation.mean.rotation_rad, 6 * kRadPerDeg / 3, 1e-9);
  EXPECT_NEAR(*evaluation.mean_all.translation_m, (0.03 + 0.10 + 0.05) / 5, 1e-9);
  EXPECT_NEAR(*evaluation.mean_all.rotation_rad, (6 + 20) * kRadPerDeg / 4,
              1e-9);  // the mug is no part of it
  EXPECT_TRUE(evaluation.matched[4].continuous_symmetry);
  EXPECT_NEAR(evaluation.matched[0].centre_m,
              (map[0].world_from_object * TestDatabase()->models()[0].center() -
               truth.instances[0].world_from_object * TestDatabase()->models()[0].center())
                  .norm(),
              1e-12);
}

TEST(EvaluateMap, MeasuresTheSurfaceOfALiftedTable) {
  GroundTruth truth;
  truth.instances = {{"table_0", "table", "dining table", UprightPose(0, 0, 0, 0), true}};
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object.translation().z() = 0.02;
  const MapEvaluation evaluation = Evaluate(map, truth);
  // Top and bottom are 2 cm off; of the sides only the upper 2 cm overhang.
  EXPECT_NEAR(evaluation.surface.max_m, 0.02, 1e-6);
  const double flat = 2 * 1.6 * 0.8, sides = 2 * (1.6 + 0.8) * 0.75;
  const double overhang = 2 * (1.6 + 0.8) * 0.02;
  EXPECT_NEAR(evaluation.surface.mean_m, (flat * 0.02 + overhang * 0.01) / (flat + sides), 3e-4);
  EXPECT_NEAR(evaluation.matched[0].surface.mean_m, evaluation.surface.mean_m, 1e-12);
  // The overhanging sides lie in the planes of the true sides (or in that of the top edge's other
  // triangle).
  EXPECT_LE(evaluation.surface_normal.mean_m, evaluation.surface.mean_m);
  EXPECT_NEAR(evaluation.completeness.mean_m, evaluation.surface.mean_m, 3e-4);
}

TEST(EvaluateMap, ComparesObjectsAtTheirScales) {
  GroundTruth truth;
  truth.instances = {{"table_0", "table", "dining table", UprightPose(0, 0, 0, 0), true}};
  truth.instances[0].scale = 1.04;
  std::vector<EstimatedObject> map = PerfectMap(truth);
  const MapEvaluation fixed = Evaluate(map, truth);
  // On the floor both stand where they should; the top is 3 cm too low, the centre half of that.
  EXPECT_NEAR(fixed.matched[0].pose.translation_m, 0, 1e-12);
  EXPECT_NEAR(fixed.matched[0].centre_m, 0.5 * 0.04 * 0.75, 1e-6);
  EXPECT_NEAR(fixed.surface.max_m, 0.5 * 0.04 * 1.6, 1e-3);
  map[0].scale = 1.04;
  map[0].scale_std = 0.01;
  const MapEvaluation scaled = Evaluate(map, truth);
  EXPECT_NEAR(scaled.matched[0].centre_m, 0, 1e-12);
  EXPECT_LT(scaled.surface.max_m, 1e-6);
  EXPECT_LT(scaled.completeness.max_m, 1e-6);
  const nlohmann::json json = EvaluationToJson(scaled, {});
  EXPECT_EQ(json["objects"][0]["scale"], 1.04);
  EXPECT_EQ(json["objects"][0]["true_scale"], 1.04);
  EXPECT_FALSE(
      EvaluationToJson(Evaluate(PerfectMap(TestTruth()), TestTruth()), {})["objects"][0].contains(
          "scale"));
}

TEST(EvaluateMap, AgreesWithBruteForceOverAllTrianglesOfTheTruth) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.05, 0.02, 0.01, 39);
  map.pop_back();
  EvaluationOptions options;
  options.samples = 2000;
  const auto database = TestDatabase();
  const MapEvaluation evaluation = EvaluateMap(map, truth, *database, nullptr, options).value();

  TriangleMesh estimated, real;
  for (const EstimatedObject& object : map) {
    Append(
        Transformed(database->model(*database->Find(object.model)).mesh, object.world_from_object),
        estimated);
  }
  for (const GroundTruthInstance& object : truth.instances) {
    Append(
        Transformed(database->model(*database->Find(object.model)).mesh, object.world_from_object),
        real);
  }
  const SurfaceSamples samples = SampleSurface(estimated, options.samples, options.seed).value();
  double sum = 0;
  for (const Eigen::Vector3d& point : samples.points) {
    double best = 1e9;
    for (const Eigen::Vector3i& t : real.triangles) {
      const auto corner = [&](int i) {
        return real.vertices[static_cast<std::size_t>(t[i])].cast<double>().eval();
      };
      best = std::min(
          best, (ClosestPointOnTriangle(point, corner(0), corner(1), corner(2)) - point).norm());
    }
    sum += best;
  }
  // Both round the posed vertices to float, not quite alike.
  EXPECT_NEAR(evaluation.surface.mean_m, sum / options.samples, 1e-6);
}

TEST(EvaluateMap, DoesNotDependOnTheFrameOfTheWorld) {
  GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.05, 0.02, 0.01, 39);
  map[1].world_from_object.translation().z() += 0.03;
  const MapEvaluation expected = Evaluate(map, truth);
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  turn.translation() = Eigen::Vector3d(3, -1, 2);
  truth.gravity_in_world = turn.linear() * truth.gravity_in_world;
  for (GroundTruthInstance& instance : truth.instances)
    instance.world_from_object = turn * instance.world_from_object;
  for (EstimatedObject& object : map) object.world_from_object = turn * object.world_from_object;
  const MapEvaluation turned = Evaluate(map, truth);
  EXPECT_NEAR(turned.surface.mean_m, expected.surface.mean_m, 1e-5);
  EXPECT_NEAR(turned.completeness.mean_m, expected.completeness.mean_m, 1e-5);
  EXPECT_NEAR(*turned.mean.translation_m, *expected.mean.translation_m, 1e-12);
  EXPECT_NEAR(*turned.mean.rotation_rad, *expected.mean.rotation_rad, 1e-9);
  EXPECT_NEAR(turned.matched[1].pose.height_m, 0.03, 1e-12);
}

TEST(EvaluateMap, LeavesIgnoredCategoriesOut) {
  GroundTruth truth = TestTruth();
  truth.instances.push_back(
      {"thing", "not in the database", "container", UprightPose(3, 0, 0, 0), true});
  std::vector<EstimatedObject> map = PerfectMap(TestTruth());
  map.push_back({"9", "mug", "cup", UprightPose(5, 5, 0, 0)});
  EvaluationOptions options;
  options.ignored_categories = {"container", "cup"};
  const MapEvaluation evaluation = Evaluate(map, truth, options);
  EXPECT_EQ(evaluation.matched.size(), 4u);
  EXPECT_TRUE(evaluation.missed.empty());
  EXPECT_TRUE(evaluation.spurious.empty());
  EXPECT_LT(evaluation.surface.max_m, 1e-6);
  EXPECT_LT(evaluation.completeness.max_m, 1e-6);
}

TEST(EvaluateMap, NamesAModelThatTheDatabaseLacks) {
  std::vector<EstimatedObject> map = {{"4", "sofa", "couch", UprightPose(0, 0, 0, 0)}};
  const Result<MapEvaluation> result = EvaluateMap(map, TestTruth(), *TestDatabase(), nullptr, {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(result.error().message,
              testing::AllOf(testing::HasSubstr("object 4"), testing::HasSubstr("'sofa'")));
}

TEST(EvaluateMap, MeasuresToTheScanTheModelsOrBoth) {
  GroundTruth truth;
  truth.instances = {{"table_0", "table", "dining table", UprightPose(0, 0, 0, 0), true}};
  const std::vector<EstimatedObject> map = PerfectMap(truth);
  TriangleMesh scan = BoxMesh(1.6, 0.8, 0.75, 12);  // the top only, and 1 cm high
  for (Eigen::Vector3f& vertex : scan.vertices) vertex.z() = 0.76f;
  EvaluationOptions options;
  EXPECT_LT(Evaluate(map, truth, options, &scan).surface.mean_m, 1e-6);
  options.truth = TruthSurface::kModels;
  EXPECT_LT(Evaluate(map, truth, options, &scan).surface.mean_m, 1e-6);
  options.truth = TruthSurface::kScan;
  EXPECT_GT(Evaluate(map, truth, options, &scan).surface.max_m, 0.7);
  options.samples = 100;
  const Result<MapEvaluation> without = EvaluateMap(map, truth, *TestDatabase(), nullptr, options);
  ASSERT_FALSE(without.ok());
  EXPECT_THAT(without.error().message, testing::HasSubstr("--scene"));
}

TEST(EvaluateMap, JudgesAnEmptyMap) {
  const MapEvaluation evaluation = Evaluate({}, TestTruth());
  EXPECT_EQ(evaluation.missed.size(), 5u);
  EXPECT_EQ(evaluation.surface.samples, 0);
  EXPECT_FALSE(evaluation.mean.translation_m.has_value());
  const nlohmann::json json = EvaluationToJson(evaluation, {});
  EXPECT_TRUE(json["surface"]["mean_m"].is_null());
  EXPECT_TRUE(json["mean_translation_m"].is_null());
  EXPECT_EQ(json["missed"], 5);
}

TEST(EvaluateMap, AlignsMapsFromAnotherFrame) {
  const GroundTruth truth = TestTruth();
  const Eigen::Isometry3d moved = UprightPose(0.08, -0.05, 0.03, 5);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  for (EstimatedObject& object : map) object.world_from_object = moved * object.world_from_object;
  EvaluationOptions options;
  EXPECT_GT(*Evaluate(map, truth, options).mean.translation_m, 0.05);
  for (const Alignment align : {Alignment::kObjects, Alignment::kIcp, Alignment::kIcp4}) {
    options.align = align;
    const MapEvaluation evaluation = Evaluate(map, truth, options);
    EXPECT_THAT(evaluation.truth_from_estimate, IsometryNear(moved.inverse(), 1e-3, 1e-5));
    EXPECT_LT(*evaluation.mean.translation_m, 1e-4);
    EXPECT_LT(evaluation.surface.mean_m, 1e-4);
    EXPECT_LT(evaluation.completeness.mean_m, 1e-4);
    EXPECT_EQ(evaluation.matched.size(), 5u);
  }
}

TEST(EvaluateMap, TakesTheAlignmentOfTheTrajectories) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  const Eigen::Isometry3d moved =  // farther than objects are matched
      Eigen::Translation3d(3, -2, 0.4) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ());
  for (EstimatedObject& object : map) object.world_from_object = moved * object.world_from_object;
  EvaluationOptions options;
  options.truth_from_estimate = moved.inverse();
  EXPECT_TRUE(Evaluate(map, truth, options).matched.empty()) << "none is none";
  for (const Alignment align :
       {Alignment::kTrajectory, Alignment::kObjects, Alignment::kIcp, Alignment::kIcp4}) {
    options.align = align;
    const MapEvaluation evaluation = Evaluate(map, truth, options);
    EXPECT_THAT(evaluation.truth_from_estimate, IsometryNear(moved.inverse(), 1e-3, 1e-5));
    EXPECT_EQ(evaluation.matched.size(), 5u);
    EXPECT_LT(*evaluation.mean.translation_m, 1e-4);
  }
}

TEST(EvaluateMap, WritesTheKeysOfTheDesign) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].model = "stool";
  const nlohmann::json json = EvaluationToJson(Evaluate(map, truth), {});
  for (const char* key :
       {"alignment", "surface", "surface_normal", "completeness", "objects", "matched", "missed",
        "spurious", "mean_translation_m", "mean_rotation_deg", "all"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["alignment"], nlohmann::json::parse("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"));
  for (const char* key : {"mean_m", "median_m", "std_m", "max_m", "samples"}) {
    EXPECT_TRUE(json["surface"][key].is_number()) << key;
    EXPECT_TRUE(json["surface_normal"][key].is_number()) << key;
    EXPECT_TRUE(json["completeness"][key].is_number()) << key;
  }
  const nlohmann::json& object = json["objects"][0];
  for (const char* key :
       {"id", "model", "ground_truth", "quality", "model_correct", "translation_m", "rotation_deg",
        "azimuth_deg", "tilt_deg", "height_m", "centre_m", "surface_mean_m", "truth_position_std_m",
        "truth_azimuth_std_deg"}) {
    EXPECT_TRUE(object.contains(key)) << key;
  }
  EXPECT_EQ(object["ground_truth"], "chair_A");
  EXPECT_EQ(object["quality"], "fine");
  EXPECT_EQ(object["model_correct"], false);
  EXPECT_TRUE(json["all"]["mean_translation_m"].is_number());
  EXPECT_TRUE(json["all"]["mean_rotation_deg"].is_number());
  EXPECT_TRUE(json["objects"][4]["azimuth_deg"].is_null());
}

}  // namespace
}  // namespace plumbline
