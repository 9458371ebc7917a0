// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_summary.h"

#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/recording/map_mesh.h"
#include "engine/recording/object_mixture.h"
#include "tests/engine/recording/random_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

ObjectReport Object(int id, ObjectState state) {
  ObjectReport object;
  object.id = {id};
  object.state = state;
  object.category = "chair";
  object.label = {0};
  object.label_probability = {{{0}, 0.75}, {{1}, 0.25}};
  object.world_from_object.translation() = Eigen::Vector3d(id, 0, 0);
  object.world_from_object.linear() =
      Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  object.covariance.diagonal() = Eigen::Vector4d(0.01, 0.02, 0.06, 0.04);
  object.modes = {{{0}, 1, object.world_from_object, 0.3, 0.2}};
  object.first_frame = 2;
  if (state == ObjectState::kConfirmed) object.confirmed_frame = 4;
  object.last_frame = 9;
  object.particles = std::make_shared<std::vector<Particle>>(10);
  return object;
}

std::vector<FrameReport> SmallRun() {
  std::vector<FrameReport> frames(21);
  for (int i = 0; i < 21; ++i) {
    frames[i].frame = i;
    frames[i].timings = {{"score", static_cast<double>(i)}};
    if (i > 10) frames[i].timings.push_back({"spawn", 1.0});
    frames[i].objects = {Object(1, ObjectState::kConfirmed), Object(2, ObjectState::kTentative),
                         Object(3, ObjectState::kRetired)};
  }
  frames[20].skipped = "color/000020.jpg is truncated";
  frames[20].objects.clear();
  return frames;
}

RunHeader Header() {
  RunHeader header = RandomHeader(1);
  header.gravity_in_world = {0, 0, -1};
  return header;
}

void WriteRun(const std::filesystem::path& file) {
  Result<std::unique_ptr<RunWriter>> writer = RunWriter::Create(file, Header());
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  for (const FrameReport& frame : SmallRun()) ASSERT_TRUE((*writer)->Write(frame, {}).ok());
  ASSERT_TRUE((*writer)->Close().ok());
}

TEST(RunSummary, TellsWhatTheMapHolds) {
  RunSummary summary;
  for (const FrameReport& frame : SmallRun()) summary.Add(frame);
  const nlohmann::json json = summary.ToJson(Header(), 3.0);
  EXPECT_EQ(json["frames"], 21);
  EXPECT_EQ(json["skipped"], 1);
  EXPECT_EQ(json["seconds"], 3.0);
  EXPECT_EQ(json["fps"], 7.0);
  EXPECT_EQ(json["timings_ms"]["score"]["mean"], 10.0);
  EXPECT_EQ(json["timings_ms"]["score"]["p95"], 19.0);
  EXPECT_EQ(json["timings_ms"]["spawn"]["p95"], 1.0);
  ASSERT_EQ(json["objects"].size(),
            2u);  // of the last frame that was used; the retired one is gone
  const nlohmann::json& object = json["objects"][0];
  EXPECT_EQ(object["id"], 1);
  EXPECT_EQ(object["model"], "chair_kitchen");
  EXPECT_EQ(object["category"], "chair");
  EXPECT_EQ(object["confirmed"], true);
  EXPECT_NEAR(object["azimuth_deg"].get<double>(), 28.6478897565, 1e-9);
  EXPECT_NEAR(object["position_std_m"].get<double>(), 0.3, 1e-12);
  EXPECT_NEAR(object["azimuth_std_deg"].get<double>(), 11.4591559026, 1e-9);
  EXPECT_EQ(object["label_probability"]["chair_kitchen"], 0.75);
  EXPECT_EQ(object["modes"].size(), 1u);
  EXPECT_EQ(object["covariance"][3][3], 0.04);
  EXPECT_EQ(object["world_from_object"][0][3], 1.0);
  EXPECT_EQ(object["first_frame"], 2);
  EXPECT_EQ(object["confirmed_frame"], 4);
  EXPECT_EQ(object["last_frame"], 9);
  EXPECT_TRUE(json["objects"][1]["confirmed_frame"].is_null());
}

