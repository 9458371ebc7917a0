// SPDX-License-Identifier: Apache-2.0
// The commands `vio` and `evaluate --trajectory` as a script meets them.

#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "tests/support/program_run.h"
#include "tests/support/test_data.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string Row(std::int64_t stamp_ns, std::initializer_list<Eigen::VectorXd> numbers) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.9f", static_cast<double>(stamp_ns) * 1e-9);
  std::string row = text;
  for (const Eigen::VectorXd& part : numbers) {
    for (const double number : part) {
      std::snprintf(text, sizeof(text), ",%.12g", number);
      row += text;
    }
  }
  return row + "\n";
}

class VioVerb : public testing::Test {
 protected:
  void SetUp() override {
    VioSimulation options;
    options.seconds = 12;
    recording_ = Simulate(options);
    std::filesystem::create_directory(folder_.path() / "walk");
    WriteCamera();
    WriteImu();
    WriteTracks();
    WriteTruth();
  }

  void Write(const std::string& name, const std::string& text) {
    const Status written = WriteFileAtomically(folder_.path() / name, text);
    PLB_CHECK(written.ok()) << written.error().message;
  }

  void WriteCamera() { Write("walk/camera.json", CameraToJson(recording_.camera).dump()); }
  void WriteImu() {
    std::string text = "t,wx,wy,wz,ax,ay,az\n";
    for (const ImuSample& sample : recording_.samples)
      text += Row(sample.stamp_ns, {sample.angular_velocity_rad_s, sample.specific_force_m_s2});
    Write("walk/imu.csv", text);
  }
  void WriteTracks() {
    std::string text = "t,id,u,v\n";
    for (const TrackedImage& image : recording_.images) {
      for (const TrackedPoint& point : image.points)
        text += Row(image.stamp_ns,
                    {Eigen::VectorXd::Constant(1, static_cast<double>(point.id)), point.pixel});
    }
    Write("walk/tracks.csv", text);
  }
  void WriteTruth() {
    std::string text = "t,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz\n";
    for (const ReferenceState& state : recording_.truth) {
      const Eigen::Quaterniond q(state.world_from_body.linear());
      text += Row(state.stamp_ns, {state.world_from_body.translation(), q.coeffs(),
                                   state.velocity_in_world, state.gyro_bias, state.accel_bias});
    }
    Write("walk/groundtruth.csv", text);
  }

  /// Standard output and error.
  ProgramRun Run(const std::string& arguments) {
    return RunProgram(arguments + " 2>&1", folder_.path());
  }

  TemporaryFolder folder_;
  SimulatedRecording recording_;
};

TEST_F(VioVerb, WritesATrajectoryThatEvaluateFindsNearTheTruth) {
  const ProgramRun vio = Run("vio walk --out T.txt --init walk/groundtruth.csv --json vio.json");
  ASSERT_EQ(vio.exit_code, 0) << vio.output;
  const nlohmann::json summary = ReadJson(folder_.path() / "vio.json").value();
  EXPECT_EQ(summary["images"], recording_.images.size());
  EXPECT_EQ(summary["stretches"], 1);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "T.points.ply"));

  const ProgramRun judged =
      Run("evaluate --trajectory T.txt --reference walk/groundtruth.csv --json errors.json");
  ASSERT_EQ(judged.exit_code, 0) << judged.output;
  const nlohmann::json errors = ReadJson(folder_.path() / "errors.json").value();
  EXPECT_LT(errors["ate_m"].get<double>(), 0.06);
  EXPECT_LT(errors["tilt_deg"].get<double>(), 0.3);
  EXPECT_GT(errors["nees"].get<double>(), 1);
  EXPECT_LT(errors["nees"].get<double>(), 15);
}

TEST_F(VioVerb, PosesOfTheCameraHangOnThoseOfTheBody) {
  const std::string vio = "vio walk --init walk/groundtruth.csv --json - --out ";
  ASSERT_EQ(Run(vio + "body.txt").exit_code, 0);
  ASSERT_EQ(Run(vio + "cam.txt --frame cam").exit_code, 0);
  const std::string read = ReadFile(folder_.path() / "cam.covariance.csv").value();
  EXPECT_THAT(read.substr(0, read.find('\n')), HasSubstr("world_from_cam"));
  const ProgramRun compared =
      Run("evaluate --trajectory cam.txt --reference body.txt --align none --json -");
  ASSERT_EQ(compared.exit_code, 0) << compared.output;
  const double arm = recording_.camera.body_from_cam->translation().norm();
  EXPECT_NEAR(nlohmann::json::parse(compared.output.substr(compared.output.find('{')))["ate_m"],
              arm, 0.02);
}

