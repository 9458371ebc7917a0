// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "app/verbs/argument_checks.h"
#include "app/verbs/evaluate_plant.h"
#include "app/verbs/evaluate_runs.h"
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
  std::string plant;  ///< Folder for forks in which what was missed is planted; empty: none.
  EvaluationOptions options;
  std::optional<SequenceAlignment> by_trajectory;
};

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

template <typename E>
E ValueOf(const std::string& name) {
  std::size_t i = 0;
  while (EnumNames<E>::names[i] != name) ++i;
  return static_cast<E>(i);
}

std::string Number(const char* format, std::optional<double> value) {
  if (!value) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), format, *value);
  return text;
}

void PrintSurface(const char* name, const ErrorStatistics& s, const char* paper) {
  if (s.samples == 0) {
    std::printf("%-22s %8s\n", name, "-");
    return;
  }
  std::printf("%-22s %8.2f %8.2f %8.2f %8.2f   %s\n", name, 100 * s.mean_m, 100 * s.median_m,
              100 * s.std_m, 100 * s.max_m, paper);
}

/// Of what a scale was estimated or is true: in per cent more than the model.
std::string SizeInWords(const MatchedObject& object) {
  if (!object.estimate.scale_std && object.truth.scale == 1) return "";
  std::string text = "  size " + Number("%+.1f", 100 * (object.estimate.scale - 1));
  if (object.estimate.scale_std) text += Number(" +- %.1f", 100 * *object.estimate.scale_std);
  return text + Number(" %% (true %+.1f %%)", 100 * (object.truth.scale - 1));
}

/// How well the truth itself is known, where its file says so.
std::string TruthInWords(const GroundTruthInstance& truth) {
  if (!truth.position_std_m && !truth.azimuth_std_rad) return "";
  std::string text = "  truth +-";
  if (truth.position_std_m) text += Number("%.1f cm", 100 * *truth.position_std_m);
  if (truth.azimuth_std_rad)
    text += (truth.position_std_m ? " " : "") + Number("%.1f deg", Degrees(*truth.azimuth_std_rad));
  return text;
}

using PlantedTruths = std::map<std::string, PlantedTruth>;

/// @param truths  Why instances are missed; null: not known.
void PrintObjects(const MapEvaluation& evaluation, const TruthsView* truths,
                  const PlantedTruths& planted) {
  std::printf("%-6s %-18s %-18s %7s %7s %8s %8s %6s %7s %8s\n", "object", "model", "ground truth",
              "trans.", "centre", "rotation", "azimuth", "tilt", "height", "surface");
  std::printf("%-6s %-18s %-18s %7s %7s %8s %8s %6s %7s %8s\n", "", "", "", "cm", "cm", "deg",
              "deg", "deg", "cm", "mean cm");
  for (const MatchedObject& object : evaluation.matched) {
    const PoseError& pose = object.pose;
    const std::optional<double> azimuth =
        pose.azimuth_rad ? std::optional(Degrees(*pose.azimuth_rad)) : std::nullopt;
    std::printf("%-6s %-18s %-18s %7.1f %7.1f %8.2f %8s %6.2f %+7.1f %8.2f%s%s%s%s\n",
                object.estimate.id.c_str(), object.estimate.model.c_str(), object.truth.id.c_str(),
                100 * pose.translation_m, 100 * object.centre_m, Degrees(pose.rotation_rad),
                Number("%+.2f", azimuth).c_str(), Degrees(pose.tilt_rad), 100 * pose.height_m,
                100 * object.surface.mean_m, object.truth.fine ? "" : "  coarse",
                object.model_correct ? "" : "  WRONG MODEL", SizeInWords(object).c_str(),
                TruthInWords(object.truth).c_str());
  }
  for (const SpuriousObject& object : evaluation.spurious) {
    std::printf("%-6s %-18s %-18s %59s\n", object.estimate.id.c_str(),
                object.estimate.model.c_str(), "SPURIOUS",
                Number("%.2f", 100 * object.surface.mean_m).c_str());
  }
  for (const GroundTruthInstance& instance : evaluation.missed) {
    std::printf("%-6s %-18s %-18s %s\n", "MISSED", instance.model.c_str(), instance.id.c_str(),
                instance.fine ? "" : "coarse");
    const TruthView* truth = truths != nullptr ? FindTruth(*truths, instance.id) : nullptr;
    if (truth != nullptr) std::printf("       %s\n", truth->text.c_str());
    const auto told = planted.find(instance.id);
    if (told != planted.end())
      std::printf("       Planted, to blame is %s: %s\n", BlameOf(told->second.fate),
                  told->second.text.c_str());
  }
}

