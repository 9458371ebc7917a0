// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "app/verbs/argument_checks.h"
#include "app/verbs/console_work.h"
#include "app/verbs/evaluate_plant.h"
#include "app/verbs/evaluate_runs.h"
#include "app/verbs/evaluate_tables.h"
#include "app/verbs/evaluate_trajectory.h"
#include "app/verbs/verb.h"
#include "engine/analysis/history.h"
#include "engine/analysis/missed_truths.h"
#include "engine/analysis/reliability.h"
#include "engine/analysis/run_review.h"
#include "engine/analysis/trajectory_alignment.h"
#include "engine/base/log.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/models/mesh_file.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/recording/landmark_history.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_inputs.h"
#include "engine/recording/run_summary.h"
#include "engine/recording/smoothed_record.h"
#include "engine/sources/folder_source.h"

namespace plumbline {
namespace {

struct EvaluateArguments {
  std::vector<std::string> runs;  ///< As they were named: several, or a folder, are compared.
  std::string run, ground_truth, models, scene, json;
  std::string trajectory, reference;  ///< Instead of a run.
  ///< Empty: "yaw" of a trajectory; of a map "trajectory" where it has own poses, else "none".
  std::string align, truth = "both";
  int single_frames = 20;
  std::string kitti;  ///< Category; empty: cars, where there are.
  std::string plant;  ///< Folder for forks in which what was missed is planted; empty: none.
  EvaluationOptions options;
  std::optional<TrajectoryFit> by_trajectory;
};

template <typename E>
E ValueOf(const std::string& name) {
  std::size_t i = 0;
  while (EnumNames<E>::names[i] != name) ++i;
  return static_cast<E>(i);
}

/// The run's beliefs frame by frame; nothing where the input is no run file, its frame is not that
/// of the truth, or the models are not those of the run.
std::optional<RunReview> BeliefsOf(const EvaluateArguments& arguments) {
  if (std::filesystem::path(arguments.run).extension() != ".plb" ||
      (arguments.align != "none" && arguments.align != "trajectory"))
    return std::nullopt;
  Result<RunReview> review =
      ReviewRun({arguments.run, {}, arguments.models}, arguments.ground_truth, WorkContext());
  if (!review) {
    log::warn("the beliefs of the run are not judged: {}", review.error().message);
    return std::nullopt;
  }
  LeaveOut(arguments.options.ignored_categories, *review);
  return std::move(review).value();
}

/// The recipe of a run file, and whether there is one to ask.
Result<std::optional<RunHeader>> HeaderOfRun(const EvaluateArguments& arguments) {
  if (std::filesystem::path(arguments.run).extension() != ".plb") return std::optional<RunHeader>();
  const auto reader = RunReader::Open(arguments.run);
  if (!reader.ok()) return reader.error();
  return std::optional((*reader)->header());
}

/// Fills in what was not named: the models of the run, and the ground truth of its sequence.
Status TakeFromRun(EvaluateArguments& arguments) {
  if (!arguments.ground_truth.empty() && !arguments.models.empty()) return {};
  const auto header = HeaderOfRun(arguments);
  if (!header.ok()) return header.error();
  if (!*header) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + arguments.run +
                     "' does not say where its models and its sequence are; name --models and "
                     "--ground-truth, or give the run file (.plb)"};
  }
  const RunChoice choice{arguments.run, {}, arguments.models};
  if (arguments.models.empty()) {
    const auto models = LoadModelsOfRun(choice, **header);
    if (!models.ok()) return models.error();
    arguments.models = (*models)->folder().string();
  }
  if (!arguments.ground_truth.empty()) return {};
  const auto sequence = OpenSequenceOfRun(choice, **header);
  if (!sequence.ok()) {
    return Error{sequence.error().code,
                 sequence.error().message + "; name the ground truth with --ground-truth"};
  }
  const auto file = (*sequence)->ground_truth_file();
  if (!file) {
    return Error{ErrorCode::kNotFound, "the sequence of '" + arguments.run + "' (" +
                                           (*sequence)->path().string() +
                                           ") has no ground truth; name one with --ground-truth"};
  }
  arguments.ground_truth = file->string();
  return {};
}

