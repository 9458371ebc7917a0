// SPDX-License-Identifier: Apache-2.0
// `report --interactive` as a script meets it, and the page as a browser meets it; and what else a
// run tells of itself once its sequence is at hand.

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <regex>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/mapping/map_report.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/run_file.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/program_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kPageFrames = 30;

/// What stands between the tags of the script element `id`.
std::string ScriptText(const std::string& html, const std::string& id) {
  const std::size_t element = html.find("id=\"" + id + "\">");
  PLB_CHECK(element != std::string::npos) << "no element " << id;
  const std::size_t begin = html.find('>', element) + 1;
  return html.substr(begin, html.find("</script>", begin) - begin);
}

nlohmann::json DataOf(const std::string& html) {
  return nlohmann::json::parse(ScriptText(html, "run-data"));
}

int Lines(const std::string& text) {
  return 1 + static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

/// What encodeURIComponent wrote.
std::string Unescaped(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
    i += 2;
  }
  return out;
}

/// A drawn room, mapped once for all tests.
class RunPage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    WriteDrawnSequence(folder_->path() / "room", {.frames = kPageFrames});
    nlohmann::json truth = {{"gravity", {0, 0, -1}}, {"instances", nlohmann::json::array()}};
    for (const PlacedModel& object : DrawnObjects()) {
      const bool chair = object.label != DrawnObjects().front().label;
      nlohmann::json rows = nlohmann::json::array();
      for (int i = 0; i < 4; ++i) {
        const Eigen::RowVector4d row = object.world_from_object.matrix().row(i);
        rows.push_back({row[0], row[1], row[2], row[3]});
      }
      truth["instances"].push_back({{"id", "true " + std::to_string(object.object.value)},
                                    {"model", chair ? "chair" : "table"},
                                    {"category", chair ? "chair" : "dining table"},
                                    {"quality", "fine"},
                                    {"world_from_object", rows}});
    }
    PLB_CHECK(WriteJson(folder_->path() / "room" / "ground_truth.json", truth).ok());
    const ProgramRun run = Run("run room --out run.plb --seed 3");
    PLB_CHECK(run.exit_code == 0) << run.output;
    const ProgramRun page = Run("report --interactive run.plb --out run.html");
    PLB_CHECK(page.exit_code == 0) << page.output;
    said_ = page.output;
    html_ = ReadFile(folder_->path() / "run.html").value();
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static ProgramRun Run(const std::string& arguments) {
    return RunProgram(arguments + " 2>&1", folder_->path());
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::string said_, html_;
};

TEST_F(RunPage, HoldsEveryFrameAndFetchesNothing) {
  EXPECT_THAT(said_, HasSubstr("wrote run.html: 30 frames, "));
  EXPECT_THAT(html_, Not(HasSubstr("http:"))) << "nothing is fetched";
  EXPECT_THAT(html_, Not(HasSubstr("https:")));
  EXPECT_THAT(html_, Not(testing::ContainsRegex("src=\"[^\"]|href=")));
  EXPECT_THAT(html_, HasSubstr("default-src 'none'"));
  EXPECT_THAT(html_, Not(HasSubstr(folder_->path().string()))) << "no folders of this machine";
  const nlohmann::json data = DataOf(html_);
  ASSERT_EQ(data.at("frames").size(), static_cast<std::size_t>(kPageFrames));
  const std::string images = ScriptText(html_, "run-images");
  EXPECT_EQ(Lines(images), kPageFrames);
  EXPECT_THAT(images, testing::StartsWith("/9j/")) << "a JPEG in base 64";
  const nlohmann::json& last = data.at("frames").back();
  EXPECT_EQ(last.at("frame"), kPageFrames - 1);
  EXPECT_NEAR(last.at("time").get<double>(), (kPageFrames - 1) / 10.0, 1e-9);
  EXPECT_EQ(last.at("camera").size(), 7u);
  EXPECT_EQ(last.at("truth").size(), 3u) << "outlines of what is true";
  EXPECT_EQ(data.at("truth").size(), 3u);
  EXPECT_GE(data.at("models").size(), 2u);
  EXPECT_TRUE(data.at("models")[0].contains("mesh"));
}

