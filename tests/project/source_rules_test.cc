// SPDX-License-Identifier: Apache-2.0
#include "tests/project/source_rules.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The violations of a file at `path` whose only line, besides the licence, is `line`.
std::vector<std::string> Check(const std::string& path, const std::string& line) {
  return SourceViolations(path, "// SPDX-License-Identifier: Apache-2.0\n" + line + "\n");
}

std::string Quoted(const std::string& file) { return "#include \"" + file + "\""; }
std::string Angled(const std::string& file) { return "#include <" + file + ">"; }

TEST(SourceRules, AllowWhatTheLayersAllow) {
  const std::vector<std::pair<std::string, std::string>> allowed = {
      {"engine/mapping/filter.cc", Quoted("engine/vision/detector.h")},
      {"engine/mapping/filter.cc", Quoted("engine/mapping/filter.h")},
      {"engine/annotation/project.cc", Quoted("engine/registration/icp.h")},
      {"engine/evaluation/surface.cc", Quoted("engine/registration/icp.h")},
      {"engine/recording/run_file.h", Quoted("engine/mapping/map_report.h")},
      {"engine/snapshot/map_snapshot.h", Quoted("engine/mapping/map_report.h")},
      {"engine/snapshot/commands.h", Quoted("engine/mapping/mapper_options.h")},
      {"engine/runtime/mapping_process.cc", Quoted("engine/snapshot/map_snapshot.h")},
      {"engine/session/session.cc", Quoted("engine/snapshot/annotation_snapshot.h")},
      {"engine/snapshot/annotation_snapshot.h", Quoted("engine/annotation/annotated_instance.h")},
      {"engine/runtime/worker.cc", Quoted("engine/session/session.h")},
      {"engine/geometry/decimate.cc", Angled("vtkQuadricDecimation.h")},
      {"engine/render/gl_context.cc", Angled("epoxy/egl.h")},
      {"engine/render/gl_util.h", Angled("epoxy/gl.h")},
      {"engine/render/renderer.cc", Quoted("engine/render/gl_util.h")},
      {"ui/inspect/timeline/timeline.cc", Quoted("engine/snapshot/map_snapshot.h")},
      {"ui/annotate/options.cc", Quoted("engine/mapping/mapper_options.h")},
      {"ui/scene/scene_view.cc", Angled("vtkRenderer.h")},
      {"app/platform/window.cc", Angled("GLFW/glfw3.h")},
      {"app/verbs/run_verb.cc", Quoted("engine/runtime/mapping_process.h")},
      {"docs/architecture.md", "see https://example.org/work/notes and build/work/x"},
  };
  for (const auto& [path, line] : allowed) EXPECT_THAT(Check(path, line), IsEmpty());
}