/// Two places 0.8 m apart along x, of 3 : 1, and a quarter turn from one to the other.
ObjectReport InTwoPlaces() {
  ObjectReport object = Object(1, ObjectState::kConfirmed);
  object.world_from_object = Eigen::Translation3d(0, 0, 2) * Eigen::Isometry3d::Identity();
  object.covariance = Eigen::Vector4d(1e-4, 1e-4, 1e-4, 1e-4).asDiagonal();
  const Eigen::Isometry3d other = Eigen::Translation3d(0.8, 0, 2) *
                                  Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
  object.modes = {{{0}, 0.75, object.world_from_object, std::sqrt(3e-4), 0.01},
                  {{0}, 0.25, other, std::sqrt(3e-4), 0.01}};
  std::vector<Particle> particles(4);
  for (std::size_t i = 0; i < 4; ++i) {
    particles[i].rho = std::log(2.0f);
    particles[i].log_weight = std::log(0.25f);
    particles[i].x_c = i == 3 ? 0.4f : 0.0f;
    particles[i].azimuth = i == 3 ? static_cast<float>(std::numbers::pi / 2) : 0.0f;
  }
  object.particles = std::make_shared<const std::vector<Particle>>(particles);
  return object;
}

TEST(RunSummary, SpreadsOverAllModesAndNotOverTheHeaviestAlone) {
  // Of two points with weights p and 1 - p, the variance is p (1 - p) d^2.
  const double xx = 0.75 * 0.25 * 0.64, xa = 0.75 * 0.25 * 0.8 * std::numbers::pi / 2,
               aa = 0.75 * 0.25 * std::numbers::pi * std::numbers::pi / 4;
  ObjectReport object = InTwoPlaces();
  const UprightFrame upright({0, 0, -1});
  Eigen::Matrix4d covariance = MixtureCovariance(object, upright, nullptr);
  EXPECT_NEAR(covariance(0, 0), xx, 1e-6);  // particles are single precision
  EXPECT_NEAR(covariance(0, 3), xa, 1e-6);
  EXPECT_NEAR(covariance(3, 3), aa, 1e-6);
  EXPECT_NEAR(covariance(1, 1), 0, 1e-6);
  RunSummary summary;
  FrameReport report;
  report.objects = {object};
  summary.Add(report);
  const nlohmann::json told = summary.ToJson(Header(), 1)["objects"][0];
  EXPECT_NEAR(told["position_std_m"].get<double>(), std::sqrt(xx), 1e-6);
  EXPECT_NEAR(told["covariance"][0][3].get<double>(), xa, 1e-6);
  EXPECT_NEAR(told["modes"][0]["position_std_m"].get<double>(), std::sqrt(3e-4), 1e-12)
      << "modes tell their own";
  // Without particles: the same between the modes, and what each has of its own.
  object.particles = nullptr;
  covariance = MixtureCovariance(object, upright, nullptr);
  EXPECT_NEAR(covariance(0, 0), xx + 1e-4, 1e-12);
  EXPECT_NEAR(covariance(3, 3), aa + 1e-4, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 1e-4, 1e-12);
}

TEST(RunSummary, ASymmetricShapeIsNotSpreadByItsOwnTurns) {
  CadModel model;
  model.name = "table";
  model.category = "dining table";
  model.mesh.vertices = {{0, 0, 0}};
  model.symmetry.order = 4;
  const auto models = ModelDatabase::FromModels({model});
  const UprightFrame upright({0, 0, -1});
  EXPECT_NEAR(MixtureCovariance(InTwoPlaces(), upright, models.get())(3, 3), 0, 1e-6);
}

TEST(RunSummary, IsTheSameFromTheRunFile) {
  const TemporaryFolder folder;
  WriteRun(folder.path() / "run.plb");
  RunSummary summary;
  for (const FrameReport& frame : SmallRun()) summary.Add(frame);
  const auto reader = RunReader::Open(folder.path() / "run.plb").value();
  nlohmann::json from_file = RunResultJson(*reader).value();
  EXPECT_GT(from_file["seconds"].get<double>(), 0);
  from_file["seconds"] = 3.0;
  from_file["fps"] = 7.0;
  from_file.erase("withdrawn");  // of the file alone: a resumed run has seen only its end
  EXPECT_EQ(from_file, summary.ToJson(Header(), 3.0));
}