TEST_F(VioVerb, CalibrateMendsAWrongCameraAndWritesItsFiles) {
  nlohmann::json camera = ReadJson(folder_.path() / "walk" / "camera.json").value();
  camera["note"] = "of the workshop";
  const double arm_m = camera["body_from_cam"][0][3].get<double>();
  camera["body_from_cam"][0][3] = arm_m + 0.01;
  Write("walk/camera.json", camera.dump());
  const ProgramRun outcome =
      Run("calibrate walk --out found --report found.html --json found.json 2>&1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("2 backward"), HasSubstr("agree")));
  const nlohmann::json found = ReadJson(folder_.path() / "found.json").value();
  EXPECT_TRUE(found["agreed"].get<bool>());
  const nlohmann::json mended = ReadJson(folder_.path() / "found" / "camera.json").value();
  EXPECT_NEAR(mended["body_from_cam"][0][3].get<double>(), arm_m, 0.005);
  EXPECT_EQ(mended["note"], "of the workshop");
  // Twelve seconds of points that scatter by a pixel tell the offset of the clocks to a
  // millisecond.
  const double offset_s =
      ReadJson(folder_.path() / "found" / "imu.json").value()["time_offset_s"].get<double>();
  EXPECT_LT(std::abs(offset_s), 0.003);
  EXPECT_LT(std::abs(offset_s), 4 * found["std"][6].get<double>());
  EXPECT_THAT(ReadFile(folder_.path() / "found.html").value(), HasSubstr("<svg"));
  EXPECT_TRUE(found["lens"].empty());
  // On request the lens, too.
  const double fx = mended["fx"].get<double>();
  nlohmann::json wrong = mended;
  wrong["fx"] = 1.01 * fx;
  Write("walk/camera.json", wrong.dump());
  const ProgramRun lens =
      Run("calibrate walk --lens --read-out --out lens --report lens.html --json lens.json 2>&1");
  ASSERT_EQ(lens.exit_code, 0) << lens.output;
  EXPECT_THAT(lens.output, AllOf(HasSubstr("fx "), HasSubstr("read-out")));
  const nlohmann::json fx_found = ReadJson(folder_.path() / "lens.json").value()["lens"]["fx_px"];
  EXPECT_NEAR(fx_found["value"].get<double>(), fx, 0.005 * fx);
  EXPECT_EQ(ReadJson(folder_.path() / "lens" / "camera.json").value()["fx"], fx_found["value"]);
  EXPECT_THAT(ReadFile(folder_.path() / "lens.html").value(),
              AllOf(HasSubstr("Focal lengths"), HasSubstr("Read-out")));
  const ProgramRun missing = Run("calibrate nowhere 2>&1");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, AllOf(HasSubstr("nowhere"), Not(HasSubstr("bug"))));
  const ProgramRun nowhere = Run("calibrate walk --report no/folder/found.html 2>&1");
  EXPECT_NE(nowhere.exit_code, 0);
  EXPECT_THAT(nowhere.output, AllOf(HasSubstr("no folder"), Not(HasSubstr("forward"))));
}

TEST_F(VioVerb, TheSameInputGivesTheSameFile) {
  const std::string vio = "vio walk --drop-tracks 0.2 --seed 3 --out ";
  ASSERT_EQ(Run(vio + "a.txt").exit_code, 0);
  ASSERT_EQ(Run(vio + "b.txt").exit_code, 0);
  EXPECT_EQ(ReadFile(folder_.path() / "a.txt").value(), ReadFile(folder_.path() / "b.txt").value());
}

TEST_F(VioVerb, SaysWhatInputLacks) {
  Write("walk/imu.csv", "t,wx,wy,wz,ax,ay,az\n");
  ProgramRun outcome = Run("vio walk --out T.txt");
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("imu.csv"));
  WriteImu();

  nlohmann::json camera = ReadJson(folder_.path() / "walk" / "camera.json").value();
  camera.erase("body_from_cam");
  Write("walk/camera.json", camera.dump());
  outcome = Run("vio walk --out T.txt");
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("add 'body_from_cam' to camera.json"));
  WriteCamera();

  outcome = Run("vio walk --out nowhere/T.txt");
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("create it first"));
  EXPECT_THAT(Run("vio walk --set no_such=1").output, HasSubstr("no_such"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "T.txt"));
}

TEST_F(VioVerb, SaysWhichRowsItLeftOut) {
  std::string tracks = ReadFile(folder_.path() / "walk" / "tracks.csv").value();
  Write("walk/tracks.csv", tracks + "not,a,row\n");
  const ProgramRun outcome = Run("vio walk --init walk/groundtruth.csv");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("tracks.csv"));
}

TEST_F(VioVerb, TracksAloneCloseNoLoopsAndItSaysSo) {
  const std::string vio = "vio walk --init walk/groundtruth.csv ";
  const ProgramRun outcome = Run(vio + "--json vio.json --out a.txt");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("loops: none closed"));
  EXPECT_EQ(ReadJson(folder_.path() / "vio.json").value()["loops"]["closed"], 0);
  EXPECT_THAT(Run(vio + "--no-loops --out b.txt").output, HasSubstr("loops: not looked for"));
  EXPECT_EQ(ReadFile(folder_.path() / "a.txt").value(), ReadFile(folder_.path() / "b.txt").value());
  EXPECT_THAT(Run(vio + "--set-loops no_such=1").output, HasSubstr("no_such"));
}

TEST_F(VioVerb, EvaluateRefusesWhatItCannotCompare) {
  Write("T.txt", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
  Write("far.txt", "1001 0 0 0 0 0 0 1\n1002 1 0 0 0 0 0 1\n");
  Write("states.csv", "t,px\n1,2\n");
  const std::string evaluate = "evaluate --trajectory T.txt --reference ";
  EXPECT_THAT(Run("evaluate --trajectory T.txt").output, HasSubstr("--reference"));
  for (const char* reference : {"far.txt", "missing.txt", "states.csv"}) {
    const ProgramRun outcome = Run(evaluate + reference);
    EXPECT_NE(outcome.exit_code, 0);
    EXPECT_THAT(outcome.output, AllOf(HasSubstr(reference), Not(HasSubstr("this is a bug"))));
  }
  Write("T.covariance.csv", "nonsense\n");
  const ProgramRun corrupt = Run(evaluate + "T.txt");
  EXPECT_NE(corrupt.exit_code, 0);
  EXPECT_THAT(corrupt.output, HasSubstr("holds no usable covariance"));
}

}  // namespace
}  // namespace plumbline
