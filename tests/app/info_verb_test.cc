// SPDX-License-Identifier: Apache-2.0
// `plumbline info` as a user and a script meet it.

#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_project.h"
#include "engine/base/files.h"
#include "engine/mapping/map_report.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/run_file.h"
#include "tests/support/furniture_models.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class InfoVerb : public testing::Test {
 protected:
  /// Exit code; what it printed lies in out() and errors().
  int Run(const std::string& path, const std::string& more = "") {
    const std::string command = "'" + ProgramFile().string() + "' info '" + Path(path) + "' " +
                                more + " >'" + Path("out") + "' 2>'" + Path("err") + "'";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string out() const { return ReadFile(Path("out")).value(); }
  std::string errors() const { return ReadFile(Path("err")).value(); }
  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  nlohmann::json Json(const std::string& path) {
    EXPECT_EQ(Run(path, "--json -"), 0) << errors();
    return nlohmann::json::parse(out());
  }
  std::vector<std::string> Odd(const std::string& path) { return Json(path)["odd"]; }

  TemporaryFolder folder_;
};

TEST_F(InfoVerb, DescribesASequenceOnOneScreen) {
  WriteTinySequence(Path("walk"), {.frames = 20, .edges = true, .proposals = true});
  ASSERT_EQ(Run("walk"), 0) << errors();
  EXPECT_THAT(out(), AllOf(HasSubstr("sequence, Plumbline's own layout"),
                           HasSubstr("20 at 10 Hz, 1.9 s"), HasSubstr("64x48, pinhole"),
                           HasSubstr("20 of 20 frames, path 19.0 m"), HasSubstr("floor known"),
                           HasSubstr("edges, proposals"), Not(HasSubstr("  ! "))));
  const std::string screen = out();
  EXPECT_LE(std::count(screen.begin(), screen.end(), '\n'), 24);
  const nlohmann::json json = Json("walk");
  EXPECT_EQ(json["kind"], "sequence");
  EXPECT_EQ(json["frames"]["count"], 20);
  EXPECT_NEAR(json["frames"]["rate_hz"].get<double>(), 10, 1e-6);
  EXPECT_EQ(json["cameras"][0]["model"], "pinhole");
  EXPECT_EQ(json["poses"]["frames"], 20);
  EXPECT_EQ(json["images"]["readable"], json["images"]["looked_at"]);
  EXPECT_GT(json["bytes"], 1000);
  EXPECT_TRUE(json["imu"].is_null());
  EXPECT_THAT(json["odd"], IsEmpty());
}

TEST_F(InfoVerb, NamesWhatIsOddAboutASequence) {
  WriteTinySequence(Path("walk"), {.frames = 30});
  std::filesystem::remove(Path("walk/color/000011.jpg"));
  std::filesystem::remove(Path("walk/color/000012.jpg"));
  WriteText(Path("walk/color/000000.jpg"), "no image");
  WriteText(Path("walk/trajectory.txt"), "0.1 0 0 0 0 0 0 1\n0.2 9 0 0 0 0 0 1\n");
  std::filesystem::remove(Path("walk/gravity.json"));
  std::string imu = "#t,wx,wy,wz,ax,ay,az\n";
  for (int i = 0; i < 200; ++i)
    if (i < 50 || i > 80) imu += std::to_string(0.01 * i) + ",0,0,0,0,0,1\n";
  imu += "1.99,0,0,0,0,0,1\n";
  WriteText(Path("walk/imu.csv"), imu);
  const auto odd = Odd("walk");
  for (const char* sentence :
       {"1 gap in the frames: the longest lasts 0.30 s, after frame 10", "000000.jpg",
        "no pose within half a period of 26 of 28 frames", "The camera jumps 1 times",
        "There is no gravity.json", "1 gap in the IMU's samples: the longest lasts 320 ms",
        "noise of the IMU is not known", "no body_from_cam", "does not cover the whole time",
        "far from gravity", "1 IMU samples with the stamp of another"}) {
    EXPECT_THAT(odd, Contains(HasSubstr(sentence)));
  }
  std::filesystem::remove(Path("walk/trajectory.txt"));
  EXPECT_THAT(Odd("walk"), Contains(HasSubstr("(--poses FILE)")));
}

TEST_F(InfoVerb, KnowsASequenceWithoutImages) {
  WriteText(Path("tracked/camera.json"),
            R"({"width": 640, "height": 480, "model": "fov", "fx": 257, "fy": 258, "cx": 328,
                "cy": 229, "distortion": [0.93], "rolling_shutter_s": -0.015})");
  WriteText(Path("tracked/tracks.csv"), "0.0,1,5,6\n0.0,2,7,8\n0.1,1,5,6\n0.2,1,5,6\n");
  ASSERT_EQ(Run("tracked"), 0) << errors();
  EXPECT_THAT(out(),
              AllOf(HasSubstr("without images"), HasSubstr("fov"),
                    HasSubstr("rolling shutter of -15 ms"), HasSubstr("3 images, 1 points each")));
}

