// SPDX-License-Identifier: Apache-2.0
// The commands `evaluate` and `export` as a script meets them.

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/mapping/map_report.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/run_file.h"
#include "tests/support/program_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class EvaluateVerb : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_.path() / "models");
    TriangleMesh wedge;  // 1 m long, 0.5 m wide, 0.25 m high
    wedge.vertices = {
        {-0.5f, -0.25f, 0}, {0.5f, -0.25f, 0}, {-0.5f, 0.25f, 0}, {-0.5f, -0.25f, 0.25f}};
    wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    Check(WritePly(folder_.path() / "models" / "wedge.ply", wedge));
    Write("models/models.json", R"({"units": "m", "models": [{"name": "wedge", "file": "wedge.ply",
        "category": "chair", "symmetry": {"axis": [0, 0, 1], "order": 1}, "support": "floor"}]})");
    Write("truth.json", R"({"gravity": [0, 0, -1], "instances": [
        {"id": "a", "model": "wedge", "category": "chair", "quality": "fine", "visible_frames": [[0, 9]],
         "world_from_object": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},
        {"id": "b", "model": "wedge", "category": "chair", "quality": "coarse", "note": "ignored",
         "world_from_object": [[1,0,0,3],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
    WriteRun();
  }

  static void Check(const Status& status) { PLB_CHECK(status.ok()) << status.error().message; }
  void Write(const char* name, const char* text) {
    Check(WriteFileAtomically(folder_.path() / name, text));
  }

  /// One confirmed wedge, 4 cm off 'a', and a tentative one.
  void WriteRun(double x = 0.04, std::uint64_t seed = 0) {
    RunHeader header;
    header.recipe.seed = seed;
    header.models = {{"wedge", "chair"}};
    header.recipe.models = folder_.path() / "models";
    FrameReport report;
    for (int id : {1, 2}) {
      ObjectReport object;
      object.id = {id};
      object.state = id == 1 ? ObjectState::kConfirmed : ObjectState::kTentative;
      object.category = "chair";
      object.label = {0};
      object.label_probability = {{{0}, 1.0}};
      object.world_from_object.translation() = Eigen::Vector3d(x, 0, 0);
      report.objects.push_back(object);
    }
    const auto writer = RunWriter::Create(folder_.path() / "run.plb", header).value();
    Check(writer->Write(report, {}));
    Check(writer->Close());
  }

  /// Standard output and error.
  ProgramRun Run(const std::string& arguments) {
    return RunProgram(arguments + " 2>&1", folder_.path());
  }

  TemporaryFolder folder_;
};

TEST_F(EvaluateVerb, TellsHowWellTheTruthItselfIsKnown) {
  std::filesystem::rename(folder_.path() / "truth.json", folder_.path() / "usual.json");
  Write("truth.json", R"({"gravity": [0, 0, -1], "instances": [
      {"id": "a", "model": "wedge", "category": "chair", "position_std_m": 0.008,
       "azimuth_std_deg": 0.7, "world_from_object": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const ProgramRun usual = Run("evaluate run.plb --ground-truth usual.json --models models");
  EXPECT_THAT(usual.output, testing::Not(HasSubstr("truth +-"))) << "its file does not say";
  const ProgramRun outcome =
      Run("evaluate run.plb --ground-truth truth.json --models models --json result.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("truth +-0.8 cm 0.7 deg"));
  const nlohmann::json object = ReadJson(folder_.path() / "result.json").value()["objects"][0];
  EXPECT_DOUBLE_EQ(object["truth_position_std_m"], 0.008);
  EXPECT_NEAR(object["truth_azimuth_std_deg"], 0.7, 1e-12);
}

TEST_F(EvaluateVerb, JudgesARunFile) {
  const ProgramRun outcome =
      Run("evaluate run.plb --ground-truth truth.json --models models --json result.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("matched 1, missed 1, spurious 0"));
  EXPECT_THAT(outcome.output, HasSubstr("needs --scene"));
  EXPECT_THAT(outcome.output, testing::Not(HasSubstr("1.39 - 2.79"))) << "without the paper's row";
  const nlohmann::json json = ReadJson(folder_.path() / "result.json").value();
  EXPECT_EQ(json["matched"], 1);
  EXPECT_EQ(json["missed"], 1);
  EXPECT_EQ(json["missed_instances"][0]["why"]["cause"], "not_seen") << "a run of a few frames";
  EXPECT_THAT(outcome.output, HasSubstr("Not seen: "));
  EXPECT_EQ(json["spurious"], 0);
  EXPECT_EQ(json["objects"][0]["ground_truth"], "a");
  EXPECT_NEAR(json["mean_translation_m"].get<double>(), 0.04, 1e-12);
  EXPECT_EQ(json["surface"]["samples"], 500000);
}

TEST_F(EvaluateVerb, PutsThePapersNumbersBesideThePapersRuleAlone) {
  const ProgramRun outcome =
      Run("evaluate run.plb --ground-truth truth.json --models models --scene models/wedge.ply "
          "--samples 5000 --json result.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  std::istringstream lines(outcome.output);
  int with_numbers = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("1.39 - 2.79") == std::string::npos) continue;
    ++with_numbers;
    EXPECT_THAT(line, testing::StartsWith("by the paper's rule"));
  }
  EXPECT_EQ(with_numbers, 1);
  const nlohmann::json json = ReadJson(folder_.path() / "result.json").value();
  const nlohmann::json& surfaces = json["surfaces"];
  EXPECT_NEAR(surfaces["scanned"]["share"].get<double>(), 1, 0.05) << "the scan is the object";
  // 4 cm along the wedge: its faces slide, its ends are off.
  EXPECT_GT(surfaces["posed"]["mean_m"].get<double>(), 0.003);
  EXPECT_TRUE(surfaces["paper"]["to_plane"]["mean_m"].is_number());
  EXPECT_EQ(json["placement"]["scan2cad"]["right"], 1);
  EXPECT_EQ(json["placement"]["scan2cad"]["truths"], 2);
  EXPECT_EQ(json["placement"]["add"]["right"], 1);
  // Both candidates lie on 'a', equally likely: one is right, and of two true ones one is found.
  EXPECT_EQ(json["detection"]["candidates"], 2);
  EXPECT_NEAR(json["detection"]["iou_50"]["mean"].get<double>(), 0.5, 1e-12);
  EXPECT_TRUE(json["shown"]["by_frames"].is_array());
  EXPECT_NEAR(json["objects"][0]["add_m"].get<double>(), 0.04, 1e-9);
}

TEST_F(EvaluateVerb, JudgesTheBeliefsOfARunFile) {
  const std::string rest = " --ground-truth truth.json --models models --json result.json";
  const ProgramRun outcome = Run("evaluate run.plb" + rest);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("truth in the 95 % region [%]"));
  const nlohmann::json belief = ReadJson(folder_.path() / "result.json").value()["belief"];
  EXPECT_EQ(belief["at_the_end"]["poses"], 1);
  EXPECT_EQ(belief["at_the_end"]["truth_in_95_percent"], 0);
  ASSERT_EQ(belief["objects"].size(), 2u) << "the tentative one too";
  EXPECT_EQ(belief["objects"][0]["ground_truth"], "a");
  // No spread is claimed, so that of the truth remains: 1.5 cm, 1 / sqrt(3) of it an axis.
  EXPECT_NEAR(belief["objects"][0]["nees"].get<double>(), 0.04 * 0.04 / (0.015 * 0.015 / 3), 0.01);
  // Both claim the same true object, equally surely, and there are two.
  EXPECT_EQ(belief["confirmation"]["points"].size(), 1u);
  EXPECT_EQ(belief["confirmation"]["points"][0]["precision"], 0.5);
  EXPECT_EQ(belief["confirmation"]["points"][0]["recall"], 0.5);
  EXPECT_EQ(Run("evaluate run.plb --ignore-category chair" + rest).exit_code, 0);
  const nlohmann::json ignored = ReadJson(folder_.path() / "result.json").value()["belief"];
  EXPECT_TRUE(ignored["objects"].empty());
  EXPECT_EQ(ignored["confirmation"]["truths"], 0);
}

TEST_F(EvaluateVerb, JudgesAnExportedJsonAlikeAndWritesToStandardOutput) {
  EXPECT_EQ(Run("export run.plb --format json --out run.json").exit_code, 0);
  const std::string rest = " --ground-truth truth.json --models models --align objects --json -";
  const ProgramRun from_json = Run("evaluate run.json" + rest);
  const ProgramRun from_file = Run("evaluate run.plb" + rest);
  EXPECT_EQ(from_json.exit_code, 0) << from_json.output;
  EXPECT_EQ(from_json.output, from_file.output);
  const nlohmann::json json = nlohmann::json::parse(from_json.output);
  EXPECT_NEAR(json["alignment"][0][3].get<double>(), -0.04, 1e-12);
}

TEST_F(EvaluateVerb, ExportsTheConfirmedObjectsAsAColouredMesh) {
  const ProgramRun outcome = Run("export run.plb --format ply --out map.ply");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const TriangleMesh mesh = ReadMesh(folder_.path() / "map.ply").value();
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.colors.size(), 4u);
  EXPECT_NEAR(mesh.vertices[0].x(), -0.46, 1e-6);
}

TEST_F(EvaluateVerb, WritesAReportThatNeedsNothingElse) {
  const ProgramRun outcome = Run("report run.plb --ground-truth truth.json --out report.html");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string html = ReadFile(folder_.path() / "report.html").value();
  EXPECT_THAT(html, HasSubstr("<!doctype html>"));
  EXPECT_THAT(html, HasSubstr("1 / 1 / 0")) << "matched, missed, spurious";
  EXPECT_THAT(html, HasSubstr("4.0 cm"));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, testing::Not(HasSubstr("http"))) << "nothing is fetched";
  EXPECT_THAT(html, HasSubstr("</html>"));
}

TEST_F(EvaluateVerb, ExportsTables) {
  const ProgramRun outcome = Run("export run.plb --format csv --out tables");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string objects = ReadFile(folder_.path() / "tables" / "objects.csv").value();
  EXPECT_THAT(objects, testing::StartsWith("id,model,category,state,x_m,"));
  EXPECT_THAT(objects, HasSubstr("\n1,wedge,chair,confirmed,0.040000,"));
  EXPECT_THAT(objects, HasSubstr("\n2,wedge,chair,tentative,"));
  for (const char* name : {"frames.csv", "events.csv", "timings.csv"})
    EXPECT_TRUE(ReadFile(folder_.path() / "tables" / name).ok()) << name;
}

TEST_F(EvaluateVerb, TellsTwoRunsApart) {
  const ProgramRun same = Run("compare run.plb run.plb");
  EXPECT_EQ(same.exit_code, 0) << same.output;
  EXPECT_THAT(same.output, HasSubstr("no difference"));
  std::filesystem::copy(folder_.path() / "run.plb", folder_.path() / "before.plb");
  WriteRun(0.09, 5);
  const ProgramRun outcome =
      Run("compare before.plb run.plb --ground-truth truth.json --json difference.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("seed: 0 / 5"));
  const nlohmann::json json = ReadJson(folder_.path() / "difference.json").value();
  ASSERT_EQ(json["objects"].size(), 1u);
  EXPECT_NEAR(json["objects"][0]["distance_m"].get<double>(), 0.05, 1e-9);
  EXPECT_NEAR(json["objects"][0]["a"]["translation_m"].get<double>(), 0.04, 1e-6);
  EXPECT_NEAR(json["objects"][0]["b"]["translation_m"].get<double>(), 0.09, 1e-6);
}

TEST_F(EvaluateVerb, SaysWhatIsMissingAndEndsWithOne) {
  const std::string rest = " --ground-truth truth.json --models models";
  const ProgramRun run = Run("evaluate none.plb" + rest);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.output, "plumbline: none.plb does not exist; check the path\n");
  const ProgramRun truth = Run("evaluate run.plb --ground-truth none.json --models models");
  EXPECT_EQ(truth.exit_code, 1);
  EXPECT_THAT(truth.output, HasSubstr("none.json"));
  const ProgramRun unnamed = Run("evaluate run.json");
  EXPECT_EQ(unnamed.exit_code, 1);
  EXPECT_THAT(unnamed.output, HasSubstr("name --models and --ground-truth"));
  const ProgramRun gone = Run("evaluate run.plb --models models");
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.output, HasSubstr("; name the ground truth with --ground-truth"));
  const ProgramRun scan = Run("evaluate run.plb --truth scan" + rest);
  EXPECT_EQ(scan.exit_code, 1);
  EXPECT_THAT(scan.output, HasSubstr("--scene"));
  const ProgramRun moved = Run("export run.plb --format ply --models elsewhere --out map.ply");
  EXPECT_EQ(moved.exit_code, 1);
  EXPECT_THAT(moved.output, HasSubstr("--models DIR"));
}

