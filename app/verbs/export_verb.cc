// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <memory>

#include "app/verbs/room_export.h"
#include "app/verbs/verb.h"
#include "engine/analysis/relations.h"
#include "engine/analysis/run_tables.h"
#include "engine/base/log.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/map_mesh.h"
#include "engine/recording/run_summary.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

struct ExportArguments {
  std::string run, format, out, models, sequence, frames, up = "y";
  bool smoothed = false;
  bool own_colors = false;
};

/// The objects to draw: of the end of the run, or smoothed. Errors: kNotFound for a run that has
/// not been smoothed.
Result<std::vector<EstimatedObject>> ObjectsToWrite(const ExportArguments& arguments) {
  if (!arguments.smoothed) return ReadEstimates(arguments.run);
  auto smoothed = ReadSmoothedEstimates(arguments.run);
  if (!smoothed) return smoothed.error();
  if (!*smoothed) {
    return Error{ErrorCode::kNotFound,
                 arguments.run + " has not been smoothed; 'plumbline smooth' does that"};
  }
  return std::move(**smoothed);
}

/// How the objects of the last frame that was used stand to one another, and which it shows.
/// Errors: of opening the run with its models; kNotFound where every frame was skipped.
Result<nlohmann::json> RelationsJson(const ExportArguments& arguments) {
  auto source = OpenRunSource({arguments.run, {}, arguments.models}, WorkContext());
  if (!source) return source.error();
  for (int i = (*source)->mapped() - 1; i >= 0; --i) {
    const auto snapshot = (*source)->Past(i, {});
    if (!snapshot) return snapshot.error();
    if (!(*snapshot)->report.skipped.empty()) continue;
    const FrameReport& report = (*snapshot)->report;
    nlohmann::json in_view = nlohmann::json::array(), relations = nlohmann::json::array();
    for (const ObjectReport& object : report.objects) {
      if (object.state == ObjectState::kConfirmed && !object.visible_box.empty())
        in_view.push_back(object.id.value);
    }
    for (const ObjectRelation& r :
         RelationFinder().Find(report, (*source)->view(), (*snapshot)->depth, (*snapshot)->id)) {
      const char* value = r.kind == RelationKind::kHides ? "share" : "gap_m";
      relations.push_back(
          {{"a", r.a.value}, {"is", RelationName(r.kind)}, {"b", r.b.value}, {value, r.value}});
    }
    return nlohmann::json{{"frame", report.frame}, {"in_view", in_view}, {"relations", relations}};
  }
  return Error{ErrorCode::kNotFound, "no frame of " + arguments.run + " was used"};
}

Status ExportJson(RunReader& reader, const ExportArguments& arguments) {
  const auto models = LoadModelsOfRun({arguments.run, {}, arguments.models}, reader.header());
  Result<nlohmann::json> json = RunResultJson(reader, models ? models->get() : nullptr);
  if (!json) return json.error();
  const Result<nlohmann::json> relations = RelationsJson(arguments);
  if (relations)
    (*json)["last_frame"] = *relations;
  else
    log::warn("relations are left out: {}", relations.error().message);
  return WriteJsonResult(arguments.out, *json);
}

Status ExportPly(RunReader& reader, const ExportArguments& arguments) {
  const std::filesystem::path folder = arguments.models.empty()
                                           ? reader.header().recipe.models
                                           : std::filesystem::path(arguments.models);
  const Result<std::shared_ptr<const ModelDatabase>> database = ModelDatabase::Load(folder);
  if (!database) {
    return Error{database.error().code,
                 database.error().message + "; name the models of the run with --models DIR"};
  }
  if ((*database)->content_hash() != reader.header().models_hash) {
    log::warn(
        "the models in {} are not those of the run; the meshes may differ from what was mapped",
        folder.string());
  }
  const Result<std::vector<EstimatedObject>> objects = ObjectsToWrite(arguments);
  if (!objects) return objects.error();
  const Result<TriangleMesh> mesh =
      MapMesh(*objects, **database, arguments.own_colors ? MapColors::kOwn : MapColors::kByObject);
  if (!mesh) return mesh.error();
  return WritePly(arguments.out, *mesh);
}

Status ExportCsv(RunReader&, const ExportArguments& arguments) {
  const auto review = ReviewRun({arguments.run, {}, arguments.models}, {}, WorkContext());
  if (!review) return review.error();
  return WriteRunTables(arguments.out, *review);
}

/// The formats of posed objects, which annotations have, too.
Status ExportRoom(RunReader& reader, const ExportArguments& arguments) {
  const Result<std::vector<EstimatedObject>> objects = ObjectsToWrite(arguments);
  if (!objects) return objects.error();
  ExportRequest request{arguments.format, arguments.out, PoseFrame::kLevel};
  request.up = UpFrom(arguments.up);
  // Of these two, BOP has a world of its own: that of the run.
  if (arguments.format != "gltf") request.frame = PoseFrame::kScan;
  return ExportRoomOfRun({arguments.run, arguments.sequence, arguments.models}, reader.header(),
                         *objects, request, arguments.frames);
}

struct Format {
  std::string name;
  Status (*write)(RunReader& reader, const ExportArguments& arguments);
};

// One line for each format.
const std::array kFormats = {
    Format{"json", ExportJson},
    Format{"csv", ExportCsv},
    Format{"ply", ExportPly},
};

Status Export(const ExportArguments& arguments) {
  const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(arguments.run);
  if (!reader) return reader.error();
  if (arguments.own_colors && arguments.format != "ply") {
    return Error{ErrorCode::kInvalidInput, "--own-colors goes with --format ply"};
  }
  if (arguments.smoothed && (arguments.format == "json" || arguments.format == "csv")) {
    return Error{ErrorCode::kInvalidInput,
                 "--smoothed goes with formats that draw or pose objects; json holds both maps "
                 "anyway"};
  }
  for (const Format& format : kFormats) {
    if (format.name == arguments.format) return format.write(**reader, arguments);
  }
  return ExportRoom(**reader, arguments);
}

}  // namespace

void AddExportVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* verb = app.add_subcommand("export", "Write the map of a run for other programs");
  verb->add_option("run", arguments->run, "A run file")->required()->type_name("RUN.plb");
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  for (const std::string& name : RoomFormats(ExportedFrom::kRun)) names.push_back(name);
  verb->add_option(
          "--format", arguments->format,
          "json: the result of 'run --json', smoothed or not, and the relations of the last frame. "
          "csv: a folder of tables (objects, frames, events, timings). ply: one mesh of the "
          "confirmed objects, each in its colour. The confirmed objects as 'annotate export' "
          "writes annotations: " +
              RoomFormatsHelp(ExportedFrom::kRun))
      ->required()
      ->check(CLI::IsMember(names));
  verb->add_option("--out", arguments->out, "Where to (json: '-' is standard output)")
      ->required()
      ->type_name("PATH");
  verb->add_flag("--smoothed", arguments->smoothed,
                 "The objects where the second pass has them (run --smooth, smooth)");
  verb->add_option("--frames", arguments->frames,
                   "bop, coco and poses: which frames (B excluded); else those of the run")
      ->type_name("A:B[:S]");
  verb->add_option("--up", arguments->up, "gltf: the file's axis that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  verb->add_option("--sequence", arguments->sequence, "The sequence of the run, if it has moved")
      ->type_name("DIR");
  verb->add_flag("--own-colors", arguments->own_colors,
                 "ply: the models in the colours that they have in the database");
  verb->add_option("--models", arguments->models, "The models of the run, if they have moved")
      ->type_name("DIR");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Export(*arguments); }; });
}

}  // namespace plumbline