TEST(ReadWithdrawn, TellsWhatWasConfirmedAndIsGone) {
  const TemporaryFolder folder;
  std::vector<FrameReport> frames(4);
  for (int i = 0; i < 4; ++i) frames[i].frame = 10 + i;
  frames[0].objects = {Object(1, ObjectState::kConfirmed), Object(2, ObjectState::kConfirmed),
                       Object(3, ObjectState::kTentative), Object(4, ObjectState::kConfirmed)};
  frames[1].objects = frames[0].objects;
  for (const int i : {1, 2, 3})
    frames[1].objects[i].state = ObjectState::kRetired;  // the first lives on
  frames[1].events = {{EventKind::kRetired, {2}, {}, "seen without support", {}},
                      {EventKind::kRetired, {3}, {}, "tentative for too long", {}},
                      {EventKind::kMerged, {4}, {1}, "at one place", {}}};
  for (const int i : {2, 3}) frames[i].objects = {frames[0].objects[0]};
  {
    const auto writer = RunWriter::Create(folder.path() / "run.plb", Header()).value();
    for (const FrameReport& frame : frames) ASSERT_TRUE(writer->Write(frame, {}).ok());
    ASSERT_TRUE(writer->Close().ok());
  }
  const auto reader = RunReader::Open(folder.path() / "run.plb").value();
  const std::vector<WithdrawnObject> withdrawn = ReadWithdrawn(*reader).value();
  ASSERT_EQ(withdrawn.size(), 2u) << "not what was never confirmed, nor what is there";
  EXPECT_EQ(withdrawn[0].id, ObjectId{2});
  EXPECT_EQ(withdrawn[0].category, "chair");
  EXPECT_EQ(withdrawn[0].confirmed_frame, 4);
  EXPECT_EQ(withdrawn[0].withdrawn_frame, 11);
  EXPECT_EQ(withdrawn[0].why, "seen without support");
  EXPECT_FALSE(withdrawn[0].merged_into);
  EXPECT_EQ(withdrawn[1].merged_into, ObjectId{1});
  const nlohmann::json json = RunResultJson(*reader).value()["withdrawn"];
  EXPECT_EQ(json, WithdrawnToJson(withdrawn));
  EXPECT_EQ(json[1]["merged_into"], 1);
}

TEST(ReadEstimates, GivesTheConfirmedObjectsOfARunFileAndOfItsJson) {
  const TemporaryFolder folder;
  WriteRun(folder.path() / "run.plb");
  const auto reader = RunReader::Open(folder.path() / "run.plb").value();
  ASSERT_TRUE(WriteJson(folder.path() / "run.json", RunResultJson(*reader).value()).ok());
  for (const char* name : {"run.plb", "run.json"}) {
    const std::vector<EstimatedObject> estimates = ReadEstimates(folder.path() / name).value();
    ASSERT_EQ(estimates.size(), 1u);
    EXPECT_EQ(estimates[0].id, "1");
    EXPECT_EQ(estimates[0].model, "chair_kitchen");
    EXPECT_EQ(estimates[0].category, "chair");
    EXPECT_THAT(estimates[0].world_from_object,
                IsometryNear(Object(1, ObjectState::kConfirmed).world_from_object, 1e-9, 1e-12));
  }
}

TEST(ReadCandidates, GivesTentativeObjectsTooAndHowLikelyTheyAreThere) {
  const TemporaryFolder folder;
  WriteRun(folder.path() / "run.plb");
  const auto reader = RunReader::Open(folder.path() / "run.plb").value();
  nlohmann::json json = RunResultJson(*reader).value();
  ASSERT_TRUE(WriteJson(folder.path() / "run.json", json).ok());
  for (const char* name : {"run.plb", "run.json"}) {
    const std::vector<EstimatedObject> all = ReadCandidates(folder.path() / name).value();
    ASSERT_EQ(all.size(), 2u) << "not the one that is withdrawn";
    EXPECT_EQ(ConfirmedOf(all).size(), 1u);
    for (const EstimatedObject& object : all)
      EXPECT_DOUBLE_EQ(object.probability, 0.5) << "log odds of 0";
  }
  for (nlohmann::json& object : json["objects"]) object.erase("probability");
  ASSERT_TRUE(WriteJson(folder.path() / "old.json", json).ok());
  for (const EstimatedObject& object : ReadCandidates(folder.path() / "old.json").value())
    EXPECT_EQ(object.probability, object.confirmed ? 1 : 0);
}