TEST_F(EvaluateVerb, EndsWithTwoOnWrongUsage) {
  EXPECT_EQ(Run("evaluate").exit_code, 2);
  EXPECT_EQ(
      Run("evaluate run.plb --ground-truth truth.json --models models --align fine").exit_code, 2);
  EXPECT_EQ(Run("export run.plb --format docx --out map").exit_code, 2);
}

TEST_F(EvaluateVerb, ComparesWhatTheRunsOfAFolderMissed) {
  const auto runs = folder_.path() / "runs";
  std::filesystem::create_directory(runs);
  std::filesystem::rename(folder_.path() / "run.plb", runs / "near.plb");
  WriteRun(1.5);
  std::filesystem::rename(folder_.path() / "run.plb", runs / "off.plb");
  Write("runs/broken.plb", "no run");
  const ProgramRun outcome =
      Run("evaluate runs --ground-truth truth.json --models models --json missed.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("found in"));
  EXPECT_THAT(outcome.output, HasSubstr("broken.plb")) << "what is left out is named";
  EXPECT_THAT(outcome.output, HasSubstr("2 runs, 3 instances missed"));
  const auto json =
      nlohmann::json::parse(ReadFile(folder_.path() / "missed.json").value(), nullptr, false);
  ASSERT_EQ(json["scenes"].size(), 1u);
  const auto& truths = json["scenes"][0]["truths"];
  ASSERT_EQ(truths.size(), 2u);
  EXPECT_EQ(truths[0]["id"], "a");
  EXPECT_EQ(truths[0]["runs"]["near"]["found"], true);
  EXPECT_EQ(truths[0]["runs"]["off"]["found"], false);
  EXPECT_TRUE(truths[0]["runs"]["off"]["why"].contains("text"));
  EXPECT_EQ(truths[1]["found_in"], 0);
}

TEST_F(EvaluateVerb, SaysWhatItCannotCompare) {
  std::filesystem::create_directory(folder_.path() / "none");
  const ProgramRun empty = Run("evaluate none --ground-truth truth.json --models models");
  EXPECT_NE(empty.exit_code, 0);
  EXPECT_THAT(empty.output, HasSubstr("has no run"));
  const ProgramRun lost = Run("evaluate run.plb lost.plb --ground-truth truth.json");
  EXPECT_NE(lost.exit_code, 0);
  EXPECT_THAT(lost.output, HasSubstr("lost.plb"));
  const ProgramRun aligned = Run("evaluate run.plb run.plb --align icp");
  EXPECT_NE(aligned.exit_code, 0);
  EXPECT_THAT(aligned.output, HasSubstr("give one run"));
  EXPECT_EQ(Run("evaluate run.plb run.plb --plant forks").exit_code, 2);
  ASSERT_EQ(Run("export run.plb --format json --out map.json").exit_code, 0);
  const ProgramRun planted =
      Run("evaluate map.json --ground-truth truth.json --models models --plant forks");
  EXPECT_EQ(planted.exit_code, 1);
  EXPECT_THAT(planted.output, HasSubstr("--plant maps a run file"));
}

}  // namespace
}  // namespace plumbline
