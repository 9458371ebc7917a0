// SPDX-License-Identifier: Apache-2.0
#include "tests/project/source_rules.h"

#include <algorithm>
#include <array>
#include <optional>
#include <regex>

namespace plumbline {
namespace {

/// One #include line.
struct Include {
  int line = 0;
  std::string file;
  bool quoted = false;
};

/// The modules of the engine from the lowest layer up. Those of one layer do not include one
/// another, except as `MayUseSibling` says.
constexpr std::array<std::string_view, 25> kModules = {
    "base",      "geometry",  "sensor",   "dataset",      "sources",    "models",     "render",
    "vision",    "tracking",  "mapping",  "registration", "annotation", "evaluation", "vio",
    "synthetic", "smoothing", "snapshot", "transport",    "pipeline",   "recording",  "session",
    "analysis",  "batch",     "nodes",    "runtime"};
bool IsSibling(int layer) { return layer >= 9 && layer <= 13; }

bool StartsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

bool EndsWith(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

/// "mapping" of "engine/mapping/filter.h"; "" of what is not in the engine.
std::string_view EngineModule(std::string_view path) {
  if (!StartsWith(path, "engine/")) return {};
  path.remove_prefix(7);
  return path.substr(0, path.find('/'));
}

std::optional<int> Layer(std::string_view module) {
  const auto found = std::find(kModules.begin(), kModules.end(), module);
  if (found == kModules.end()) return std::nullopt;
  return static_cast<int>(found - kModules.begin());
}

bool MayUseSibling(std::string_view module, std::string_view sibling) {
  return sibling == "registration" && (module == "annotation" || module == "evaluation");
}

/// Values that the snapshot and the panels may see of any module.
bool IsOptionsHeader(std::string_view file) { return EndsWith(file, "_options.h"); }
bool IsReportHeader(std::string_view file) { return EndsWith(file, "_report.h"); }
bool IsInstanceHeader(std::string_view file) {
  return file == "engine/annotation/annotated_instance.h" ||
         file == "engine/annotation/project_state.h" || file == "engine/annotation/refine_by.h";
}

/// Private to engine/render: the only headers of the engine with OpenGL in them.
bool IsGlHeader(std::string_view file) {
  return StartsWith(file, "engine/render/gl_") && EndsWith(file, ".h");
}

bool HoldsPanels(std::string_view path) {
  return StartsWith(path, "ui/common/") || StartsWith(path, "ui/inspect/") ||
         StartsWith(path, "ui/annotate/");
}

/// Why `path` may not include our own `file`; "" if it may.
std::string WrongLayer(std::string_view path, std::string_view file) {
  const std::string_view used = EngineModule(file);
  if (IsGlHeader(file) && EngineModule(path) != "render")
    return "engine/render/gl_*.h are private to engine/render";
  if (StartsWith(path, "engine/")) {
    if (!StartsWith(file, "engine/")) return "the engine includes nothing but the engine";
    const std::string_view module = EngineModule(path);
    if (module == used) return "";
    const std::optional<int> from = Layer(module), to = Layer(used);
    if (!from || !to)
      return "this module has no place in the order of layers (tests/project/source_rules.cc)";
    if (module == "snapshot") {
      const bool value = used == "base" || used == "geometry" || IsOptionsHeader(file) ||
                         IsReportHeader(file) || IsInstanceHeader(file);
      return value ? ""
                   : "a snapshot includes base, geometry, *_options.h and *_report.h, nothing else";
    }
    if (IsSibling(*from) && IsSibling(*to)) {
      return MayUseSibling(module, used) ? ""
                                         : "mapping, registration, annotation, evaluation and vio "
                                           "do not include one another";
    }
    if (*to > *from) return "a module includes only what stands below it";
    return "";
  }
  if (StartsWith(path, "ui/")) {
    if (!StartsWith(file, "ui/") && !StartsWith(file, "engine/"))
      return "the window never includes the program";
    if (!HoldsPanels(path) || !StartsWith(file, "engine/")) return "";
    const bool value =
        used == "snapshot" || used == "base" || used == "geometry" || IsOptionsHeader(file);
    return value ? ""
                 : "a panel sees snapshot, base, geometry and *_options.h of the engine, nothing "
                   "else";
  }
  if (StartsWith(path, "app/") && StartsWith(file, "tests/"))
    return "the program never includes tests";
  if (StartsWith(path, "app/window/") && file == "engine/recording/run_file.h")
    return "no run file is opened on the window's thread; engine/runtime does it";
  return "";
}

bool Matches(const std::string& text, const char* expression) {
  return std::regex_search(text, std::regex(expression));
}

/// Why `path` may not include a library's `file`; "" if it may.
std::string WrongLibrary(std::string_view path, const std::string& file) {
  const bool engine = StartsWith(path, "engine/");
  const bool in_scene = StartsWith(path, "ui/scene/") || StartsWith(path, "tests/ui/");
  if (Matches(file, "highgui")) return "OpenCV's highgui is used nowhere";
  if (engine && Matches(file, "imgui|GLFW/")) return "the engine opens no window";
  if (Matches(file, "^(epoxy|GL|GLES[0-9]?|EGL|KHR|GLFW)/|imgui_impl_")) {
    const bool in_render =
        IsGlHeader(path) || (StartsWith(path, "engine/render/") && EndsWith(path, ".cc"));
    const bool allowed = in_render || StartsWith(path, "ui/") ||
                         StartsWith(path, "app/platform/") || StartsWith(path, "tests/");
    if (!allowed)
      return "OpenGL is included only in engine/render/ (*.cc, gl_*.h), ui/ and app/platform/";
  }
  if (Matches(file, "^vtk")) {
    const bool rendering =
        Matches(file,
                "Actor|Camera|Chart|Context|Interactor|Light|Mapper|OpenGL|Picker|Plot|Prop|Render|"
                "Texture|Widget|Window");
    if (rendering && !in_scene) return "VTK's rendering headers are included only in ui/scene";
    if (engine && !EndsWith(path, ".cc")) return "the engine uses VTK in .cc files only";
    // Tests may compare with VTK, which we did not write.
    const bool test = path.rfind("tests/", 0) == 0;
    if (!engine && !in_scene && !test) return "VTK stays in ui/scene";
  }
  return "";
}

std::vector<std::string> Lines(std::string_view content) {
  std::vector<std::string> lines;
  while (!content.empty()) {
    const std::size_t end = std::min(content.find('\n'), content.size());
    lines.emplace_back(content.substr(0, end));
    content.remove_prefix(std::min(end + 1, content.size()));
  }
  return lines;
}

std::optional<Include> ParseInclude(const std::string& line, int number) {
  static const std::regex kInclude(R"rx(^\s*#\s*include\s*(["<])([^">]+)[">])rx");
  std::smatch match;
  if (!std::regex_search(line, match, kInclude)) return std::nullopt;
  return Include{number, match[2], match[1] == "\""};
}

std::string WrongInclude(std::string_view path, const Include& include) {
  if (!include.quoted) return WrongLibrary(path, include.file);
  if (!Matches(include.file, "^(app|engine|ui|tests|cmake)/"))
    return "quoted includes start at the top of the source tree";
  return WrongLayer(path, include.file);
}

/// Files that carry the licence line: code and build scripts, whatever their language.
bool NeedsLicence(std::string_view path) {
  static constexpr std::string_view kEndings[] = {".h",    ".cc",   ".cmake", "CMakeLists.txt",
                                                  ".glsl", ".vert", ".frag",  ".geom",
                                                  ".comp", ".py",   ".sh",    ".supp"};
  return path == "dev" || path == ".ci/run" ||
         std::any_of(std::begin(kEndings), std::end(kEndings),
                     [&](auto ending) { return EndsWith(path, ending); });
}

/// On the first line, or below the interpreter or the version that must stand there.
bool HasLicence(const std::vector<std::string>& lines) {
  const bool below =
      !lines.empty() && (StartsWith(lines[0], "#!") || StartsWith(lines[0], "#version"));
  const std::size_t first = below ? 1 : 0;
  return lines.size() > first &&
         lines[first].find("SPDX-License-Identifier: Apache-2.0") != std::string::npos;
}

}  // namespace

std::vector<std::string> SourceViolations(std::string_view path, std::string_view content) {
  // Folders of one machine. Put together here, so that this file passes its own test.
  static const std::regex kMachineFolder("(^|[^A-Za-z0-9_.~/}$-])/(home|root|work|Users)/");
  static const std::regex kEndsTheProgram(
      R"((^|[^A-Za-z0-9_.>:])(::|std::)?(_?exit|quick_exit|abort|terminate)\s*\()");
  const std::vector<std::string> lines = Lines(content);
  const bool code = EndsWith(path, ".h") || EndsWith(path, ".cc");
  std::vector<std::string> violations;
  const auto add = [&](int line, const std::string& what) {
    violations.push_back(std::string(path) + ":" + std::to_string(line) + ": " + what);
  };
  if (StartsWith(path, "engine/snapshot/") && EndsWith(path, ".cc"))
    add(1, "engine/snapshot holds values and computes nothing; engine/analysis does");
  if (NeedsLicence(path) && !HasLicence(lines))
    add(1, "the first line is not the SPDX licence line");
  bool shared = true;
  for (int i = 0; i < static_cast<int>(lines.size()); ++i) {
    if (StartsWith(lines[i], "namespace {")) shared = false;
    if (lines[i] == "}  // namespace") shared = true;
    if (code && shared && StartsWith(lines[i], "PLUMBLINE_VECTORISED"))
      add(i + 1, "clang 14 compiles once what others may call; keep it in the unnamed namespace");
    if (std::regex_search(lines[i], kMachineFolder)) add(i + 1, "names a folder of one machine");
    if (!code) continue;
    if (StartsWith(path, "engine/") && std::regex_search(lines[i], kEndsTheProgram)) {
      add(i + 1, "the engine never ends the program; return an Error or use PLB_CHECK");
    }
    if (const std::optional<Include> include = ParseInclude(lines[i], i + 1)) {
      const std::string why = WrongInclude(path, *include);
      if (!why.empty()) add(i + 1, "includes " + include->file + ", but " + why);
    }
  }
  return violations;
}

}  // namespace plumbline
