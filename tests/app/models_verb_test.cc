// SPDX-License-Identifier: Apache-2.0
// `plumbline models build` and `check` as a script meets them.

#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_database.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class ModelsVerbTest : public testing::Test {
 protected:
  /// Exit code; what it printed lies in out() and errors().
  int Run(const std::string& arguments) {
    const std::string command = "'" + ProgramFile().string() + "' models " + arguments + " >'" +
                                (folder_.path() / "out").string() + "' 2>'" +
                                (folder_.path() / "err").string() + "'";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string out() const { return ReadFile(folder_.path() / "out").value(); }
  std::string errors() const { return ReadFile(folder_.path() / "err").value(); }
  std::string Path(const std::string& name) const {
    return "'" + (folder_.path() / name).string() + "'";
  }

  TemporaryFolder folder_;
};

TEST_F(ModelsVerbTest, BuildsADatabaseThatLoadsAndChecks) {
  ASSERT_TRUE(WritePly(folder_.path() / "kitchen_chair.ply", MakeChair(true)).ok());
  ASSERT_TRUE(WritePly(folder_.path() / "ball.ply", MakeSphere(120, 60)).ok());
  ASSERT_EQ(Run("build " + Path("kitchen_chair.ply") + " --out " + Path("db") +
                " --unit m --up +z --front +x"),
            0)
      << errors();
  EXPECT_THAT(out(), HasSubstr("kitchen_chair (chair)"));
  EXPECT_EQ(errors(), "");
  ASSERT_EQ(Run("build " + Path("ball.ply") + " --out " + Path("db") +
                " --unit mm --up -y --front -x --category 'sports ball' --symmetry 0 --faces 800 "
                "--json -"),
            0)
      << errors();
  const nlohmann::json json = nlohmann::json::parse(out());
  EXPECT_EQ(json[0]["up"], "-y");
  EXPECT_LE(json[0]["faces"], 800);
  EXPECT_LT(json[0]["mean_error_m"], 0.001);
  ASSERT_EQ(Run("check " + Path("db")), 0) << errors();
  EXPECT_THAT(out(), HasSubstr("non-manifold"));
  const auto database = ModelDatabase::Load(folder_.path() / "db");
  ASSERT_TRUE(database.ok()) << database.error().message;
  EXPECT_EQ((*database)->models().size(), 2u);
  EXPECT_NEAR((*database)->models()[1].bounds.max().z(), 0.24, 0.002);
}

TEST_F(ModelsVerbTest, SaysWhatItGuessed) {
  ASSERT_TRUE(WritePly(folder_.path() / "chair.ply", MakeChair(false)).ok());
  ASSERT_EQ(Run("build " + Path("chair.ply") + " --out " + Path("db")), 0);
  for (const char* option : {"--unit", "--up", "--front"}) EXPECT_THAT(errors(), HasSubstr(option));
  EXPECT_THAT(out(), HasSubstr("up +z, front +x"));
}

TEST_F(ModelsVerbTest, ShowsAllUpsAndFrontsOfWhatIsUnsureAndOnlyOfThat) {
  ASSERT_TRUE(WritePly(folder_.path() / "thing.ply", MakeBox({1, 1, 1}, {2, 2, 2})).ok());
  ASSERT_TRUE(WritePly(folder_.path() / "chair.ply", MakeChair(false)).ok());
  ASSERT_EQ(Run("build " + Path("thing.ply") + " " + Path("chair.ply") + " --out " + Path("db") +
                " --sheet " + Path("sheet.png")),
            0)
      << errors();
  const cv::Mat sheet = cv::imread((folder_.path() / "sheet.png").string());
  ASSERT_FALSE(sheet.empty());
  EXPECT_EQ(sheet.cols, 6 * 220);
  EXPECT_EQ(sheet.rows, 2 * 248) << "up and front of the thing; the chair is sure";
  ASSERT_EQ(
      Run("build " + Path("chair.ply") + " --out " + Path("db") + " --sheet " + Path("none.png")),
      0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none.png"));
  EXPECT_THAT(errors(), HasSubstr("nothing was unsure"));
}

TEST_F(ModelsVerbTest, TextThatIsNotUtf8IsRefusedInOneSentence) {
  for (const std::string& arguments :
       std::vector<std::string>{"build " + Path("a\xff.ply") + " --out db",
                                "build a.ply --out db --category 'ch\xfc'", "check 'm\xe4'"}) {
    EXPECT_EQ(Run(arguments), 2);
    EXPECT_THAT(errors(), HasSubstr("is not UTF-8 text"));
  }
}

TEST_F(ModelsVerbTest, APipeIsNoMesh) {
  ASSERT_EQ(::mkfifo((folder_.path() / "pipe.ply").c_str(), 0600), 0);
  EXPECT_EQ(Run("build " + Path("pipe.ply") + " --out " + Path("db")), 1);
  EXPECT_THAT(errors(), HasSubstr("pipe.ply' is a device, pipe or socket"));
}

TEST_F(ModelsVerbTest, BuildsTheOthersWhenOneFileIsBroken) {
  ASSERT_TRUE(WritePly(folder_.path() / "chair.ply", MakeChair(false)).ok());
  ASSERT_TRUE(WriteFileAtomically(folder_.path() / "broken.ply", "ply\nformat ascii 1.0\n").ok());
  EXPECT_EQ(Run("build " + Path("broken.ply") + " " + Path("chair.ply") + " --out " + Path("db")),
            1);
  EXPECT_THAT(errors(), HasSubstr("broken.ply"));
  EXPECT_THAT(errors(), HasSubstr("1 of 2"));
  EXPECT_TRUE(ModelDatabase::Load(folder_.path() / "db").ok());
}

TEST_F(ModelsVerbTest, ExitsWithOneForUnusableModelsAndTwoForWrongUsage) {
  ASSERT_TRUE(WritePly(folder_.path() / "huge.ply", MakeSphere(500, 8)).ok());
  ASSERT_TRUE(
      WriteFileAtomically(folder_.path() / "models.json",
                          R"({"models": [{"name": "a", "file": "huge.ply", "category": "cup"}]})")
          .ok());
  EXPECT_EQ(Run("check " + Path("")), 1);
  EXPECT_THAT(out(), HasSubstr("--unit"));
  EXPECT_THAT(errors(), HasSubstr("1 of 1"));
  EXPECT_EQ(Run("check " + Path("nowhere")), 1);
  EXPECT_EQ(Run("build a.ply"), 2);
  EXPECT_EQ(Run("build a.ply --out b --unit inch"), 2);
  EXPECT_EQ(Run("build a.ply --out b --up w"), 2);
  EXPECT_EQ(Run("build a.ply --out b --front x"), 2);
  EXPECT_EQ(Run(""), 2);
}

}  // namespace
}  // namespace plumbline
