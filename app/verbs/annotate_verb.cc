// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "app/verbs/annotate_agree.h"
#include "app/verbs/annotate_images.h"
#include "app/verbs/annotate_queue.h"
#include "app/verbs/annotate_register.h"
#include "app/verbs/annotation_inputs.h"
#include "app/verbs/room_export.h"
#include "app/verbs/verb.h"
#include "engine/annotation/annotation_check.h"
#include "engine/annotation/annotation_project.h"
#include "engine/annotation/bop_files.h"
#include "engine/annotation/crop_cut.h"
#include "engine/annotation/crop_models.h"
#include "engine/annotation/reopening.h"
#include "engine/annotation/scaled_models.h"
#include "engine/annotation/staged_export.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/models/mesh_file.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/session/run_drafts.h"

namespace plumbline {
namespace {

struct AnnotateArguments {
  std::string project, edits, format, path, frame = "scan", frames, up = "y", annotator, json;
  bool create = false;
  AnnotationCheckOptions check;
  ImageArguments images;
  RefineArguments refine;
  RegisterArguments registration;
  SecondArguments second;
};

/// Cuts crops out of the scan that the edits before them name.
class Cutter {
 public:
  explicit Cutter(const AnnotationProject& project) : project_(project) {}

  /// The edit with all that a crop brings: itself, its model's instance. Other edits stay.
  Result<Edit> Prepare(const Edit& edit, const AnnotationDocument& document,
                       const std::string& annotator) {
    const auto* add = std::get_if<AddCrop>(&edit);
    if (!add) return edit;
    if (document.scan.empty()) {
      return Error{ErrorCode::kInvalidInput, "there is no scan to cut '" + add->crop.id +
                                                 "' out of; name one with an edit 'inputs'"};
    }
    const std::filesystem::path file = project_.Resolve(document.scan);
    if (file != scan_file_) {
      Result<TriangleMesh> scan = ReadMesh(file);
      if (!scan) return scan.error();
      scan_ = std::move(*scan);
      scan_file_ = file;
    }
    Crop crop = add->crop;
    if (crop.annotator.empty()) crop.annotator = annotator;
    const std::filesystem::path folder = project_.Resolve(document.models);
    auto prepared = PrepareCrop(scan_, file, std::move(crop), document, folder);
    if (!prepared) return prepared.error();
    if (prepared->model) models_.emplace_back(std::move(prepared->model->built), folder);
    return Edit(std::move(prepared->edit));
  }

  /// Puts the models where the edit will find them.
  Status Stage() const {
    for (const auto& [model, folder] : models_) {
      if (const Status staged = StageCropModel(model, folder); !staged.ok()) return staged;
      std::printf("%s: %zu faces, %.2f x %.2f x %.2f m\n", model.model.name.c_str(),
                  model.model.mesh.triangles.size(), model.model.bounds.sizes().x(),
                  model.model.bounds.sizes().y(), model.model.bounds.sizes().z());
    }
    return {};
  }

