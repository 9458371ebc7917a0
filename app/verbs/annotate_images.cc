// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_images.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/annotation/check_frames.h"
#include "engine/annotation/joint_refinement.h"
#include "engine/annotation/outline_scene.h"
#include "engine/annotation/placement_images.h"
#include "engine/annotation/reopening.h"
#include "engine/base/log.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/angles.h"
#include "engine/models/mesh_file.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/registration/scale_fit.h"

namespace plumbline {
namespace {

/// What the outlines of a project are compared with.
class ProjectImages {
 public:
  ProjectImages(const AnnotationProject& project, const OpenedInputs& inputs,
                const ImageArguments& arguments, const FrameSelection& among)
      : document_(project.document()),
        inputs_(inputs),
        arguments_(arguments),
        among_(among),
        scene_(std::make_shared<OutlineScene>(inputs.models, LoadScan(project))) {}

  struct View {
    std::shared_ptr<const OutlineModel> model;
    Occluders occluders;
    std::shared_ptr<const AnnotationImages> images;  ///< Null if no frame shows the object.
  };

  Result<View> Of(const AnnotatedInstance& instance, const WorkContext& work) {
    const auto model = scene_->Model(instance.model, instance.scale);
    if (!model) return Error{model.error().code, instance.id + ": " + model.error().message};
    View view{*model, scene_->OccludersOf(document_, instance.id), nullptr};
    CheckFrameOptions options;
    options.frames = arguments_.frames;
    options.among = among_;
    auto images = LoadCheckImages(inputs_.sequence, document_, **model, instance.scan_from_object,
                                  view.occluders, options, arguments_.edges, work);
    if (!images) return images.error();
    if (*images != nullptr) Warn((*images)->warnings());
    view.images = std::move(*images);
    return view;
  }

  /// Where the images alone say that the object stands, of all azimuths; nothing where they do not
  /// say so clearly, or where it stands so already.
  std::optional<Eigen::Isometry3d> OfAllAzimuths(const AnnotatedInstance& instance,
                                                 FreeMotion motion, const WorkContext& work) {
    const PlacementQuestion question{inputs_.sequence, scene_,
                                     document_,        instance.model,
                                     instance.id,      -document_.gravity_in_scan.normalized(),
                                     motion,           instance.scale,
                                     among_,           arguments_.edges};
    const auto images = PlacementImages::Choose(question, instance.scan_from_object, work);
    if (!images) return std::nullopt;
    const double now = images->Agreement(instance.scan_from_object);
    const auto found = images->Search(instance.scan_from_object, work);
    if (!found || !Convinces(found->agreement, std::span(&now, 1))) return std::nullopt;
    return found->scan_from_object;
  }

 private:
  /// Null, with a warning, where the scan cannot hide anything.
  static std::shared_ptr<const OccludingScan> LoadScan(const AnnotationProject& project) {
    if (project.document().scan.empty()) return nullptr;
    auto mesh = ReadMesh(project.Resolve(project.document().scan));
    if (!mesh) {
      log::warn("{}; objects are taken for hidden only by one another", mesh.error().message);
      return nullptr;
    }
    auto scan = OccludingScan::Prepare(std::make_shared<TriangleMesh>(std::move(*mesh)));
    if (!scan) log::warn("{}: {}", project.document().scan, scan.error().message);
    return scan ? *scan : nullptr;
  }