TEST_F(RunPage, OutlinesLieInTheImageWhereTheObjectsAre) {
  const nlohmann::json data = DataOf(html_);
  const nlohmann::json& last = data.at("frames").back();
  const double width = data.at("page").at("width"), height = data.at("page").at("height");
  EXPECT_EQ(width, 480) << "no wider than the camera's";
  ASSERT_GE(last.at("outlines").size(), 2u);
  for (const nlohmann::json& outline : last.at("outlines")) {
    double x = 0, y = 0, least = 1e9, most = -1e9;
    for (std::size_t i = 0; i < outline.at(1).size(); i += 2) {
      x += outline[1][i].get<double>() / 2;
      y += outline[1][i + 1].get<double>() / 2;
      EXPECT_TRUE(x >= -1 && x <= width + 1 && y >= -1 && y <= height + 1) << x << ", " << y;
      least = std::min(least, x);
      most = std::max(most, x);
    }
    // Where the box of the object's outline is according to the mapper, in the full image.
    const auto report = RunReader::Open(folder_->path() / "run.plb").value()->LastFrame().value();
    for (const ObjectReport& object : report.objects) {
      if (object.id.value != outline[0] || outline.size() > 2) continue;
      EXPECT_NEAR(least, object.visible_box.x0, 4);
      EXPECT_NEAR(most, object.visible_box.x1, 4);
    }
  }
}

TEST_F(RunPage, IsTheSameForTheSameRunAndSmallerWhereAsked) {
  ASSERT_EQ(Run("report --interactive run.plb --out again.html").exit_code, 0);
  EXPECT_TRUE(ReadFile(folder_->path() / "again.html").value() == html_);
  const ProgramRun small =
      Run("report --interactive run.plb --out small.html --every 4 --width 160 --quality 40");
  ASSERT_EQ(small.exit_code, 0) << small.output;
  EXPECT_THAT(small.output, HasSubstr("8 frames, "));
  const std::string html = ReadFile(folder_->path() / "small.html").value();
  EXPECT_EQ(DataOf(html).at("page").at("width"), 160);
  EXPECT_EQ(Lines(ScriptText(html, "run-images")), 8);
  EXPECT_THAT(DataOf(html).at("summary").get<std::string>(), HasSubstr("every 4th of 30 frames"));
  EXPECT_LT(ScriptText(html, "run-images").size(), ScriptText(html_, "run-images").size() / 6);
  EXPECT_EQ(Run("report run.plb --out a.html --every 2").exit_code, 2) << "of --interactive only";
  EXPECT_EQ(Run("report --interactive run.plb --out a.html --quality 0").exit_code, 2);
  EXPECT_EQ(Run("report --interactive run.plb --out a.html --every 0").exit_code, 2);
}

TEST_F(RunPage, WithoutTheSequenceItSaysThatImagesAreMissing) {
  std::filesystem::rename(folder_->path() / "room", folder_->path() / "moved");
  const ProgramRun gone = Run("report --interactive run.plb --models moved/models --out gone.html");
  const ProgramRun found =
      Run("report --interactive run.plb --models moved/models --sequence moved --out found.html");
  std::filesystem::rename(folder_->path() / "moved", folder_->path() / "room");
  ASSERT_EQ(gone.exit_code, 0) << gone.output;
  const std::string html = ReadFile(folder_->path() / "gone.html").value();
  EXPECT_THAT(DataOf(html).at("notice").get<std::string>(), HasSubstr("small pictures"));
  EXPECT_EQ(DataOf(html).at("frames").size(), static_cast<std::size_t>(kPageFrames));
  EXPECT_GE(DataOf(html).at("frames").back().at("outlines").size(), 2u);
  ASSERT_EQ(found.exit_code, 0) << found.output;
  EXPECT_EQ(DataOf(ReadFile(folder_->path() / "found.html").value()).at("notice"), "");
}