/// How the poses of the run lie to those that its sequence was given, or to --reference.
Result<TrajectoryFit> AlignByTrajectory(const EvaluateArguments& arguments,
                                        const RunHeader& header) {
  const RunChoice choice{arguments.run, {}, arguments.models};
  const auto mapped = OpenSequenceOfRun(choice, header);
  if (!mapped.ok()) return mapped.error();
  const auto reference =
      OpenSequence(RecipeOf(choice, header).sequence, SequenceOptions{arguments.reference});
  if (!reference.ok()) return reference.error();
  if (Status status = CheckHasPoses(**reference, arguments.reference); !status.ok())
    return status.error();
  if (OwnPosesOf(**mapped) == nullptr) return AlignTrajectories(**mapped, **reference);
  const auto reader = RunReader::Open(arguments.run);
  if (!reader.ok()) return reader.error();
  const auto landmarks = ReadLandmarks(**reader);
  if (!landmarks.ok()) return landmarks.error();
  const LandmarkLoops corrected =
      ReplayLandmarks(*mapped, header.recipe, (*mapped)->num_frames() - 1, *landmarks);
  return AlignTrajectories(**mapped, **reference, &corrected);
}

/// Decides about the alignment, and makes the trajectories' where it is asked for or a start.
Status Align(EvaluateArguments& arguments) {
  const auto header = HeaderOfRun(arguments);
  if (!header.ok()) return header.error();
  const bool own = *header && (*header)->recipe.poses.source == PoseSource::kVio;
  if (arguments.align.empty()) arguments.align = own ? "trajectory" : "none";
  const bool wanted = arguments.align == "trajectory";
  if (wanted && !*header) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + arguments.run + "' has no camera poses; give the run file (.plb)"};
  }
  if (!wanted && !(own && arguments.align != "none")) return {};
  Result<TrajectoryFit> alignment = AlignByTrajectory(arguments, **header);
  if (!alignment.ok() && wanted) return alignment.error();
  if (!alignment.ok()) return {};  // the objects are where the search begins
  arguments.options.truth_from_estimate = alignment->reference_from_mapped;
  arguments.by_trajectory = std::move(alignment).value();
  return {};
}

/// What estimates are compared with.
struct Truth {
  GroundTruth instances;
  std::shared_ptr<const ModelDatabase> database;
  std::optional<TriangleMesh> scan;
};

Result<Truth> LoadTruth(const EvaluateArguments& arguments) {
  Truth truth;
  Result<GroundTruth> instances = ReadGroundTruth(arguments.ground_truth);
  if (!instances) return instances.error();
  truth.instances = std::move(*instances);
  const auto database = ModelDatabase::Load(arguments.models);
  if (!database) return database.error();
  truth.database = *database;
  if (arguments.scene.empty()) return truth;
  Result<TriangleMesh> mesh = ReadMesh(arguments.scene);
  if (!mesh) return mesh.error();
  if (mesh->triangles.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 arguments.scene + " is a point cloud; distances need a mesh with triangles"};
  }
  truth.scan = std::move(*mesh);
  return truth;
}

/// What the map said in single images; nothing, with a warning, where that cannot be drawn.
std::optional<SingleFrames> JudgeSingleFrames(const RunReview& review, const Truth& truth,
                                              const EvaluateArguments& arguments) {
  if (arguments.single_frames == 0) return std::nullopt;
  ConsoleWork console;
  const auto judge = [&]() -> Result<SingleFrames> {
    const auto reader = RunReader::Open(arguments.run);
    if (!reader.ok()) return reader.error();
    const auto sequence = OpenSequenceOfRun({arguments.run, {}, arguments.models}, review.header);
    if (!sequence.ok()) return sequence.error();
    SingleFrameOptions options;
    options.frames = arguments.single_frames;
    return MeasureSingleFrames(review, **reader, **sequence, truth.scan ? &*truth.scan : nullptr,
                               options, console.context());
  };
  Result<SingleFrames> frames = judge();
  if (frames) return std::move(*frames);
  log::warn("single frames are not judged: {}", frames.error().message);
  return std::nullopt;
}

