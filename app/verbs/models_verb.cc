// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/model_sheet.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/models/frame_settling.h"
#include "engine/models/model_builder.h"
#include "engine/models/model_check.h"

namespace plumbline {
namespace {

struct BuildArguments {
  std::vector<std::string> meshes;
  std::string out_folder, unit, up, front, category, sheet, json_file;
  int faces = 5000;
  int symmetry = 1;
  bool back = false;
};

struct CheckArguments {
  std::string folder, json_file;
};

ModelBuildOptions OptionsFrom(const BuildArguments& arguments) {
  ModelBuildOptions options;
  options.faces = arguments.faces;
  options.unit = ParseLengthUnit(arguments.unit);
  options.up = ParseSignedAxis(arguments.up);
  options.up_sign_stated = arguments.up.size() == 2;
  options.front = ParseSignedAxis(arguments.front);
  options.category = arguments.category;
  options.symmetry = arguments.symmetry;
  options.back = arguments.back;
  return options;
}

std::string Size(const Eigen::Vector3d& size_m) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.3g x %.3g x %.3g m", size_m.x(), size_m.y(), size_m.z());
  return text;
}

void PrintBuilt(const BuiltModel& built) {
  const ModelBuildReport& report = built.report;
  const CleanupReport& cleanup = report.cleanup;
  std::cout << built.model.name << " (" << built.model.category
            << "): " << Size(built.model.bounds.sizes().cast<double>()) << ", unit "
            << UnitText(report.unit.value) << ", up " << report.up.value.text() << ", front "
            << report.front.value.text() << "\n";
  for (const std::string& sentence : report.believed) std::cout << "  " << sentence << "\n";
  std::printf(
      "  cleaned: %d vertices merged, %d degenerate and %d duplicate faces, %d unused vertices "
      "dropped\n",
      cleanup.merged_vertices, cleanup.degenerate_faces, cleanup.duplicate_faces,
      cleanup.unreferenced_vertices);
  const DecimationReport& decimation = report.decimation;
  if (decimation.faces_after < decimation.faces_before) {
    std::printf("  decimated: %d of %d faces, %.2f mm off on average, %.2f mm at most",
                decimation.faces_after, decimation.faces_before, 1000 * decimation.mean_error_m,
                1000 * decimation.max_error_m);
    if (!built.model.mesh.colors.empty())
      std::printf(", colours %.1f grey levels", decimation.mean_color_error);
    std::printf("\n");
  } else {
    std::printf("  %d faces\n", decimation.faces_before);
  }
  if (!built.model.mesh.texture_file.empty())
    std::printf(
        "  texture kept as %s and painted on the vertices, %d faces added where it changes\n",
        built.model.mesh.texture_file.c_str(), report.faces_for_texture);
  std::fflush(stdout);
  for (const std::string& warning : report.warnings) std::cerr << "  warning: " << warning << "\n";
}

nlohmann::json ToJson(const BuiltModel& built) {
  const ModelBuildReport& report = built.report;
  const Eigen::Vector3f size = built.model.bounds.sizes();
  return {{"name", built.model.name},
          {"file", built.model.file},
          {"category", built.model.category},
          {"source", built.source.string()},
          {"unit", UnitText(report.unit.value)},
          {"up", report.up.value.text()},
          {"front", report.front.value.text()},
          {"confidence",
           {{"unit", report.unit.confidence},
            {"up", report.up.confidence},
            {"front", report.front.confidence}}},
          {"texture", built.model.mesh.texture_file},
          {"faces_for_texture", report.faces_for_texture},
          {"believed", report.believed},
          {"size_m", {size.x(), size.y(), size.z()}},
          {"faces_before", report.decimation.faces_before},
          {"faces", report.decimation.faces_after},
          {"mean_error_m", report.decimation.mean_error_m},
          {"max_error_m", report.decimation.max_error_m},
          {"warnings", report.warnings}};
}

/// The questions of all models in one picture, if there are any.
Status WriteSheet(const std::string& file, const std::vector<cv::Mat>& rows) {
  if (rows.empty()) {
    std::cerr << "nothing was unsure: '" << file << "' is not written\n";
    return {};
  }
  cv::Mat sheet;
  cv::vconcat(rows, sheet);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", sheet, bytes);
  return WriteFileAtomically(file, std::string(bytes.begin(), bytes.end()));
}

Status Build(const BuildArguments& arguments) {
  const ModelBuildOptions options = OptionsFrom(arguments);
  ConsoleWork work;
  std::vector<cv::Mat> questions;
  nlohmann::json results = nlohmann::json::array();
  std::vector<Error> failures;
  for (const std::string& mesh : arguments.meshes) {
    if (work.interrupted())
      return Error{ErrorCode::kCancelled, "stopped; the models built so far are kept"};
    const Result<BuiltModel> built = BuildModel(mesh, options);
    const Status stored =
        built.ok() ? StoreModel(*built, arguments.out_folder) : Status(built.error());
    if (!stored.ok()) {
      failures.push_back(stored.error());
      if (arguments.meshes.size() > 1) std::cerr << "plumbline: " << stored.error().message << "\n";
      continue;
    }
    if (arguments.json_file != "-") PrintBuilt(*built);
    if (!arguments.sheet.empty()) AddQuestions(*built, questions);
    results.push_back(ToJson(*built));
  }
  if (!arguments.sheet.empty()) {
    if (const Status written = WriteSheet(arguments.sheet, questions); !written.ok())
      return written;
  }
  if (!arguments.json_file.empty()) {
    if (const Status written = WriteJsonResult(arguments.json_file, results); !written.ok())
      return written;
  }
  if (failures.empty()) return {};
  if (arguments.meshes.size() == 1) return failures.front();
  return Error{failures.front().code, std::to_string(failures.size()) + " of " +
                                          std::to_string(arguments.meshes.size()) +
                                          " meshes could not be built; the reasons are above"};
}

nlohmann::json ToJson(const ModelCheck& check) {
  return {{"name", check.name},
          {"file", check.file},
          {"category", check.category},
          {"faces", check.faces},
          {"vertices", check.vertices},
          {"open_edges", check.edges.open},
          {"non_manifold_edges", check.edges.non_manifold},
          {"size_m", {check.size_m.x(), check.size_m.y(), check.size_m.z()}},
          {"footprint_m", {check.footprint_m.x(), check.footprint_m.y()}},
          {"lowest_m", check.lowest_m},
          {"colors", check.has_colors},
          {"texture", check.has_texture},
          {"warnings", check.warnings},
          {"problems", check.problems}};
}

void PrintTable(const std::vector<ModelCheck>& checks) {
  std::size_t name_width = 5, category_width = 8;
  for (const ModelCheck& check : checks) {
    name_width = std::max(name_width, check.name.size());
    category_width = std::max(category_width, check.category.size());
  }
  const int name = static_cast<int>(name_width), category = static_cast<int>(category_width);
  std::printf("%-*s  %-*s  %7s  %6s  %12s  %-24s  %9s  %7s  %s\n", name, "model", category,
              "category", "faces", "open", "non-manifold", "depth x width x height", "footprint",
              "lowest", "surface");
  for (const ModelCheck& check : checks) {
    const char* surface = check.has_texture ? "texture" : check.has_colors ? "colours" : "plain";
    std::printf("%-*s  %-*s  %7d  %6d  %12d  %-24s  %6.0f mm  %4.0f mm  %s\n", name,
                check.name.c_str(), category, check.category.c_str(), check.faces, check.edges.open,
                check.edges.non_manifold, Size(check.size_m).c_str(),
                1000 * check.footprint_m.norm(), 1000 * check.lowest_m,
                check.problems.empty() ? surface : "UNUSABLE");
  }
  std::printf(
      "open, non-manifold: edges of one face and of three or more; footprint: centre of the "
      "footprint off the "
      "origin; lowest: above the supporting plane\n");
  for (const ModelCheck& check : checks) {
    for (const std::string& problem : check.problems)
      std::printf("%s: unusable: %s\n", check.name.c_str(), problem.c_str());
    for (const std::string& warning : check.warnings)
      std::printf("%s: %s\n", check.name.c_str(), warning.c_str());
  }
}

Status Check(const CheckArguments& arguments) {
  const Result<std::vector<ModelCheck>> checks = CheckModels(arguments.folder);
  if (!checks.ok()) return checks.error();
  if (arguments.json_file != "-") PrintTable(*checks);
  nlohmann::json results = nlohmann::json::array();
  int unusable = 0;
  for (const ModelCheck& check : *checks) {
    results.push_back(ToJson(check));
    unusable += check.problems.empty() ? 0 : 1;
  }
  if (!arguments.json_file.empty()) {
    if (const Status written = WriteJsonResult(arguments.json_file, results); !written.ok())
      return written;
  }
  if (unusable == 0) return {};
  return Error{ErrorCode::kInvalidInput,
               std::to_string(unusable) + " of " + std::to_string(checks->size()) + " models in '" +
                   arguments.folder + "' cannot be used; build them again"};
}

void AddBuild(CLI::App& models, VerbFunction& chosen) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* verb = models.add_subcommand("build",
                                         "Bring meshes into the canonical frame (metres, +z up, +x "
                                         "front) and enter them in a database");
  verb->add_option("meshes", arguments->meshes,
                   "PLY, OBJ, GLB, GLTF, STL, DAE, FBX, OFF, 3DS files and what else assimp reads")
      ->required()
      ->type_name("MESH");
  verb->add_option("--out", arguments->out_folder,
                   "Database folder; models of the same name are replaced")
      ->required()
      ->type_name("DIR");
  verb->add_option(
          "--faces", arguments->faces,
          "Decimate to at most this many faces; where a texture changes, as many again may be "
          "added")
      ->capture_default_str()
      ->check(CLI::Range(4, 10000000))
      ->type_name("N");
  verb->add_option(
          "--unit", arguments->unit,
          "Unit of the files; if not given, as the file states, else guessed from the size")
      ->check(CLI::IsMember({"m", "cm", "mm"}));
  verb->add_option(
          "--up", arguments->up,
          "The files' axis that points up. Without a sign the axis only: it is turned "
          "over, with a warning, if "
          "the shape clearly stands the other way. If not given, as the file states, else guessed")
      ->check(CLI::IsMember({"x", "y", "z", "+x", "-x", "+y", "-y", "+z", "-z"}));
  verb->add_option("--front", arguments->front,
                   "The files' axis that the front faces (of a chair: the side a sitter faces); "
                   "guessed if not given")
      ->check(CLI::IsMember({"+x", "-x", "+y", "-y", "+z", "-z"}));
  verb->add_option(
          "--category", arguments->category,
          "COCO category; if not given, what the words of the file's name say (sofa: couch)")
      ->type_name("NAME");
  verb->add_option("--symmetry", arguments->symmetry,
                   "Order of symmetry about the vertical: 1 none, 2 half turns, 0 continuous")
      ->capture_default_str()
      ->check(CLI::Range(0, 360))
      ->type_name("N");
  verb->add_flag("--back", arguments->back,
                 "It always stands with its back to a wall, as a cabinet may: no camera sees it "
                 "from behind. A model that is replaced keeps what models.json says of it");
  verb->add_option(
          "--sheet", arguments->sheet,
          "Where up or front is unsure (under 80 %), a picture of all six ups and all four "
          "fronts to choose from")
      ->type_name("FILE.png");
  verb->add_option("--json", arguments->json_file,
                   "Also write what was done as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Build(*arguments); }; });
}

void AddCheck(CLI::App& models, VerbFunction& chosen) {
  auto arguments = std::make_shared<CheckArguments>();
  CLI::App* verb = models.add_subcommand(
      "check", "Report faces, open edges, scale and footprint of a database's models");
  verb->add_option("folder", arguments->folder, "Folder with models.json")
      ->required()
      ->type_name("DIR");
  verb->add_option("--json", arguments->json_file,
                   "Also write the table as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Check(*arguments); }; });
}

}  // namespace

void AddModelsVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* models = app.add_subcommand("models", "Build and check databases of object models");
  models->require_subcommand(1);
  AddBuild(*models, chosen);
  AddCheck(*models, chosen);
}

}  // namespace plumbline