TEST_F(RunPage, StoppedItLeavesNoFile) {
  int stopped = 0;
  for (const char* seconds : {"0.1", "0.2", "0.3", "0.4"}) {
    const std::string command = "cd '" + folder_->path().string() +
                                "' && timeout --preserve-status -s INT " + seconds + " '" +
                                ProgramFile().string() +
                                "' report --interactive run.plb --out half.html >/dev/null 2>&1";
    if (WEXITSTATUS(std::system(command.c_str())) == 0) break;  // it was faster
    ++stopped;
    EXPECT_FALSE(std::filesystem::exists(folder_->path() / "half.html")) << seconds << " s";
  }
  EXPECT_GT(stopped, 0);
}

/// Chromium on this machine; "" where there is none.
std::string Browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    const std::string command = std::string("command -v ") + name + " >/dev/null 2>&1";
    if (std::system(command.c_str()) == 0) return name;
  }
  return "";
}

/// The page with run_page_driver.js before and after it, with the page's own nonce: its policy lets
/// nothing else run.
std::string Driven(std::string html) {
  const std::string driver = ReadFile(SourceDirectory() / "tests/app/run_page_driver.js").value();
  std::smatch nonce;
  PLB_CHECK(std::regex_search(html, nonce, std::regex("script-src 'nonce-([0-9a-f]+)'")));
  const auto script = [&](const char* part) {
    return "<script nonce=\"" + nonce[1].str() + "\" data-part=\"" + part + "\">{\n" + driver +
           "}</script>\n";
  };
  const std::string before = script("before"), after = script("after");
  html.insert(html.find("<style"), before);
  html.insert(html.rfind("</body>"), after);
  return html;
}

TEST_F(RunPage, WorksInABrowser) {
  const std::string browser = Browser();
  if (browser.empty()) GTEST_SKIP() << "no Chromium here; on Debian: apt-get install chromium";
  ASSERT_TRUE(WriteFileAtomically(folder_->path() / "driven.html", Driven(html_)).ok());
  const std::string command =
      "cd '" + folder_->path().string() + "' && timeout 240 " + browser +
      " --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader "
      "--window-size=900,600 --virtual-time-budget=120000 --user-data-dir=profile --dump-dom "
      "\"file://$PWD/driven.html\" >dom.html 2>browser.txt";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string dom = ReadFile(folder_->path() / "dom.html").value();
  std::smatch result;
  ASSERT_TRUE(std::regex_search(dom, result, std::regex("data-result=\"([^\"]*)\"")))
      << ReadFile(folder_->path() / "browser.txt").value();
  const nlohmann::json said = nlohmann::json::parse(Unescaped(result[1]));
  SCOPED_TRACE(said.dump(1));
  EXPECT_TRUE(said.at("faults").empty());
  EXPECT_THAT(said.at("summary").get<std::string>(), HasSubstr("matched 3, missed 0, spurious 0"));
  EXPECT_EQ(said.at("atFirst"), "frame 29, 2.90 s  (30 of 30)");
  EXPECT_EQ(said.at("stepped"), "frame 2, 0.20 s  (3 of 30)");
  EXPECT_GT(said.at("imageColors"), 200) << "the photograph is there";
  EXPECT_GT(said.at("mapColors"), 50) << "shaded models";
  EXPECT_GT(said.at("outlinePixels"), 500);
  EXPECT_GT(said.at("truthPixels"), 100);
  ASSERT_EQ(said.at("selected").size(), 3u);
  for (const nlohmann::json& pair : said.at("selected"))
    EXPECT_THAT(pair[1].get<std::string>(), HasSubstr("#" + pair[0].get<std::string>() + " "));
  EXPECT_THAT(said.at("details").get<std::string>(), HasSubstr("true "));
  EXPECT_GE(said.at("hits"), 5);
  EXPECT_LE(said.at("disagree"), 2) << "beside outlines, which are drawn at half the size";
  EXPECT_GT(said.at("turnedPixels"), 1000);
  EXPECT_EQ(said.at("sought"), said.at("atFirst"));
  EXPECT_THAT(said.at("eventFrame").get<std::string>(), testing::StartsWith("frame 0,"));
  EXPECT_EQ(said.at("playing"), "Stop");
  EXPECT_THAT(said.at("played").get<std::string>(), Not(testing::StartsWith("frame 0,")));
  EXPECT_EQ(said.at("help"), true);
  EXPECT_EQ(said.at("otherTheme"), true);
  EXPECT_THAT(said.at("address").get<std::string>(), testing::StartsWith("#frame=29&object="));
}