 private:
  const AnnotationProject& project_;
  std::filesystem::path scan_file_;
  TriangleMesh scan_;
  std::vector<std::pair<BuiltModel, std::filesystem::path>> models_;
};

Status ApplyEdits(const AnnotateArguments& arguments) {
  const Result<nlohmann::json> edits = ReadJson(arguments.edits);
  if (!edits) return edits.error();
  if (!edits->is_array()) {
    return Error{ErrorCode::kInvalidInput, "'" + arguments.edits + "' must be a list of edits"};
  }
  const auto project =
      OpenProject(arguments.project, AnnotationProject::Access::kWrite, arguments.create);
  if (!project) return project.error();
  // All or nothing, and one step to undo: a script that fails half-way can be mended and run again.
  EditGroup group{"Apply " + arguments.edits, {}};
  AnnotationDocument trial = (*project)->document();
  Cutter cutter(**project);
  for (std::size_t i = 0; i < edits->size(); ++i) {
    Result<Edit> edit = EditFromJson((*edits)[i]);
    if (edit.ok()) edit = cutter.Prepare(*edit, trial, arguments.annotator);
    const Result<Edit> tried = edit.ok() ? ApplyEdit(*edit, trial) : Result<Edit>(edit.error());
    if (!tried) {
      return Error{tried.error().code, "'" + arguments.edits + "', edit " + std::to_string(i + 1) +
                                           ": " + tried.error().message + "; nothing was changed"};
    }
    if (auto* add = std::get_if<AddInstance>(&*edit); add && add->instance.annotator.empty()) {
      add->instance.annotator = arguments.annotator;
    }
    group.edits.push_back(std::move(*edit));
  }
  if (const Status staged = cutter.Stage(); !staged.ok()) return staged;
  const Edit edit = WithReopening(group, (*project)->document(), arguments.annotator);
  if (const Status applied = (*project)->Apply(edit); !applied.ok()) return applied;
  if (const auto synced = SyncCropModels(**project); !synced) return synced.error();
  return SaveAndSay(**project, "edits applied", edits->size());
}

// Reading.

Result<ImportedPoses> ReadDrafts(const AnnotationDocument& document, const std::string& run) {
  auto drafts = DraftsOfRun(document, run);
  if (!drafts) return drafts.error();
  ImportedPoses imported;
  imported.instances = std::move(*drafts);
  return imported;
}

Result<ImportedPoses> ReadPoses(const AnnotationProject& project, const ExchangeInputs& inputs,
                                const AnnotateArguments& arguments) {
  if (arguments.format == "run") return ReadDrafts(project.document(), arguments.path);
  if (arguments.format == "visma") return ReadVisma(arguments.path);
  if (arguments.format == "bop") return ReadBop(arguments.path);
  if (arguments.format == "labelfusion") {
    return ReadLabelFusion(project.document(), inputs, arguments.path);
  }
  if (arguments.format == "poses") {
    return ReadFramePoses(project.document(), inputs, arguments.path);
  }
  return ReadGroundTruthPoses(arguments.path);
}

Status Import(const AnnotateArguments& arguments) {
  const auto project =
      OpenProject(arguments.project, AnnotationProject::Access::kWrite, arguments.create);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  Result<ImportedPoses> read = ReadPoses(**project, inputs->View({}), arguments);
  if (!read) return read.error();
  Warn(read->warnings);
  if (inputs->models) TakeScalesFromNames(*inputs->models, read->instances);
  EditGroup group{"Import " + arguments.path, {}};
  if (read->gravity_in_scan && (*project)->document().instances.empty()) {
    group.edits.push_back(SetGravity{*read->gravity_in_scan, std::nullopt});
  }
  if (read->scan_from_world) group.edits.push_back(SetSceneAlignment{read->scan_from_world});
  for (AnnotatedInstance& instance : read->instances) {
    if (instance.annotator.empty()) instance.annotator = arguments.annotator;
    const auto model = inputs->models ? inputs->models->Find(instance.model) : std::nullopt;
    if (instance.category.empty() && model) {
      instance.category = inputs->models->model(*model).category;
    }
    group.edits.push_back(AddInstance{std::move(instance), std::nullopt});
  }
  const std::size_t count = read->instances.size();
  const Edit edit = WithReopening(group, (*project)->document(), arguments.annotator);
  if (const Status applied = (*project)->Apply(edit); !applied.ok()) return applied;
  return SaveAndSay(**project, "instances read", count);
}

// Writing.

/// Findings that somebody called all right, to be said where findings are counted.
std::string AndAccepted(std::size_t count) {
  return count == 0 ? "" : ", " + std::to_string(count) + " accepted findings";
}

Status Export(const AnnotateArguments& arguments) {
  const auto project = OpenProject(arguments.project, AnnotationProject::Access::kRead);
  if (!project) return project.error();
  const auto opened = OpenInputs(**project);
  if (!opened) return opened.error();
  const Result<FrameRange> range =
      arguments.frames.empty() ? FrameRange{} : ParseFrameRange(arguments.frames);
  if (!range) return range.error();
  const ExchangeInputs inputs = opened->View(ChosenFrames(opened->sequence.get(), *range));
  const AnnotationDocument& document = (*project)->document();
  std::size_t num_accepted = 0;
  for (const AnnotationFinding& finding : CheckAnnotations(document, inputs)) {
    if (!finding.IsError()) continue;
    if (FindAcceptance(finding, document) != nullptr)
      ++num_accepted;
    else
      log::warn("{} ('plumbline annotate check')", finding.sentence);
  }
  ExportRequest request{arguments.format, arguments.path, FrameOf(arguments.frame)};
  request.up = UpFrom(arguments.up);
  if (!arguments.second.file.empty()) {
    if (arguments.format != "ground_truth") {
      return Error{ErrorCode::kInvalidInput, "--second goes with --format ground_truth: '" +
                                                 arguments.format +
                                                 "' cannot say how well a pose is known"};
    }
    const auto agreement = CompareWithSecond(**project, opened->models.get(), arguments.second);
    if (!agreement) return agreement.error();
    request.deviations = DeviationsOf(**project, *agreement);
  }
  return WriteAndSay(document, inputs, (*project)->Resolve(document.scan), request,
                     AndAccepted(num_accepted));
}

nlohmann::json FindingsToJson(const std::vector<AnnotationFinding>& findings,
                              const AnnotationDocument& document) {
  nlohmann::json json = nlohmann::json::array();
  for (const AnnotationFinding& finding : findings) {
    json.push_back({{"kind", finding.kind},
                    {"instances", finding.instances},
                    {"amount", finding.amount},
                    {"unit", finding.unit},
                    {"sentence", finding.sentence}});
    if (const AcceptedFinding* accepted = FindAcceptance(finding, document)) {
      json.back()["accepted"] = {{"by", accepted->by}, {"note", accepted->note}};
    }
  }
  return json;
}

void PrintFinding(const AnnotationFinding& finding, const AnnotationDocument& document) {
  std::string accepted;
  if (const AcceptedFinding* known = FindAcceptance(finding, document)) {
    accepted = " (accepted";
    if (!known->by.empty()) accepted += " by " + known->by;
    if (!known->note.empty()) accepted += ": " + known->note;
    accepted += ")";
  }
  std::printf("%-16s %s%s\n", finding.kind.c_str(), finding.sentence.c_str(), accepted.c_str());
}

Status Check(const AnnotateArguments& arguments) {
  const auto project = OpenProject(arguments.project, AnnotationProject::Access::kRead);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  const AnnotationDocument& document = (*project)->document();
  ExchangeInputs view = inputs->View({});
  TriangleMesh scan;
  if (!document.crops.empty() && !document.scan.empty()) {
    Result<TriangleMesh> read = ReadMesh((*project)->Resolve(document.scan));
    if (!read) return read.error();
    scan = std::move(*read);
    view.scan = &scan;
  }
  auto findings = CheckAnnotations(document, view, arguments.check);
  const bool quiet = arguments.json == "-";
  for (const AnnotationFinding& finding : findings) {
    if (!quiet) PrintFinding(finding, document);
  }
  nlohmann::json agreement = nlohmann::json::array();
  if (inputs->sequence && inputs->models && arguments.images.frames > 0) {
    auto checked = CheckByImages(**project, *inputs, arguments.images, quiet);
    if (!checked) return checked.error();
    agreement = std::move(*checked);
    for (const nlohmann::json& row : agreement) {
      if (row.contains("problem")) continue;
      const auto low = CheckAgreement(row["id"], row["agreement"], row["images"], arguments.check);
      if (!low) continue;
      if (!quiet) PrintFinding(*low, document);
      findings.push_back(*low);
    }
  }
  if (!quiet) {
    const auto num_accepted = static_cast<std::size_t>(
        std::count_if(findings.begin(), findings.end(), [&](const AnnotationFinding& finding) {
          return FindAcceptance(finding, document) != nullptr;
        }));
    std::printf("%s: %zu instances, %zu findings%s\n", arguments.project.c_str(),
                document.instances.size(), findings.size() - num_accepted,
                AndAccepted(num_accepted).c_str());
  }
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json,
                         {{"findings", FindingsToJson(findings, document)}, {"images", agreement}});
}

Status AgreeWithSecond(const AnnotateArguments& arguments) {
  return Agree(arguments.project, arguments.second, arguments.json);
}

Status Queue(const AnnotateArguments& arguments) {
  return ShowQueue(arguments.project, arguments.json);
}

Status Refine(const AnnotateArguments& arguments) {
  return RefineInstances(arguments.project, arguments.images, arguments.refine, arguments.json);
}

Status Register(const AnnotateArguments& arguments) {
  return RegisterSequence(arguments.project, arguments.registration, arguments.json);
}

using ArgumentsPointer = std::shared_ptr<AnnotateArguments>;

CLI::App* AddCommand(CLI::App& parent, const char* name, const char* what,
                     const ArgumentsPointer& arguments, VerbFunction& chosen,
                     Status (*run)(const AnnotateArguments&)) {
  CLI::App* command = parent.add_subcommand(name, what);
  command->add_option("project", arguments->project, "The annotation project")
      ->required()
      ->type_name("PROJECT.json");
  command->callback(
      [arguments, &chosen, run] { chosen = [arguments, run] { return run(*arguments); }; });
  return command;
}

constexpr const char* kInstanceFormats =
    "ground_truth (our ground_truth.json), visma (a folder of VISMA's, or its fragments), bop (a "
    "dataset folder), labelfusion (registration_result.yaml, or its folder), poses (per-frame "
    "poses, JSON)";

void AddFormat(CLI::App& command, const ArgumentsPointer& arguments, const std::string& what,
               std::vector<std::string> names) {
  command.add_option("--format", arguments->format, what)->required()->check(CLI::IsMember(names));
}

void AddPath(CLI::App& command, const ArgumentsPointer& arguments, const char* option,
             const char* what) {
  command.add_option(option, arguments->path, what)->required()->type_name("PATH");
}

void AddCreation(CLI::App& command, const ArgumentsPointer& arguments) {
  command.add_flag("--create", arguments->create, "Create the project if it does not exist");
  command.add_option("--annotator", arguments->annotator, "Annotator named in new instances")
      ->type_name("NAME");
}

void AddJson(CLI::App& command, const ArgumentsPointer& arguments) {
  command
      .add_option("--json", arguments->json, "Write the results as JSON (- for standard output)")
      ->type_name("FILE");
}

}  // namespace

void AddAnnotateVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* verb = app.add_subcommand(
      "annotate", "Change, convert and check annotation projects without the window");
  verb->require_subcommand(1);
  auto arguments = std::make_shared<AnnotateArguments>();
  CLI::App* apply = AddCommand(
      *verb, "apply", "Apply a list of edits (docs/annotation.md) and save; all of them or none",
      arguments, chosen, ApplyEdits);
  apply->add_option("edits", arguments->edits, "A JSON list of edits")
      ->required()
      ->type_name("EDITS.json");
  AddCreation(*apply, arguments);

  CLI::App* import =
      AddCommand(*verb, "import", "Import instances from another format, as one edit", arguments,
                 chosen, Import);
  AddFormat(*import, arguments,
            std::string(kInstanceFormats) +
                ", run (RUN.plb or the JSON of a run: its confirmed objects as coarse drafts)",
            {"ground_truth", "visma", "bop", "labelfusion", "poses", "run"});
  AddPath(*import, arguments, "--from", "The file or folder to read");
  AddCreation(*import, arguments);

  CLI::App* write = AddCommand(*verb, "export", "Write the instances in another format", arguments,
                               chosen, Export);
  AddFormat(*write, arguments, RoomFormatsHelp(ExportedFrom::kAnnotation),
            RoomFormats(ExportedFrom::kAnnotation));
  AddPath(*write, arguments, "--out", "The file or folder to write");
  write
      ->add_option("--frame", arguments->frame,
                   "The scan's own frame, the scan turned z-up with the floor at 0, or "
                   "(ground_truth) the sequence's world; labelfusion, poses and coco are in "
                   "cameras, scan2cad "
                   "is level")
      ->check(CLI::IsMember({"scan", "level", "world"}))
      ->capture_default_str();
  write
      ->add_option("--frames", arguments->frames,
                   "Of bop, coco and poses: which frames of the sequence (B excluded)")
      ->type_name("A:B[:S]");
  write->add_option("--up", arguments->up, "Of gltf: the file's axis that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  write
      ->add_option("--second", arguments->second.file,
                   "Of ground_truth: what another annotator placed in the same scan (a project or "
                   "a ground truth); how well the poses are known by that is written beside them")
      ->type_name("SECOND.json");
  AddSecondOptions(*write, arguments->second);

  CLI::App* check = AddCommand(*verb, "check",
                               "Report tilted, floating, sunk, interpenetrating and duplicate "
                               "objects, drafts on top of others, unknown models and missing "
                               "frames, and how well the outlines lie on the edges of the images",
                               arguments, chosen, Check);
  check->add_option("--tilt", arguments->check.tilt_deg, "Largest tilt [degrees]")
      ->capture_default_str();
  check
      ->add_option("--floor-gap", arguments->check.floor_gap_m,
                   "Largest distance from the floor [m]")
      ->capture_default_str();
  check->add_option("--overlap", arguments->check.overlap_m, "Deepest overlap [m]")
      ->capture_default_str();
  check
      ->add_option("--agreement", arguments->check.agreement,
                   "Least agreement with the images, 0 to 1")
      ->capture_default_str();
  AddImageOptions(*check, arguments->images, "0: do not look at the images");
  AddJson(*check, arguments);

  CLI::App* refine = AddCommand(*verb, "refine",
                                "Align objects with the scan and with the edges in the sequence's "
                                "images together, upright, and save; one step to undo",
                                arguments, chosen, Refine);
  AddImageOptions(*refine, arguments->images, "at least 1");
  AddRefineOptions(*refine, arguments->refine);
  AddJson(*refine, arguments);

  CLI::App* registration = AddCommand(*verb, "register",
                                      "Register a sequence to a scan: a "
                                      "turn about gravity and a shift; one step to undo",
                                      arguments, chosen, Register);
  AddRegisterOptions(*registration, arguments->registration);
  AddJson(*registration, arguments);

  CLI::App* agree = AddCommand(*verb, "agree",
                               "Compare what two annotators placed in the same scan, object by "
                               "object; how well one annotator's poses are known",
                               arguments, chosen, AgreeWithSecond);
  agree
      ->add_option("second", arguments->second.file,
                   "The other one's project, or a ground truth of the scan")
      ->required()
      ->type_name("SECOND.json");
  AddSecondOptions(*agree, arguments->second);
  AddJson(*agree, arguments);

  CLI::App* queue = verb->add_subcommand(
      "queue", "List the scans and projects of a folder: how far each is, who, how long");
  queue->add_option("folder", arguments->project, "Its subfolders count, too")
      ->required()
      ->type_name("FOLDER");
  queue->callback([arguments, &chosen] { chosen = [arguments] { return Queue(*arguments); }; });
  AddJson(*queue, arguments);
}

}  // namespace plumbline