/// The category whose boxes are judged as KITTI does: the one asked for, or cars where there are.
Result<std::optional<std::string>> KittiCategory(const Truth& truth,
                                                 const EvaluateArguments& arguments) {
  const std::string wanted = arguments.kitti.empty() ? "car" : arguments.kitti;
  const auto& instances = truth.instances.instances;
  const bool there =
      std::any_of(instances.begin(), instances.end(),
                  [&](const GroundTruthInstance& instance) { return instance.category == wanted; });
  if (there) return std::optional(wanted);
  if (arguments.kitti.empty()) return std::optional<std::string>();
  return Error{ErrorCode::kInvalidInput, "--kitti " + wanted + ": " + arguments.ground_truth +
                                             " has no instance of that category; name one that "
                                             "it has, or leave --kitti out"};
}

/// The images of the run, in the frame of the truth; nothing where the input is no run file, or its
/// sequence or poses are not at hand.
std::optional<KittiViews> ViewsOf(const EvaluateArguments& arguments,
                                  const Eigen::Isometry3d& truth_from_estimate) {
  const auto header = HeaderOfRun(arguments);
  if (!header.ok() || !*header) return std::nullopt;
  const auto sequence = OpenSequenceOfRun({arguments.run, {}, arguments.models}, **header);
  if (!sequence.ok()) return std::nullopt;
  KittiViews views;
  views.camera = (*sequence)->camera();
  for (int frame = 0; frame < (*sequence)->num_frames(); ++frame) {
    if (const auto pose = (*sequence)->world_from_cam(frame))
      views.cam_from_world.push_back(pose->inverse() * truth_from_estimate.inverse());
  }
  return views.cam_from_world.empty() ? std::nullopt : std::optional(std::move(views));
}

/// Judges what a map holds against the truth.
Result<JudgedMap> Judge(const std::vector<EstimatedObject>& candidates, const Truth& truth,
                        const EvaluateArguments& arguments) {
  const std::vector<EstimatedObject> estimates = ConfirmedOf(candidates);
  const TriangleMesh* scan = truth.scan ? &*truth.scan : nullptr;
  Result<MapEvaluation> evaluation =
      EvaluateMap(estimates, truth.instances, *truth.database, scan, arguments.options);
  if (!evaluation) return evaluation.error();
  Result<SurfaceReferences> surfaces = CompareSurfaces(estimates, truth.instances, *truth.database,
                                                       scan, *evaluation, arguments.options);
  if (!surfaces) return surfaces.error();
  Result<BoxDetection> detection = MeasureDetection(candidates, truth.instances, *truth.database,
                                                    *evaluation, arguments.options);
  if (!detection) return detection.error();
  JudgedMap map;
  const auto category = KittiCategory(truth, arguments);
  if (!category) return category.error();
  if (*category) {
    Result<KittiMeasures> kitti =
        MeasureKitti(candidates, truth.instances, *truth.database, *evaluation, **category,
                     ViewsOf(arguments, evaluation->truth_from_estimate));
    if (!kitti) return kitti.error();
    map.kitti = std::move(*kitti);
  }
  map.options = arguments.options;
  map.has_scan = scan != nullptr;
  map.placement = MeasurePlacement(*evaluation, truth.instances, *truth.database);
  map.evaluation = std::move(*evaluation);
  map.surfaces = std::move(*surfaces);
  map.detection = std::move(*detection);
  map.by_trajectory = arguments.by_trajectory;
  return map;
}

/// Prints the tables unless standard output is for JSON.
nlohmann::json Tell(const JudgedMap& map, const std::optional<RunReview>& beliefs,
                    const EvaluateArguments& arguments) {
  const int truths = beliefs ? static_cast<int>(beliefs->view.truth.size()) : 0;
  if (arguments.json != "-") {
    PrintJudgedMap(map);
    if (beliefs) PrintReliability(beliefs->history, truths);
  }
  nlohmann::json json = JudgedMapToJson(map);
  if (beliefs) json["belief"] = BeliefToJson(beliefs->history, truths);
  return json;
}

/// The beliefs of the smoothed map as a history of one frame.
Result<std::optional<RunReview>> SmoothedBeliefs(const std::optional<RunReview>& beliefs,
                                                 const EvaluateArguments& arguments) {
  if (!beliefs) return std::optional<RunReview>();
  const auto map = ReadSmoothed(arguments.run);
  if (!map) return map.error();
  FrameReport frame;
  frame.frame = (*map)->last_frame;
  for (const SmoothedObject& object : (*map)->objects) frame.objects.push_back(object.belief);
  RunReview smoothed = *beliefs;
  smoothed.history.frames = {std::make_shared<const FrameSample>(SampleOf(frame, smoothed.view))};
  LeaveOut(arguments.options.ignored_categories, smoothed);
  return std::optional<RunReview>(std::move(smoothed));
}