TEST_F(InfoVerb, DescribesModelsMeshesAndTrajectories) {
  WriteText(Path("models/models.json"),
            R"({"units": "m", "models": [{"name": "chair", "file": "c.ply", "category": "chair"},
                {"name": "lost", "file": "lost.ply", "category": "table"}]})");
  ASSERT_TRUE(WritePly(Path("models/c.ply"), MakeChair(true)).ok());
  const nlohmann::json models = Json("models");
  EXPECT_EQ(models["kind"], "models");
  EXPECT_EQ(models["models"].size(), 2u);
  EXPECT_THAT(std::vector<std::string>(models["odd"]),
              Contains(HasSubstr("'lost' cannot be used")));
  ASSERT_EQ(Run("models"), 0);
  EXPECT_THAT(out(), HasSubstr("chair"));
  ASSERT_TRUE(WritePly(Path("chair.ply"), MakeChair(true)).ok());
  const nlohmann::json mesh = Json("chair.ply");
  EXPECT_EQ(mesh["kind"], "mesh");
  EXPECT_GT(mesh["triangles"], 10);
  EXPECT_THAT(mesh["odd"], IsEmpty());
  WriteText(Path("t.txt"), "# world_from_body\n0 0 0 0 0 0 0 1\n0.1 3 4 0 0 0 0 1\n");
  const nlohmann::json trajectory = Json("t.txt");
  EXPECT_EQ(trajectory["kind"], "trajectory");
  EXPECT_EQ(trajectory["path_m"], 5);
  EXPECT_EQ(trajectory["of_body"], true);
}

TEST_F(InfoVerb, DescribesARunAndSaysThatItDidNotEnd) {
  RunHeader header;
  header.recipe.sequence = Path("gone");
  header.recipe.models = Path(".");
  header.program_version = "1.2.3";
  header.end_frame = 5;
  header.camera = {64, 48, 60, 60, 31.5, 23.5};
  auto writer = RunWriter::Create(Path("a.plb"), header).value();
  FrameReport report;
  report.skipped = "no pose";
  ASSERT_TRUE(writer->Write(report, {}).ok());
  ASSERT_TRUE(writer->Close().ok());
  const nlohmann::json json = Json("a.plb");
  EXPECT_EQ(json["kind"], "run");
  EXPECT_EQ(json["frames"]["count"], 1);
  EXPECT_EQ(json["finished"], true);
  EXPECT_THAT(std::vector<std::string>(json["odd"]),
              AllOf(Contains(HasSubstr("1 frame was skipped")), Contains(HasSubstr("gone"))));
}

TEST_F(InfoVerb, DescribesAnAnnotationProject) {
  AnnotationDocument document;
  document.scan = "scan.ply";
  document.instances.resize(2);
  document.instances[0].id = "a";
  document.instances[1].id = "b";
  document.instances[0].model = document.instances[1].model = "chair";
  document.instances[1].fine = false;
  WriteText(Path("p.json"), DocumentToJson(document).dump());
  const nlohmann::json json = Json("p.json");
  EXPECT_EQ(json["kind"], "project");
  EXPECT_EQ(json["instances"], 2);
  EXPECT_EQ(json["fine"], 1);
  EXPECT_THAT(std::vector<std::string>(json["odd"]), Contains(HasSubstr("scan.ply")));
}

TEST_F(InfoVerb, SaysWhatItWouldKnow) {
  EXPECT_EQ(Run("nothing"), 1);
  EXPECT_THAT(errors(), HasSubstr("there is no"));
  WriteText(Path("note.txt"), "hello\n");
  EXPECT_EQ(Run("note.txt"), 1);
  EXPECT_THAT(errors(),
              AllOf(HasSubstr("a sequence"), HasSubstr("a run (.plb)"), HasSubstr("a trajectory")));
  for (const char* pipe : {"pipe.bag", "pipe.plb", "pipe.sens"}) {  // nobody writes: no waiting
    ASSERT_EQ(::mkfifo(Path(pipe).c_str(), 0600), 0);
    EXPECT_EQ(Run(pipe), 1);
    EXPECT_THAT(errors(), HasSubstr("is a device, pipe or socket"));
  }
  WriteText(Path("net.onnx"), "x");
  ASSERT_EQ(Run("net.onnx"), 0);
  EXPECT_THAT(out(), HasSubstr("net.json"));
}

TEST_F(InfoVerb, FindsNothingOddAboutTheKitchenButWhatIs) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  std::filesystem::create_directory_symlink(*shared / "data", Path("data"));
  const nlohmann::json kitchen = Json("data/kitchen");
  EXPECT_EQ(kitchen["frames"]["count"], 600);
  EXPECT_EQ(kitchen["imu"]["count"], 3993);
  EXPECT_EQ(kitchen["imu"]["gaps"], 0);
  EXPECT_EQ(kitchen["reference"]["states"], 1997);
  EXPECT_EQ(Json("data/vio/tango_lc")["tracks"]["points"], 200014);
}

}  // namespace
}  // namespace plumbline