/// A run whose names would like to be markup.
TEST(RunPageNames, StayText) {
  const std::string wicked = "</script><script>alert(1)</script>'\"\u2028<!--";
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "models");
  TriangleMesh wedge;
  wedge.vertices = {{-0.5f, -0.25f, 0}, {0.5f, -0.25f, 0}, {-0.5f, 0.25f, 0}, {-0.5f, -0.25f, 1}};
  wedge.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  ASSERT_TRUE(WritePly(folder.path() / "models" / "wedge.ply", wedge).ok());
  ASSERT_TRUE(WriteJson(folder.path() / "models" / "models.json",
                        {{"units", "m"},
                         {"models",
                          {{{"name", wicked},
                            {"file", "wedge.ply"},
                            {"category", "chair"},
                            {"symmetry", {{"axis", {0, 0, 1}}, {"order", 1}}},
                            {"support", "floor"}}}}})
                  .ok());
  RunHeader header;
  header.models = {{wicked, "chair"}};
  header.recipe.models = folder.path() / "models";
  header.recipe.sequence = folder.path() / "gone";
  FrameReport report;
  ObjectReport object;
  object.id = {1};
  object.state = ObjectState::kConfirmed;
  object.category = wicked;
  object.label = {0};
  object.label_probability = {{{0}, 1.0}};
  report.objects.push_back(object);
  report.events.push_back({EventKind::kSpawned, {1}, {}, wicked, ""});
  const std::string name = "<script>alert(2)<!-- run.plb";
  {
    const auto writer = RunWriter::Create(folder.path() / name, header).value();
    ASSERT_TRUE(writer->Write(report, {}).ok());
    ASSERT_TRUE(writer->Close().ok());
  }
  const ProgramRun page =
      RunProgram("report --interactive '" + name + "' --out page.html 2>&1", folder.path());
  ASSERT_EQ(page.exit_code, 0) << page.output;
  const std::string html = ReadFile(folder.path() / "page.html").value();
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<!-- run"))) << "would open a comment inside the script";
  EXPECT_THAT(html, Not(HasSubstr("\u2028")));
  EXPECT_EQ(DataOf(html).at("models")[0].at("name"), wicked) << "and they are what they were";
  EXPECT_EQ(DataOf(html).at("name"), name);
  EXPECT_THAT(DataOf(html).at("notice").get<std::string>(), HasSubstr("the page has none"));
}

TEST_F(RunPage, EvaluateTakesModelsAndTruthFromTheRun) {
  const ProgramRun named =
      Run("evaluate run.plb --ground-truth room/ground_truth.json --models room/models --json "
          "named.json");
  ASSERT_EQ(named.exit_code, 0) << named.output;
  const ProgramRun unnamed = Run("evaluate run.plb --json unnamed.json");
  ASSERT_EQ(unnamed.exit_code, 0) << unnamed.output;
  const auto json = ReadJson(folder_->path() / "unnamed.json").value();
  EXPECT_EQ(json, ReadJson(folder_->path() / "named.json").value());
  EXPECT_FALSE(json["objects"].empty());
}

}  // namespace
}  // namespace plumbline