  const AnnotationDocument& document_;
  const OpenedInputs& inputs_;
  const ImageArguments& arguments_;
  const FrameSelection among_;
  std::shared_ptr<OutlineScene> scene_;
};

/// Errors: kInvalidInput.
Result<FrameSelection> ParseAmong(const std::string& text) {
  if (text.empty()) return FrameSelection();
  const Result<FrameRange> range = ParseFrameRange(text);
  if (!range) return range.error();
  return FrameSelection{range->begin, range->end, range->step};
}

// Refining.

const char* NameOf(RefineBy by) {
  switch (by) {
    case RefineBy::kScan:
      return "scan";
    case RefineBy::kImages:
      return "images";
    case RefineBy::kBoth:
      break;
  }
  return "both";
}

double AzimuthSigma(const PoseCovariance& covariance, const Eigen::Vector3d& up) {
  return std::sqrt(up.dot(covariance.bottomRightCorner<3, 3>() * up));
}

nlohmann::json ToJson(const PoseChange& change) {
  return {{"azimuth_deg", kDegPerRad * change.azimuth_rad},
          {"horizontal_m", change.horizontal_m},
          {"height_m", change.height_m}};
}

/// Rows and columns of the covariance: x, y, z [m], azimuth [rad].
nlohmann::json ToJson(const JudgedPose& pose, const JudgedPose& before, const Eigen::Vector3d& up) {
  Eigen::Matrix<double, 4, 6> select = Eigen::Matrix<double, 4, 6>::Zero();
  select.topLeftCorner<3, 3>().setIdentity();
  select.bottomRightCorner<1, 3>() = up.transpose();
  const Eigen::Matrix4d covariance = select * pose.estimate.covariance * select.transpose();
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : covariance.rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  nlohmann::json json = ToJson(pose.change);
  json.update({{"result", pose.converged ? "converged" : "still moving"},
               {"agreement_before", before.agreement},
               {"agreement_after", pose.agreement},
               {"offset_before_px", before.offset_px},
               {"offset_after_px", pose.offset_px},
               {"fitness_before", before.fitness},
               {"fitness_after", pose.fitness},
               {"covariance", rows},
               {"scan_from_object", IsometryToJson(pose.estimate.scan_from_object)}});
  if (pose.agreement_held_out && before.agreement_held_out) {
    json["held_out_before"] = *before.agreement_held_out;
    json["held_out_after"] = *pose.agreement_held_out;
  }
  return json;
}

nlohmann::json ToJson(const std::string& id, const JointRefinement& refined, RefineBy taken,
                      std::size_t images, std::size_t held_out, const Eigen::Vector3d& up) {
  nlohmann::json json = ToJson(*refined.Of(taken), refined.before, up);
  json.update({{"id", id}, {"images", images}, {"held_out", held_out}, {"by", NameOf(taken)}});
  if (!refined.scan_problem.empty()) json["scan_problem"] = refined.scan_problem;
  if (!refined.images_problem.empty()) json["images_problem"] = refined.images_problem;
  if (!refined.together) return json;
  for (const RefineBy by : {RefineBy::kScan, RefineBy::kImages, RefineBy::kBoth}) {
    if (by != taken)
      json[std::string("by_") + NameOf(by)] = ToJson(*refined.Of(by), refined.before, up);
  }
  json["apart"] = ToJson(refined.apart);
  json["apart"].update({{"expected_azimuth_deg", kDegPerRad * refined.apart_expected.azimuth_rad},
                        {"expected_horizontal_m", refined.apart_expected.horizontal_m},
                        {"expected_height_m", refined.apart_expected.height_m},
                        {"conflict", refined.conflict},
                        {"contradict", refined.Contradict()}});
  return json;
}

void PrintHead() {
  std::printf("%-16s %-6s %9s %10s %8s  %13s  %13s  %13s  %-16s %s\n", "instance", "by", "azimuth",
              "horizontal", "height", "fits", "on edges", "other images", "sigma",
              "scan to images");
}

std::string Arrow(std::optional<double> before, std::optional<double> after) {
  if (!before || !after) return "-";
  char text[64];
  std::snprintf(text, sizeof(text), "%4.2f -> %4.2f", *before, *after);
  return text;
}

void PrintRow(const std::string& id, const JointRefinement& refined, RefineBy taken, bool scan,
              bool images, const Eigen::Vector3d& up) {
  const JudgedPose &pose = *refined.Of(taken), &before = refined.before;
  const auto given = [](bool there, double value) {
    return there ? std::optional<double>(value) : std::nullopt;
  };
  std::printf("%-16s %-6s %+5.2f deg %7.1f mm %+5.1f mm  %13s  %13s  %13s  %4.1f mm %.2f deg",
              id.c_str(), NameOf(taken), kDegPerRad * pose.change.azimuth_rad,
              1e3 * pose.change.horizontal_m, 1e3 * pose.change.height_m,
              Arrow(given(scan, before.fitness), given(scan, pose.fitness)).c_str(),
              Arrow(given(images, before.agreement), given(images, pose.agreement)).c_str(),
              Arrow(before.agreement_held_out, pose.agreement_held_out).c_str(),
              1e3 * std::sqrt(pose.estimate.covariance.topLeftCorner<3, 3>().trace()),
              kDegPerRad * AzimuthSigma(pose.estimate.covariance, up));
  if (refined.together) {
    std::printf("  %.1f mm %+.1f mm %+.2f deg%s", 1e3 * refined.apart.horizontal_m,
                1e3 * refined.apart.height_m, kDegPerRad * refined.apart.azimuth_rad,
                refined.Contradict() ? ": contradict each other" : "");
  }
  std::printf("\n");
}

/// Those asked for, or all that are not locked.
Result<std::vector<const AnnotatedInstance*>> Chosen(const AnnotationDocument& document,
                                                     const std::vector<std::string>& ids) {
  std::vector<const AnnotatedInstance*> chosen;
  for (const std::string& id : ids) {
    const AnnotatedInstance* instance = document.Find(id);
    if (!instance) return Error{ErrorCode::kNotFound, "there is no instance '" + id + "'"};
    if (instance->locked) {
      return Error{ErrorCode::kInvalidInput, "'" + id + "' is locked; unlock it to move it"};
    }
    chosen.push_back(instance);
  }
  if (!ids.empty()) return chosen;
  for (const AnnotatedInstance& instance : document.instances) {
    if (!instance.locked) chosen.push_back(&instance);
  }
  return chosen;
}

}  // namespace

Result<nlohmann::json> CheckByImages(const AnnotationProject& project, const OpenedInputs& inputs,
                                     const ImageArguments& arguments, bool quiet) {
  const auto among = ParseAmong(arguments.among);
  if (!among) return among.error();
  ConsoleWork work;
  ProjectImages views(project, inputs, arguments, *among);
  nlohmann::json json = nlohmann::json::array();
  if (!quiet) std::printf("%-16s %6s  %9s  %s\n", "instance", "images", "agreement", "offset [px]");
  for (const AnnotatedInstance& instance : project.document().instances) {
    const auto view = views.Of(instance, work.context());
    if (!view && view.error().code == ErrorCode::kCancelled) return view.error();
    if (!view || !view->images) {
      const std::string why = view ? "no image shows it" : view.error().message;
      if (!quiet) std::printf("%-16s %6d  %s\n", instance.id.c_str(), 0, why.c_str());
      json.push_back({{"id", instance.id}, {"images", 0}, {"problem", why}});
      continue;
    }
    const auto checks =
        CheckImages(*view->images, *view->model, instance.scan_from_object, view->occluders);
    nlohmann::json frames = nlohmann::json::array();
    std::vector<double> offsets;
    for (const ImageCheck& check : checks) {
      offsets.push_back(check.median_offset_px);
      frames.push_back({{"frame", check.frame},
                        {"agreement", check.agreement},
                        {"offset_px", check.median_offset_px}});
    }
    std::sort(offsets.begin(), offsets.end());
    const double agreement = MeanAgreement(checks), offset = offsets[offsets.size() / 2];
    if (!quiet) {
      std::printf("%-16s %6zu  %9.2f  %.1f\n", instance.id.c_str(), checks.size(), agreement,
                  offset);
    }
    json.push_back({{"id", instance.id},
                    {"images", checks.size()},
                    {"agreement", agreement},
                    {"offset_px", offset},
                    {"frames", frames}});
  }
  return json;
}

/// What `--by` asks for, of what was found; the best of it for both.
RefineBy TakenBy(const std::string& by, const JointRefinement& refined) {
  return by == "scan" ? RefineBy::kScan : by == "images" ? RefineBy::kImages : refined.best;
}

/// Of the part of the scan where it stands. Errors: those of FitScale, kNotFound.
Result<ScaleFit> SolveScale(const AnnotatedInstance& instance, const ModelDatabase& models,
                            const ScanTarget& target, const Eigen::Vector3d& up,
                            FreeMotion motion) {
  const auto id = models.Find(instance.model);
  if (!id) return Error{ErrorCode::kNotFound, "there is no model '" + instance.model + "'"};
  const auto surface = ModelSurface::Prepare(models.model(*id).mesh);
  if (!surface) return surface.error();
  // Where the foot was not scanned, a higher place and a smaller object look the same.
  if (motion == FreeMotion::kAzimuthAndTranslation) motion = FreeMotion::kAzimuthAndHorizontal;
  return FitScale(target, **surface, instance.scale, instance.scan_from_object, up, motion);
}

Status RefineInstances(const std::string& project_file, const ImageArguments& images,
                       const RefineArguments& arguments, const std::string& json_file) {
  const auto project = OpenProject(project_file, AnnotationProject::Access::kWrite);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  const AnnotationDocument& document = (*project)->document();
  const bool by_images = arguments.by != "scan" && inputs->sequence != nullptr;
  const bool by_scan = arguments.by != "images" && !document.scan.empty();
  if (!inputs->models || (!by_images && !by_scan)) {
    return Error{ErrorCode::kInvalidInput, "'" + project_file + "' names no " +
                                               (!inputs->models            ? "model database"
                                                : arguments.by == "images" ? "sequence"
                                                : arguments.by == "scan"   ? "scan"
                                                                         : "scan and no sequence") +
                                               "; add it with an edit 'inputs'"};
  }
  const auto chosen = Chosen(document, arguments.instances);
  if (!chosen) return chosen.error();
  const auto among = ParseAmong(images.among);
  if (!among) return among.error();
  if (arguments.all_azimuths && !by_images) {
    return Error{ErrorCode::kInvalidInput, "--all-azimuths asks the images, and '" + project_file +
                                               "' names no sequence or --by scan leaves them out"};
  }
  std::shared_ptr<const ScanTarget> target;
  if (by_scan) {
    auto mesh = ReadMesh((*project)->Resolve(document.scan));
    if (!mesh) return mesh.error();
    auto prepared = ScanTarget::Prepare(*mesh);
    if (!prepared) return prepared.error();
    target = std::move(*prepared);
  }
  JointRefinementOptions options{MotionWith(arguments.dof), arguments.options};
  options.images.camera_std_m = arguments.camera_std_cm / 100;
  // As usual, in proportion.
  options.images.camera_turn_std_deg =
      kUsualCameraTurnStd_deg * options.images.camera_std_m / kUsualCameraStd_m;
  const Eigen::Vector3d up = -document.gravity_in_scan.normalized();
  const bool quiet = json_file == "-";
  ConsoleWork work;
  ProjectImages views(**project, *inputs, images, *among);
  EditGroup group{"Refine", {}};
  nlohmann::json json = nlohmann::json::array();
  Status status;
  if (!quiet) PrintHead();
  const auto refine = [&](const AnnotatedInstance& placed) -> Result<nlohmann::json> {
    AnnotatedInstance instance = placed;
    bool turned = false;
    if (arguments.all_azimuths) {
      const auto found = views.OfAllAzimuths(instance, options.motion, work.context());
      turned = found.has_value();
      if (found) instance.scan_from_object = *found;
      if (found && !quiet) {
        std::printf("%-16s begins %+.1f deg turned, where the images prefer it\n",
                    instance.id.c_str(),
                    kDegPerRad * ChangeBetween(placed.scan_from_object, *found, up).azimuth_rad);
      }
    }
    std::optional<ScaleFit> scaled;
    if (instance.may_scale && target != nullptr) {
      const auto fit = SolveScale(instance, *inputs->models, *target, up, options.motion);
      if (!fit) return fit.error();
      scaled = *fit;
      instance.scale = std::round(1e4 * fit->scale) / 1e4;
    }
    RefinementEvidence evidence;
    ProjectImages::View view;
    HeldOutImages apart;
    if (by_images) {
      auto found = views.Of(instance, work.context());
      if (!found) return found.error();
      view = std::move(*found);
      apart = HoldOutEveryThird(view.images);
      evidence.images = apart.used.get();
      evidence.held_out = apart.held_out.get();
      evidence.outline = view.model.get();
      evidence.occluders = view.occluders;
    }
    std::shared_ptr<const ModelSurface> surface;
    if (target != nullptr) {
      const auto id = inputs->models->Find(instance.model);
      if (!id) return Error{ErrorCode::kNotFound, "there is no model '" + instance.model + "'"};
      auto prepared =
          ModelSurface::Prepare(Scaled(inputs->models->model(*id), instance.scale).mesh);
      if (!prepared) return prepared.error();
      surface = std::move(*prepared);
      evidence.scan = target.get();
      evidence.surface = surface.get();
    }
    if (by_images && apart.used == nullptr && !by_scan) {
      return Error{ErrorCode::kDegenerate, "no image shows it"};
    }
    const auto refined =
        RefineJointly(evidence, instance.scan_from_object, up, options, {}, work.context());
    if (!refined) return refined.error();
    const RefineBy taken = TakenBy(arguments.by, *refined);
    if (refined->Of(taken) == nullptr) {
      return Error{ErrorCode::kDegenerate,
                   arguments.by == "scan" ? refined->scan_problem : refined->images_problem};
    }
    if (!quiet) {
      PrintRow(instance.id, *refined, taken, target != nullptr, apart.used != nullptr, up);
    }
    ChangeInstance change;
    change.id = instance.id;
    change.set.scan_from_object = refined->Of(taken)->estimate.scan_from_object;
    if (scaled) change.set.scale = instance.scale;
    group.edits.push_back(change);
    const auto count = [](const auto& some) { return some ? some->images().size() : 0; };
    nlohmann::json row =
        ToJson(instance.id, *refined, taken, count(apart.used), count(apart.held_out), up);
    if (arguments.all_azimuths) row["turned_by_images"] = turned;
    if (scaled) {
      row["scale"] = instance.scale;
      row["scale_std"] = scaled->scale_std;
      if (!quiet) {
        std::printf("%-16s scale %.4f +- %.4f\n", instance.id.c_str(), instance.scale,
                    scaled->scale_std);
      }
    }
    return row;
  };
  for (const AnnotatedInstance* instance : *chosen) {
    const auto refined = refine(*instance);
    if (!refined && refined.error().code == ErrorCode::kCancelled) {
      status = refined.error();  // What is done is kept.
      break;
    }
    if (refined) {
      json.push_back(*refined);
      continue;
    }
    if (!quiet) std::printf("%-16s %s\n", instance->id.c_str(), refined.error().message.c_str());
    json.push_back({{"id", instance->id}, {"images", 0}, {"problem", refined.error().message}});
  }
  const std::size_t moved = group.edits.size();
  if (moved > 0) {
    const Edit edit = WithReopening(group, document, "");
    if (const Status applied = (*project)->Apply(edit); !applied.ok()) return applied;
    if (const Status saved = (*project)->Save(); !saved.ok()) return saved;
  }
  if (!quiet) std::printf("%s: %zu of %zu moved\n", project_file.c_str(), moved, chosen->size());
  if (!status.ok() || json_file.empty()) return status;
  return WriteJsonResult(json_file, json);
}

}  // namespace plumbline