TEST(SourceRules, NameWhatTheLayersForbid) {
  const std::vector<std::array<std::string, 3>> forbidden = {
      {"engine/base/files.cc", Quoted("engine/geometry/mesh.h"), "stands below it"},
      {"engine/vision/edges.cc", Quoted("engine/mapping/filter.h"), "stands below it"},
      {"engine/mapping/filter.cc", Quoted("engine/registration/icp.h"), "one another"},
      {"engine/evaluation/pose.cc", Quoted("engine/mapping/filter.h"), "one another"},
      {"engine/registration/icp.cc", Quoted("engine/annotation/project.h"), "one another"},
      {"engine/mapping/filter.cc", Quoted("engine/snapshot/map_snapshot.h"), "stands below it"},
      {"engine/snapshot/map_snapshot.h", Quoted("engine/sensor/camera.h"), "nothing else"},
      {"engine/runtime/worker.cc", Quoted("ui/framework/panel.h"), "nothing but the engine"},
      {"engine/runtime/worker.cc", Quoted("app/verbs/verb.h"), "nothing but the engine"},
      {"engine/novelty/a.cc", Quoted("engine/base/result.h"), "no place in the order"},
      {"ui/inspect/map/map_panel.cc", Quoted("engine/mapping/filter.h"), "a panel sees"},
      {"ui/inspect/map/map_panel.cc", Angled("vtkNew.h"), "VTK stays in ui/scene"},
      {"ui/framework/panel.h", Quoted("app/window/application.h"), "never includes the program"},
      {"app/main.cc", Quoted("tests/support/test_data.h"), "never includes tests"},
      {"app/window/inspect/what_if.cc", Quoted("engine/recording/run_file.h"), "window's thread"},
      {"app/main.cc", Angled("vtkRenderer.h"), "only in ui/scene"},
      {"app/main.cc", Angled("GLFW/glfw3.h"), "app/platform"},
      {"engine/geometry/decimate.h", Angled("vtkQuadricDecimation.h"), ".cc files only"},
      {"engine/geometry/decimate.cc", Angled("vtkPolyDataMapper.h"), "only in ui/scene"},
      {"engine/render/renderer.h", Angled("epoxy/gl.h"), "engine/render/ (*.cc, gl_*.h)"},
      {"engine/vision/edges.cc", Angled("epoxy/gl.h"), "engine/render/ (*.cc, gl_*.h)"},
      {"engine/vision/edges.cc", Quoted("engine/render/gl_util.h"), "private"},
      {"app/main.cc", Quoted("engine/render/gl_util.h"), "private"},
      {"engine/runtime/worker.cc", Angled("imgui.h"), "opens no window"},
      {"engine/vision/edges.cc", Angled("opencv2/highgui.hpp"), "highgui"},
      {"engine/vision/edges.cc", Quoted("edges.h"), "start at the top"},
      {"engine/vision/edges.cc", "  #  include \"../base/files.h\"", "start at the top"},
      {"engine/vision/edges.cc", "  std::exit(1);", "never ends the program"},
      {"docs/architecture.md", "look into /ho" + std::string("me/somebody/plumbline"),
       "one machine"},
      {"tests/data/a.json", "{\"file\": \"/wo" + std::string("rk/shared/a.png\"}"), "one machine"},
  };
  for (const auto& [path, line, why] : forbidden) {
    EXPECT_THAT(Check(path, line), ElementsAre(HasSubstr(why))) << path << " with " << line;
  }
}

TEST(SourceRules, KeepWhatIsCompiledSeveralTimesToItsFile) {
  const std::string function = "PLUMBLINE_VECTORISED\nvoid Sum() {}\n";
  EXPECT_THAT(Check("engine/vision/a.cc", "namespace {\n" + function + "}  // namespace\n"),
              IsEmpty());
  EXPECT_THAT(Check("engine/vision/a.cc", "namespace {\n}  // namespace\n" + function),
              ElementsAre(HasSubstr("unnamed namespace")));
}

TEST(SourceRules, WantTheLicenceOnTheFirstLineThatMayHoldIt) {
  const std::string licence = "SPDX-License-Identifier: Apache-2.0\n";
  EXPECT_THAT(SourceViolations("shaders/a.frag", "// " + licence + "#version 450\n"), IsEmpty());
  EXPECT_THAT(SourceViolations("shaders/a.frag", "#version 450\n// " + licence), IsEmpty());
  EXPECT_THAT(SourceViolations("shaders/a.frag", "#version 450\nvoid main() {}\n"),
              ElementsAre(HasSubstr("SPDX")));
  EXPECT_THAT(SourceViolations("dev", "#!/usr/bin/env bash\n# " + licence), IsEmpty());
  EXPECT_THAT(SourceViolations("engine/base/empty.cc", ""), ElementsAre(HasSubstr("SPDX")));
  EXPECT_THAT(SourceViolations("README.md", "# Plumbline\n"), IsEmpty());
}