/// The run mapped again with what it missed.
Result<PlantedTruths> Plant(const std::optional<RunReview>& beliefs,
                            const EvaluateArguments& arguments) {
  if (!beliefs) {
    return Error{ErrorCode::kInvalidInput,
                 "--plant maps a run file (.plb) again; '" + arguments.run +
                     "' cannot be, or is not in the frame of the ground truth"};
  }
  return PlantMissed({arguments.run, {}, arguments.models}, arguments.ground_truth, *beliefs,
                     arguments.plant);
}

Status Evaluate(EvaluateArguments arguments) {
  if (Status status = TakeFromRun(arguments); !status.ok()) return status;
  if (Status status = Align(arguments); !status.ok()) return status;
  arguments.options.align = ValueOf<Alignment>(arguments.align);
  arguments.options.truth = ValueOf<TruthSurface>(arguments.truth);
  const Result<std::vector<EstimatedObject>> candidates = ReadCandidates(arguments.run);
  if (!candidates) return candidates.error();
  const Result<Truth> truth = LoadTruth(arguments);
  if (!truth) return truth.error();
  const std::optional<RunReview> beliefs = BeliefsOf(arguments);
  Result<JudgedMap> map = Judge(*candidates, *truth, arguments);
  if (!map) return map.error();
  if (beliefs) {
    if (!beliefs->view.truth.empty() && !beliefs->history.frames.empty())
      map->truths = TruthsOf(*beliefs);
    map->single_frames = JudgeSingleFrames(*beliefs, *truth, arguments);
  }
  if (!arguments.plant.empty()) {
    auto planted = Plant(beliefs, arguments);
    if (!planted) return planted.error();
    map->planted = std::move(*planted);
  }
  nlohmann::json json = Tell(*map, beliefs, arguments);
  const auto smoothed = ReadSmoothedCandidates(arguments.run);
  if (!smoothed) return smoothed.error();
  if (*smoothed) {
    if (arguments.json != "-") std::printf("\n\nSMOOTHED: the second pass over all frames\n\n");
    const auto smoothed_beliefs = SmoothedBeliefs(beliefs, arguments);
    if (!smoothed_beliefs) return smoothed_beliefs.error();
    const Result<JudgedMap> beside = Judge(**smoothed, *truth, arguments);
    if (!beside) return beside.error();
    json["smoothed"] = Tell(*beside, *smoothed_beliefs, arguments);
  }
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, json);
}

/// What is asked for: a map or a trajectory. Throws CLI's errors of usage.
VerbFunction ChooseEvaluation(EvaluateArguments arguments) {
  const bool of_trajectory = !arguments.trajectory.empty();
  if (arguments.align.empty() && of_trajectory) arguments.align = "yaw";
  const auto check_align = [&](std::initializer_list<const char*> known) {
    if (arguments.align.empty()) return;
    if (std::find(known.begin(), known.end(), arguments.align) != known.end()) return;
    std::string names;
    for (const char* name : known) names += std::string(names.empty() ? "" : ", ") + name;
    throw CLI::ValidationError("--align", "'" + arguments.align + "' is not one of " + names);
  };
  if (of_trajectory) {
    if (arguments.reference.empty()) throw CLI::RequiredError("--reference");
    if (!arguments.runs.empty())
      throw CLI::ValidationError("--trajectory", "give either a run or a trajectory");
    if (!arguments.ground_truth.empty())
      throw CLI::ValidationError("--ground-truth", "a trajectory is compared with --reference");
    check_align({"none", "yaw", "se3", "sim3"});
    return [arguments] {
      return EvaluateTrajectory(
          {arguments.trajectory, arguments.reference, arguments.align, arguments.json});
    };
  }
  if (arguments.runs.empty()) throw CLI::RequiredError("a run, or --trajectory");
  if (arguments.runs.size() > 1 || std::filesystem::is_directory(arguments.runs.front())) {
    for (const auto& [name, value] :
         {std::pair("--align", &arguments.align), std::pair("--scene", &arguments.scene),
          std::pair("--plant", &arguments.plant)}) {
      if (!value->empty())
        throw CLI::ValidationError(name,
                                   "of several runs only what they missed is told; give one run");
    }
    return [arguments] {
      return EvaluateRuns({arguments.runs, arguments.ground_truth, arguments.models,
                           arguments.options.ignored_categories, arguments.json});
    };
  }
  arguments.run = arguments.runs.front();
  check_align({"none", "trajectory", "objects", "icp", "icp4"});
  return [arguments] { return Evaluate(arguments); };
}

}  // namespace

void AddEvaluateVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* verb = app.add_subcommand(
      "evaluate",
      "Evaluate the map of a run (surface error, pose errors, missed and spurious objects), or a "
      "trajectory; of several runs, or a folder of them, which found which object and why not");
  verb->add_option("run", arguments->runs,
                   "A run file, or the JSON that 'run --json' wrote; several run files or folders "
                   "of them: a table of what each found")
      ->type_name("RUN.plb|RUN.json|DIR");
  verb->add_option(
          "--ground-truth", arguments->ground_truth,
          "Ground truth: objects and their poses (default: that of the sequence of the run)")
      ->type_name("FILE");
  verb->add_option(
          "--models", arguments->models,
          "The model database of the run and of the ground truth (default: that of the run)")
      ->type_name("DIR");
  verb->add_option("--scene", arguments->scene,
                   "The scanned scene, a mesh in the frame of the ground truth")
      ->type_name("FILE.ply");
  verb->add_option(
          "--align", arguments->align,
          "Before measuring, bring the map into the frame of the ground truth: not at all "
          "(default), by a turn about gravity and a translation that bring the camera's "
          "trajectory onto that of the sequence or of --reference (default with --poses vio) or "
          "the matched objects onto the true ones, by ICP of the surfaces (rigid, as in the "
          "paper), or by ICP that keeps gravity. A trajectory: not at all, by a turn about z "
          "and a translation (default), by a rigid motion, or by a similarity")
      ->type_name("none|trajectory|objects|icp|icp4|yaw|se3|sim3");
  verb->add_option("--trajectory", arguments->trajectory,
                   "Judge this trajectory instead of a run (TUM; EST.covariance.csv beside it)")
      ->type_name("EST.txt");
  verb->add_option("--reference", arguments->reference,
                   "What a trajectory is compared with: TUM, or rows as groundtruth.csv, of the "
                   "same sensor, z up. Of a run, with --align trajectory: a TUM file of the camera "
                   "in the world of the ground truth (default: the sequence's own poses)")
      ->type_name("FILE");
  verb->add_option(
          "--truth", arguments->truth,
          "The surface of 'as --truth' and of --align icp: the scan together with the posed "
          "true models, which flatters (they are the map's own meshes), or one of them")
      ->check(CLI::IsMember({"both", "scan", "models"}))
      ->capture_default_str();
  verb->add_option("--ignore-category", arguments->options.ignored_categories,
                   "Leave objects and instances of this category out (may be given several times)")
      ->type_name("C")
      ->allow_extra_args(false);
  verb->add_option("--match-distance", arguments->options.match_distance_m,
                   "Largest distance of the origins of an object and the instance that it is; "
                   "half a metre suits rooms, a metre streets")
      ->check(CLI::Range(0.01, 100.0))
      ->type_name("M")
      ->capture_default_str();
  verb->add_option("--kitti", arguments->kitti,
                   "Judge boxes of this category as KITTI does, too (3-D and from above, average "
                   "precision and orientation); if not given, cars where there are any")
      ->type_name("C");
  verb->add_option("--samples", arguments->options.samples, "Points drawn on each surface")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  verb->add_option("--seed", arguments->options.seed,
                   "Seed of the sampled points: the same seed gives the same figures")
      ->check(IsSeed())
      ->capture_default_str();
  verb->add_option("--single-frames", arguments->single_frames,
                   "Of a run file, judge what the map said in so many of its images, as the BOP "
                   "benchmark does (VSD, MSSD, MSPD); 0: none")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("N")
      ->capture_default_str();
  verb->add_option("--plant", arguments->plant,
                   "Map the run again for each instance that it missed, with its true pose as a "
                   "candidate, and say whether the search, the likelihood or the evidence for "
                   "being there is to blame; the forks stay in this folder")
      ->type_name("DIR");
  verb->add_option("--json", arguments->json, "Write the results as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = ChooseEvaluation(*arguments); });
}

}  // namespace plumbline