TEST(ReadEstimates, SaysWhatIsWrongWithAJsonFile) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.json";
  const auto message = [&](const char* text) {
    std::ofstream(file) << text;
    const auto estimates = ReadEstimates(file);
    return estimates.ok() ? "fine" : estimates.error().message;
  };
  using testing::HasSubstr;
  EXPECT_THAT(message("{}"), HasSubstr("no list 'objects'"));
  EXPECT_THAT(message("[]"), HasSubstr("no list 'objects'"));
  EXPECT_THAT(message(R"({"objects": [{"model": "m"}]})"), HasSubstr("'id'"));
  EXPECT_THAT(message(R"({"objects": [{"id": 3, "model": "m", "category": "c"}]})"),
              HasSubstr("object 3"));
  EXPECT_THAT(message(R"({"objects": [{"id": 3, "model": "m", "category": "c", "confirmed": true,
                         "world_from_object": [[1, 2], [3, 4]]}]})"),
              HasSubstr("4x4 rigid transform"));
  EXPECT_EQ(message(R"({"objects": []})"), "fine");
  EXPECT_THAT(message("{"), HasSubstr("run.json"));
}

TEST(MapMesh, PosesTheModelsAndColoursThemByObject) {
  CadModel model;
  model.name = "triangle";
  model.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  model.mesh.triangles = {{0, 1, 2}};
  const auto database = ModelDatabase::FromModels({model});
  std::vector<EstimatedObject> objects(2,
                                       {"1", "triangle", "chair", Eigen::Isometry3d::Identity()});
  objects[1].world_from_object.translation() = Eigen::Vector3d(0, 0, 2);
  const TriangleMesh mesh = MapMesh(objects, *database).value();
  ASSERT_EQ(mesh.vertices.size(), 6u);
  EXPECT_EQ(mesh.vertices[4], Eigen::Vector3f(1, 0, 2));
  EXPECT_EQ(mesh.triangles[1], Eigen::Vector3i(3, 4, 5));
  EXPECT_EQ(mesh.colors[0], mesh.colors[2]);
  EXPECT_NE(mesh.colors[0], mesh.colors[3]);
  CadModel painted = model;
  painted.name = "painted";
  painted.mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  objects[1].model = "painted";
  const TriangleMesh own =
      MapMesh(objects, *ModelDatabase::FromModels({model, painted}), MapColors::kOwn).value();
  EXPECT_EQ(own.colors[0], (std::array<std::uint8_t, 3>{200, 200, 200})) << "it has none";
  EXPECT_EQ(own.colors[4], painted.mesh.colors[1]);
  objects[0].model = "sofa";
  EXPECT_EQ(MapMesh(objects, *database).error().code, ErrorCode::kNotFound);
}

TEST(RunSummary, OfARunWithoutAUsableFrameNamesTheCommonestCause) {
  RunSummary summary;
  EXPECT_TRUE(summary.CheckAnyFrameUsed("walk").ok()) << "nothing was left to do";
  FrameReport report;
  for (int frame = 0; frame < 9; ++frame) {
    report.skip_cause = frame % 3 == 1 ? SkipCause::kImage : SkipCause::kPose;
    report.skipped = frame % 3 == 1 ? "'color/" + std::to_string(frame) + ".jpg' is damaged"
                                    : "frame " + std::to_string(frame) + " has no camera pose";
    summary.Add(report);
  }
  const Status none = summary.CheckAnyFrameUsed("walk");
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message,
              testing::HasSubstr("none of the 9 frames of 'walk' could be used, 6 of them because "
                                 "of this: frame 0 has no camera pose; "));
  report.skipped.clear();
  summary.Add(report);
  EXPECT_TRUE(summary.CheckAnyFrameUsed("walk").ok());
}

}  // namespace
}  // namespace plumbline