/// Every file of the project, without asking git: a tarball has none.
std::vector<std::string> ProjectFiles() {
  static const std::set<std::string> kText = {".h",    ".cc",   ".cmake", ".txt",  ".md",   ".json",
                                              ".glsl", ".vert", ".frag",  ".geom", ".comp", ".py",
                                              ".sh",   ".supp", ".svg",   ".csv",  ".yml",  ""};
  std::vector<std::string> files;
  const std::filesystem::path root = SourceDirectory();
  for (const auto& top : std::filesystem::directory_iterator(root)) {
    if (top.is_regular_file() && top.path().filename() != ".git")
      files.push_back(top.path().filename());
  }
  for (const char* folder :
       {".ci", "app", "assets", "cmake", "docs", "engine", "shaders", "tests", "ui"}) {
    if (!std::filesystem::exists(root / folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      if (entry.is_regular_file())
        files.push_back(entry.path().lexically_relative(root).generic_string());
    }
  }
  std::erase_if(files, [](const std::string& f) {
    return !kText.contains(std::filesystem::path(f).extension());
  });
  return files;
}

TEST(ProjectFiles, KeepTheRules) {
  const std::vector<std::string> files = ProjectFiles();
  EXPECT_GT(files.size(), 50u);
  for (const std::string& file : files) {
    Result<std::string> content = ReadFile(SourceDirectory() / file);
    ASSERT_TRUE(content.ok()) << content.error().message;
    EXPECT_THAT(SourceViolations(file, *content), IsEmpty());
  }
}

TEST(ProjectFiles, LinkOnlyToWhatIsThere) {
  static const std::regex kLink(R"(\]\(([^)#:]+)[^):]*\))");  // without those of the web
  for (const std::string& file : ProjectFiles()) {
    if (!file.ends_with(".md")) continue;
    const std::filesystem::path path = SourceDirectory() / file;
    const std::string content = ReadFile(path).value();
    for (std::sregex_iterator match(content.begin(), content.end(), kLink), end; match != end;
         ++match) {
      EXPECT_TRUE(std::filesystem::exists(path.parent_path() / match->str(1)))
          << file << " links to " << match->str(1);
    }
  }
}

/// Names of the types that a source file defines for others to see: at the start of a line and
/// outside of unnamed namespaces, as clang-format leaves them. With their namespaces inside of
/// `plumbline`.
std::vector<std::string> TypesOf(const std::string& content) {
  static const std::regex kNamespace(R"(^namespace ?([\w:]*) ?\{$)"),
      kEnd(R"(^\}  // namespace.*)"),
      kType(R"(^(?:struct|class|enum class) (\w+)(?: final)?(?: : [^;]*)?(?: \{.*)?$)");
  std::vector<std::string> types, namespaces;
  std::istringstream lines(content);
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || std::string_view("ncse}").find(line.front()) == std::string_view::npos)
      continue;  // most lines
    if (std::regex_match(line, match, kNamespace)) {
      namespaces.push_back(match[1]);
    } else if (std::regex_match(line, kEnd) && !namespaces.empty()) {
      namespaces.pop_back();
    } else if (std::regex_match(line, match, kType) &&
               std::find(namespaces.begin(), namespaces.end(), "") == namespaces.end()) {
      std::string name;
      for (const std::string& outer : namespaces) name += outer + "::";
      types.push_back(name + match.str(1));
    }
  }
  return types;
}

TEST(TypesOf, AreThoseThatOthersSee) {
  EXPECT_THAT(TypesOf("namespace plumbline {\nnamespace {\nstruct Own {\n};\n}  // namespace\n"
                      "struct Seen {\n  struct Inner {\n};\n};\nclass Named;\n"
                      "class Derived final : public Seen {\nstruct Seen::Other {\n"
                      "namespace sqlite {\nenum class Access { kRead };\n}  // namespace sqlite\n"),
              ElementsAre("plumbline::Seen", "plumbline::Derived", "plumbline::sqlite::Access"));
}

// Two types of one name in one program share their templates, whichever the linker finds first: a
// vector of the larger was grown as one of the smaller (Sight of smoothing and of vio, 2026-11-28).
TEST(ProjectFiles, DefineATypeOnce) {
  std::map<std::string, std::string> places;
  for (const std::string& file : ProjectFiles()) {
    const bool program =
        file.starts_with("engine/") || file.starts_with("ui/") || file.starts_with("app/");
    if (!program || !(file.ends_with(".h") || file.ends_with(".cc"))) continue;
    for (const std::string& type : TypesOf(ReadFile(SourceDirectory() / file).value())) {
      const auto [place, is_new] = places.emplace(type, file);
      EXPECT_TRUE(is_new) << type << " is defined in " << place->second << " and in " << file
                          << "; rename one of them";
    }
  }
  EXPECT_GT(places.size(), 500u);
}

}  // namespace
}  // namespace plumbline