void PrintTable(const MapEvaluation& evaluation, const TruthsView* truths,
                const PlantedTruths& planted, const EvaluateArguments& arguments) {
  PrintObjects(evaluation, truths, planted);
  std::printf("\nmatched %zu, missed %zu, spurious %zu; alignment %s, truth %s%s\n\n",
              evaluation.matched.size(), evaluation.missed.size(), evaluation.spurious.size(),
              arguments.align.c_str(), arguments.scene.empty() ? "models" : arguments.truth.c_str(),
              arguments.scene.empty() ? " (no --scene)" : "");
  if (arguments.by_trajectory) {
    const TrajectoryErrors& errors = arguments.by_trajectory->errors;
    std::printf(
        "own poses against the reference: %d frames, ATE %.1f cm, tilt %.2f deg, scale %.4f "
        "(by which they have to grow)\n\n",
        errors.matched, 100 * errors.ate_m, Degrees(errors.tilt_rad), errors.scale);
  }
  std::printf("%-22s %8s %8s %8s %8s   %s\n", "distances [cm]", "mean", "median", "std", "max",
              "the paper's mean");
  PrintSurface("surface", evaluation.surface, "1.39 - 2.79 VISMA, 0.3 - 6.3 SceneNN");
  PrintSurface("surface, to the plane", evaluation.surface_normal, "");
  PrintSurface("completeness", evaluation.completeness, "");
  const auto centimetres = [](std::optional<double> m) {
    return m ? std::optional(100 * *m) : std::nullopt;
  };
  const auto degrees = [](std::optional<double> rad) {
    return rad ? std::optional(Degrees(*rad)) : std::nullopt;
  };
  std::printf("\n%-22s %8s %8s   %s\n", "mean pose error", "fine", "all", "the paper");
  std::printf("%-22s %8s %8s   %s\n", "translation [cm]",
              Number("%.2f", centimetres(evaluation.mean.translation_m)).c_str(),
              Number("%.2f", centimetres(evaluation.mean_all.translation_m)).c_str(),
              "2.4 - 13.6 VISMA");
  std::printf("%-22s %8s %8s   %s\n", "rotation [deg]",
              Number("%.2f", degrees(evaluation.mean.rotation_rad)).c_str(),
              Number("%.2f", degrees(evaluation.mean_all.rotation_rad)).c_str(), "4.7 - 9.1 VISMA");
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

std::string Percent(double share, int of) {
  return of > 0 ? Number("%.1f", 100 * share / of) : "-";
}

void PrintReliability(const RunHistory& history, int truths) {
  const Reliability end = ReliabilityAtEnd(history).all;
  const RunReliability along = ReliabilityOf(history);
  std::printf("\n%-34s %10s %13s\n", "beliefs about confirmed objects", "at the end",
              "along the run");
  const auto print = [&](const char* name, const auto& of) {
    std::printf("%-34s %10s %13s\n", name, of(end).c_str(), of(along.all).c_str());
  };
  print("poses", [](const Reliability& of) { return std::to_string(of.poses); });
  print("truth in the 50 % region [%]",
        [](const Reliability& of) { return Percent(of.within_50, of.poses); });
  print("truth in the 95 % region [%]",
        [](const Reliability& of) { return Percent(of.within_95, of.poses); });
  print("NEES, 4 if honest",
        [](const Reliability& of) { return of.objects > 0 ? Number("%.1f", of.nees) : "-"; });
  print("  95 % of honest runs", [](const Reliability& of) {
    return of.objects > 0 ? Number("%.1f", of.nees_low) + " - " + Number("%.1f", of.nees_high)
                          : "-";
  });
  print("label right [%], of several models",
        [](const Reliability& of) { return Percent(of.labels.right, of.labels.count); });
  print("  believed at [%]",
        [](const Reliability& of) { return Percent(of.labels.claimed, of.labels.count); });
  print("  expected calibration error",
        [](const Reliability& of) { return Number("%.3f", of.labels.ExpectedError()); });
  std::printf("%-34s %10s\n", "average precision of being there",
              Number("%.2f", ConfirmationOf(history, truths).average_precision).c_str());
  if (along.objects.empty()) return;
  std::printf("\n%-24s %8s %8s %8s %8s\n", "along the run, by object", "poses", "50 %", "95 %",
              "NEES");
  for (const auto& [object, of] : along.objects) {
    std::printf("%-24d %8d %8s %8s %8.1f\n", object.value, of.poses,
                Percent(of.within_50, of.poses).c_str(), Percent(of.within_95, of.poses).c_str(),
                of.nees);
  }
}

/// The recipe of a run file, and whether there is one to ask.
Result<std::optional<RunHeader>> HeaderOfRun(const EvaluateArguments& arguments) {
  if (std::filesystem::path(arguments.run).extension() != ".plb") return std::optional<RunHeader>();
  const auto reader = RunReader::Open(arguments.run);
  if (!reader.ok()) return reader.error();
  return std::optional((*reader)->header());
}

/// How the poses of the run lie to those that its sequence was given, or to --reference.
Result<SequenceAlignment> AlignByTrajectory(const EvaluateArguments& arguments,
                                            const RunHeader& header) {
  const RunChoice choice{arguments.run, {}, arguments.models};
  const auto mapped = OpenSequenceOfRun(choice, header);
  if (!mapped.ok()) return mapped.error();
  const auto reference =
      OpenSequence(RecipeOf(choice, header).sequence, SequenceOptions{arguments.reference});
  if (!reference.ok()) return reference.error();
  if (Status status = CheckHasPoses(**reference, arguments.reference); !status.ok())
    return status.error();
  return AlignTrajectories(**mapped, **reference);
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
  Result<SequenceAlignment> alignment = AlignByTrajectory(arguments, **header);
  if (!alignment.ok() && wanted) return alignment.error();
  if (!alignment.ok()) return {};  // the objects are where the search begins
  arguments.options.truth_from_estimate = alignment->reference_from_mapped;
  arguments.by_trajectory = std::move(alignment).value();
  return {};
}

nlohmann::json TrajectoryToJson(const TrajectoryErrors& errors) {
  return {{"matched", errors.matched},
          {"ate_m", errors.ate_m},
          {"ate_deg", Degrees(errors.ate_rad)},
          {"tilt_deg", Degrees(errors.tilt_rad)},
          {"scale", errors.scale},
          {"path_m", errors.path_m}};
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

/// Judges estimates and, where `beliefs` has a history of them, what they were believed to be.
/// Prints the tables unless standard output is for JSON.
Result<nlohmann::json> Judge(const std::vector<EstimatedObject>& estimates, const Truth& truth,
                             const std::optional<RunReview>& beliefs, const PlantedTruths& planted,
                             const EvaluateArguments& arguments) {
  const Result<MapEvaluation> evaluation =
      EvaluateMap(estimates, truth.instances, *truth.database, truth.scan ? &*truth.scan : nullptr,
                  arguments.options);
  if (!evaluation) return evaluation.error();
  const int truths = beliefs ? static_cast<int>(beliefs->view.truth.size()) : 0;
  // The history that stands for a second pass has no way on which something could be missed.
  std::optional<TruthsView> known;
  if (beliefs && !beliefs->history.frames.empty() &&
      !beliefs->history.frames.front()->truths.empty())
    known = TruthsOf(*beliefs);
  if (arguments.json != "-") {
    PrintTable(*evaluation, known ? &*known : nullptr, planted, arguments);
    if (beliefs) PrintReliability(beliefs->history, truths);
  }
  nlohmann::json json = EvaluationToJson(*evaluation, arguments.options);
  if (arguments.by_trajectory)
    json["trajectory"] = TrajectoryToJson(arguments.by_trajectory->errors);
  for (nlohmann::json& missed : json["missed_instances"]) {
    const auto id = missed["ground_truth"].get<std::string>();
    const TruthView* told = known ? FindTruth(*known, id) : nullptr;
    if (told != nullptr) missed["why"] = WhyMissedToJson(*told);
    if (const auto at = planted.find(id); at != planted.end())
      missed["planted"] = PlantedToJson(at->second);
  }
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

Status Evaluate(EvaluateArguments arguments) {
  if (Status status = Align(arguments); !status.ok()) return status;
  arguments.options.align = ValueOf<Alignment>(arguments.align);
  arguments.options.truth = ValueOf<TruthSurface>(arguments.truth);
  const Result<std::vector<EstimatedObject>> estimates = ReadEstimates(arguments.run);
  if (!estimates) return estimates.error();
  const Result<Truth> truth = LoadTruth(arguments);
  if (!truth) return truth.error();
  const std::optional<RunReview> beliefs = BeliefsOf(arguments);
  PlantedTruths planted;
  if (!arguments.plant.empty()) {
    if (!beliefs) {
      return Error{ErrorCode::kInvalidInput,
                   "--plant maps a run file (.plb) again; '" + arguments.run +
                       "' cannot be, or is not in the frame of the ground truth"};
    }
    auto told = PlantMissed({arguments.run, {}, arguments.models}, arguments.ground_truth, *beliefs,
                            arguments.plant);
    if (!told) return told.error();
    planted = std::move(*told);
  }
  Result<nlohmann::json> json = Judge(*estimates, *truth, beliefs, planted, arguments);
  if (!json) return json.error();
  const auto smoothed = ReadSmoothedEstimates(arguments.run);
  if (!smoothed) return smoothed.error();
  if (*smoothed) {
    if (arguments.json != "-") std::printf("\n\nSMOOTHED: the second pass over all frames\n\n");
    const auto smoothed_beliefs = SmoothedBeliefs(beliefs, arguments);
    if (!smoothed_beliefs) return smoothed_beliefs.error();
    Result<nlohmann::json> beside = Judge(**smoothed, *truth, *smoothed_beliefs, {}, arguments);
    if (!beside) return beside.error();
    (*json)["smoothed"] = std::move(*beside);
  }
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, *json);
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
  if (arguments.ground_truth.empty()) throw CLI::RequiredError("--ground-truth");
  if (arguments.models.empty()) throw CLI::RequiredError("--models");
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
  verb->add_option("--ground-truth", arguments->ground_truth,
                   "Ground truth: objects and their poses")
      ->type_name("FILE");
  verb->add_option("--models", arguments->models,
                   "The model database of the run and of the ground truth")
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
  verb->add_option("--truth", arguments->truth,
                   "The true surface: the scan together with the posed true models, or one of them")
      ->check(CLI::IsMember({"both", "scan", "models"}))
      ->capture_default_str();
  verb->add_option("--ignore-category", arguments->options.ignored_categories,
                   "Leave objects and instances of this category out (may be given several times)")
      ->type_name("C")
      ->allow_extra_args(false);
  verb->add_option("--samples", arguments->options.samples, "Points drawn on each surface")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  verb->add_option("--seed", arguments->options.seed,
                   "Seed of the sampled points: the same seed gives the same figures")
      ->check(IsSeed())
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
