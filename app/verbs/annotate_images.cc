// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_images.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/annotation/check_frames.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/log.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/angles.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

/// What the outlines of a project are compared with.
class ProjectImages {
 public:
  ProjectImages(const AnnotationProject& project, const OpenedInputs& inputs,
                const ImageArguments& arguments)
      : document_(project.document()),
        inputs_(inputs),
        arguments_(arguments),
        scene_(inputs.models, LoadScan(project)) {}

  struct View {
    std::shared_ptr<const OutlineModel> model;
    Occluders occluders;
    std::shared_ptr<const AnnotationImages> images;  ///< Null if no frame shows the object.
  };

  Result<View> Of(const AnnotatedInstance& instance, const WorkContext& work) {
    const auto model = scene_.Model(instance.model);
    if (!model) return Error{model.error().code, instance.id + ": " + model.error().message};
    View view{*model, scene_.OccludersOf(document_, instance.id), nullptr};
    CheckFrameOptions options;
    options.frames = arguments_.frames;
    auto images = LoadCheckImages(inputs_.sequence, document_, **model, instance.scan_from_object,
                                  view.occluders, options, arguments_.edges, work);
    if (!images) return images.error();
    if (*images != nullptr) Warn((*images)->warnings());
    view.images = std::move(*images);
    return view;
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
  OutlineScene scene_;
};

// Refining.

const char* StopName(RefinementStop stop) {
  switch (stop) {
    case RefinementStop::kConverged:
      return "converged";
    case RefinementStop::kMoving:
      return "still moving";
    case RefinementStop::kNoBetter:
      return "no better place";
  }
  return "";
}

double AzimuthSigma(const ImageRefinement& refined, const Eigen::Vector3d& up) {
  return std::sqrt(up.dot(refined.covariance.bottomRightCorner<3, 3>() * up));
}

/// Rows and columns of the covariance: x, y, z [m], azimuth [rad].
nlohmann::json ToJson(const std::string& id, const ImageRefinement& refined,
                      const Eigen::Vector3d& up) {
  Eigen::Matrix<double, 4, 6> select = Eigen::Matrix<double, 4, 6>::Zero();
  select.topLeftCorner<3, 3>().setIdentity();
  select.bottomRightCorner<1, 3>() = up.transpose();
  const Eigen::Matrix4d covariance = select * refined.covariance * select.transpose();
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : covariance.rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return {{"id", id},
          {"images", refined.images},
          {"result", StopName(refined.stop)},
          {"azimuth_deg", kDegPerRad * refined.azimuth_rad},
          {"horizontal_m", refined.horizontal_m},
          {"height_m", refined.height_m},
          {"agreement_before", refined.agreement_before},
          {"agreement_after", refined.agreement_after},
          {"offset_before_px", refined.offset_before_px},
          {"offset_after_px", refined.offset_after_px},
          {"covariance", rows},
          {"scan_from_object", IsometryToJson(refined.scan_from_object)}};
}

void PrintHead() {
  std::printf("%-16s %6s  %9s %10s %8s  %13s  %13s  %s\n", "instance", "images", "azimuth",
              "horizontal", "height", "agreement", "offset [px]", "sigma");
}

void PrintRow(const std::string& id, const ImageRefinement& refined, const Eigen::Vector3d& up) {
  std::printf(
      "%-16s %6d  %+5.2f deg %7.1f mm %+5.1f mm  %4.2f -> %4.2f  %5.1f -> %4.1f  "
      "%.1f mm %.2f deg  %s\n",
      id.c_str(), refined.images, kDegPerRad * refined.azimuth_rad, 1e3 * refined.horizontal_m,
      1e3 * refined.height_m, refined.agreement_before, refined.agreement_after,
      refined.offset_before_px, refined.offset_after_px,
      1e3 * std::sqrt(refined.covariance.topLeftCorner<3, 3>().trace()),
      kDegPerRad * AzimuthSigma(refined, up), StopName(refined.stop));
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

void AddImageOptions(CLI::App& command, ImageArguments& arguments, const char* least_frames) {
  command
      .add_option("--frames", arguments.frames,
                  std::string("Key frames that each object is compared in, from as different sides "
                              "as there are; ") +
                      least_frames)
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      .add_option(
          "--edges", arguments.edges,
          "dataset (the sequence's), gradient or a network; the sequence's where it has any, "
          "else gradient")
      ->type_name("dataset|gradient|FILE.onnx");
}

void AddRefineOptions(CLI::App& command, RefineArguments& arguments) {
  command
      .add_option("--instance", arguments.instances,
                  "Only this one (may be given several times); else all that are not locked")
      ->type_name("ID");
  command
      .add_option("--max-shift", arguments.options.max_shift_m,
                  "How far it may move across and along gravity [m]")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  command.add_option("--max-turn", arguments.options.max_turn_deg, "How far it may turn [degrees]")
      ->check(CLI::Range(0.1, 90.0))
      ->capture_default_str();
  command
      .add_option("--dof", arguments.dof,
                  "What is free: 4 azimuth and translation, 3 azimuth and the two translations "
                  "along the floor, 1 azimuth alone")
      ->check(CLI::IsMember({4, 3, 1}))
      ->capture_default_str();
}

Result<nlohmann::json> CheckByImages(const AnnotationProject& project, const OpenedInputs& inputs,
                                     const ImageArguments& arguments, bool quiet) {
  ConsoleWork work;
  ProjectImages views(project, inputs, arguments);
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

Status RefineByImages(const std::string& project_file, const ImageArguments& images,
                      const RefineArguments& arguments, const std::string& json_file) {
  const auto project = OpenProject(project_file, AnnotationProject::Access::kWrite);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  if (!inputs->sequence || !inputs->models) {
    return Error{ErrorCode::kInvalidInput, "'" + project_file + "' names no " +
                                               (inputs->models ? "sequence" : "model database") +
                                               "; add it with an edit 'inputs'"};
  }
  const auto chosen = Chosen((*project)->document(), arguments.instances);
  if (!chosen) return chosen.error();
  ImageRefinementOptions options = arguments.options;
  options.motion = MotionWith(arguments.dof);
  const Eigen::Vector3d up = -(*project)->document().gravity_in_scan.normalized();
  const bool quiet = json_file == "-";
  ConsoleWork work;
  ProjectImages views(**project, *inputs, images);
  EditGroup group{"Refine by images", {}};
  nlohmann::json json = nlohmann::json::array();
  Status status;
  if (!quiet) PrintHead();
  for (const AnnotatedInstance* instance : *chosen) {
    const auto view = views.Of(*instance, work.context());
    const auto refined =
        !view          ? Result<ImageRefinement>(view.error())
        : view->images ? RefineByImages(*view->images, *view->model, instance->scan_from_object, up,
                                        view->occluders, options, work.context())
                       : Error{ErrorCode::kDegenerate, "no image shows it"};
    if (!refined && refined.error().code == ErrorCode::kCancelled) {
      status = refined.error();  // What is done is kept.
      break;
    }
    if (!refined) {
      if (!quiet) {
        std::printf("%-16s %6d  %s\n", instance->id.c_str(), 0, refined.error().message.c_str());
      }
      json.push_back({{"id", instance->id}, {"images", 0}, {"problem", refined.error().message}});
      continue;
    }
    if (!quiet) PrintRow(instance->id, *refined, up);
    json.push_back(ToJson(instance->id, *refined, up));
    if (refined->stop == RefinementStop::kNoBetter) continue;
    ChangeInstance change;
    change.id = instance->id;
    change.set.scan_from_object = refined->scan_from_object;
    group.edits.push_back(change);
  }
  const std::size_t moved = group.edits.size();
  if (moved > 0) {
    if (const Status applied = (*project)->Apply(group); !applied.ok()) return applied;
    if (const Status saved = (*project)->Save(); !saved.ok()) return saved;
  }
  if (!quiet) std::printf("%s: %zu of %zu moved\n", project_file.c_str(), moved, chosen->size());
  if (!status.ok() || json_file.empty()) return status;
  return WriteJsonResult(json_file, json);
}

}  // namespace plumbline
