// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_checks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "engine/annotation/check_frames.h"
#include "engine/annotation/joint_refinement.h"
#include "engine/registration/scale_fit.h"

namespace plumbline {
namespace {

constexpr int kFrames = 9;  // Three of them are held out.
constexpr double kFarMove_m = 0.3, kFarTurn_rad = 0.6;

}  // namespace

bool InstanceImages::Suit(const AnnotationDocument& document,
                          const AnnotatedInstance& found) const {
  if (found.id != instance || found.model != model_name || found.scale != scale) return false;
  if (document.scan_from_world.has_value() != scan_from_world.has_value()) return false;
  if (scan_from_world && document.scan_from_world->matrix() != scan_from_world->matrix()) {
    return false;
  }
  const Eigen::Isometry3d moved = chosen_for.inverse() * found.scan_from_object;
  return moved.translation().norm() < kFarMove_m &&
         Eigen::AngleAxisd(moved.linear()).angle() < kFarTurn_rad;
}

InstanceImages InstanceImages::None(const AnnotationDocument& document,
                                    const std::string& instance) {
  InstanceImages none;
  none.instance = instance;
  none.scan_from_world = document.scan_from_world;
  if (const AnnotatedInstance* found = document.Find(instance)) {
    none.model_name = found->model;
    none.scale = found->scale;
    none.chosen_for = found->scan_from_object;
  }
  return none;
}

Result<InstanceImages> ReadInstanceImages(const std::shared_ptr<const Sequence>& sequence,
                                          const AnnotationDocument& document,
                                          const std::string& instance, OutlineScene& scene,
                                          const WorkContext& work) {
  const AnnotatedInstance* found = document.Find(instance);
  if (found == nullptr) return Error{ErrorCode::kNotFound, "there is no instance " + instance};
  const auto model = scene.Model(found->model, found->scale);
  if (!model) return model.error();
  InstanceImages images = InstanceImages::None(document, instance);
  images.model = *model;
  CheckFrameOptions options;
  options.frames = kFrames;
  options.max_candidates = 150;
  auto read = LoadCheckImages(sequence, document, **model, found->scan_from_object,
                              scene.OccludersOf(document, instance), options, "", work);
  if (!read) return read.error();
  images.apart = HoldOutEveryThird(*read);
  images.images = std::move(*read);
  if (images.apart.held_out != nullptr) {
    std::vector<AnnotationImage> ordered = images.apart.used->images();
    const auto& held_out = images.apart.held_out->images();
    ordered.insert(ordered.end(), held_out.begin(), held_out.end());
    images.images = AnnotationImages::FromImages(images.images->camera(), std::move(ordered));
  }
  return images;
}

namespace {

/// What can be seen of the contour, which is enough to compare.
OtherOutline OutlineOf(const ImageCheck& check, std::optional<RefineBy> by) {
  OtherOutline outline{by, {}};
  for (const OutlinePolyline& line : check.outline.lines) {
    if (!line.hidden && line.kind != OutlineKind::kCrease) outline.lines.push_back(line.pixels);
  }
  return outline;
}

void SetChange(const PoseChange& change, RefinedPose& pose) {
  pose.azimuth_rad = change.azimuth_rad;
  pose.horizontal_m = change.horizontal_m;
  pose.height_m = change.height_m;
  pose.tilt_rad = change.tilt_rad;
}

void SetDeviations(const PoseDeviations& deviations, RefinedPose& pose) {
  pose.height_std_m = deviations.height_m;
  pose.horizontal_std_m = deviations.horizontal_m;
  pose.azimuth_std_rad = deviations.azimuth_rad;
}

RefinedPose RefinedOf(RefineBy by, const JudgedPose& judged, const Eigen::Vector3d& up) {
  RefinedPose pose;
  pose.by = by;
  pose.scan_from_object = judged.estimate.scan_from_object;
  pose.converged = judged.converged;
  SetChange(judged.change, pose);
  SetDeviations(DeviationsOf(judged.estimate.covariance, up), pose);
  pose.fitness = judged.fitness;
  pose.rmse_m = judged.rmse_m;
  pose.agreement = judged.agreement;
  pose.offset_px = judged.offset_px;
  pose.agreement_held_out = judged.agreement_held_out;
  return pose;
}

}  // namespace

ImageChecksView CheckPose(const InstanceImages& images, const Eigen::Isometry3d& scan_from_object,
                          const std::vector<ComparedPose>& others, const Occluders& occluders) {
  ImageChecksView view;
  view.instance = images.instance;
  view.running = false;
  if (images.images == nullptr) {
    view.problem = "No frame of the sequence shows it well.";
    return view;
  }
  const auto checks = CheckImages(*images.images, *images.model, scan_from_object, occluders);
  std::vector<std::vector<ImageCheck>> compared;
  for (const ComparedPose& other : others) {
    compared.push_back(
        CheckImages(*images.images, *images.model, other.scan_from_object, occluders));
  }
  const std::size_t held_out =
      images.apart.held_out != nullptr ? images.apart.held_out->images().size() : 0;
  view.agreement = MeanAgreement(checks);
  for (std::size_t i = 0; i < checks.size(); ++i) {
    const AnnotationImage& source = images.images->images()[i];
    ImageCheckView check;
    check.frame = checks[i].frame;
    check.image = source.image;
    check.scan_from_cam = source.scan_from_cam;
    check.agreement = checks[i].agreement;
    check.median_offset_px = checks[i].median_offset_px;
    check.visible_px = checks[i].visible_px;
    check.held_out = i + held_out >= checks.size();
    for (const OutlinePolyline& line : checks[i].outline.lines) {
      check.lines.push_back({line.kind == OutlineKind::kCrease, line.hidden, line.pixels});
    }
    for (std::size_t k = 0; k < others.size(); ++k) {
      check.others.push_back(OutlineOf(compared[k][i], others[k].by));
    }
    view.images.push_back(std::move(check));
  }
  return view;
}

void ProposePose(const RefinedPose& pose, const PlacementTask* scan, RefinementView& refinement) {
  constexpr double kResidualReach_m = 0.1;
  static_cast<RefinedPose&>(refinement) = pose;
  if (scan == nullptr) return;
  refinement.residuals_m = std::make_shared<const std::vector<float>>(DistancesToScan(
      *scan->target, scan->mesh->vertices, pose.scan_from_object, kResidualReach_m));
}

namespace {

/// Where the foot was not scanned, a higher place and a smaller object look the same.
FreeMotion AtItsHeight(FreeMotion motion) {
  return motion == FreeMotion::kAzimuthAndTranslation ? FreeMotion::kAzimuthAndHorizontal : motion;
}

}  // namespace

void SolveScale(OutlineScene* outlines, const WorkContext& work, RefinementTask& task,
                RefinementView& refinement) {
  if (!task.free_scale || !task.scan || task.by == RefineBy::kImages) return;
  PlacementTask& scan = *task.scan;
  const auto fit = FitScale(*scan.target, *scan.unscaled, scan.scale, refinement.scan_from_object,
                            task.up_in_scan, AtItsHeight(task.motion), {}, work);
  if (!fit) {
    if (fit.error().code != ErrorCode::kCancelled) refinement.scale_problem = fit.error().message;
    return;
  }
  // To what is written: a ten-thousandth is less than a scan can tell.
  const double scale = std::round(1e4 * fit->scale) / 1e4;
  auto mesh =
      std::make_shared<const TriangleMesh>(Scaled(TriangleMesh(*scan.unscaled_mesh), scale));
  auto surface = ModelSurface::Prepare(*mesh);
  if (!surface) return;
  scan.surface = std::move(*surface);
  scan.mesh = std::move(mesh);
  scan.scale = refinement.scale = scale;
  refinement.scale_std = fit->scale_std;
  if (task.images == nullptr || task.images->images == nullptr || outlines == nullptr) return;
  auto outline = outlines->Model(task.images->model_name, scale);
  if (!outline) return;
  auto images = std::make_shared<InstanceImages>(*task.images);
  images->scale = scale;
  images->model = std::move(*outline);
  task.images = std::move(images);
}

void RefineInstance(const RefinementTask& task, const WorkContext& work, int pace_ms,
                    const std::function<void(const RefinementView&)>& step,
                    RefinementView& refinement) {
  const Eigen::Isometry3d start = refinement.scan_from_object;
  const PlacementTask* scan = task.scan && task.by != RefineBy::kImages ? &*task.scan : nullptr;
  RefinementEvidence evidence;
  if (scan != nullptr) {
    evidence.scan = scan->target.get();
    evidence.surface = scan->surface.get();
  }
  if (task.images != nullptr && task.images->images != nullptr && task.by != RefineBy::kScan) {
    evidence.images = task.images->apart.used.get();
    evidence.held_out = task.images->apart.held_out.get();
    evidence.outline = task.images->model.get();
    evidence.occluders = task.occluders;
  }
  refinement.has_scan = evidence.scan != nullptr;
  refinement.has_images = evidence.images != nullptr;
  const auto told = [&](const ModelRefinement& now) {
    RefinedPose pose;
    pose.by = RefineBy::kScan;
    pose.scan_from_object = now.scan_from_model;
    pose.fitness = now.fit.fitness;
    pose.rmse_m = now.fit.rmse_m;
    SetChange(ChangeBetween(start, now.scan_from_model, task.up_in_scan), pose);
    refinement.iteration = now.iterations;
    ProposePose(pose, scan, refinement);
    step(refinement);
    std::this_thread::sleep_for(std::chrono::milliseconds(pace_ms));
  };
  JointRefinementOptions options;
  options.motion = task.motion;
  options.images.camera_std_m = kUsualCameraStd_m;
  options.images.camera_turn_std_deg = kUsualCameraTurnStd_deg;
  const auto refined = RefineJointly(evidence, start, task.up_in_scan, options, told, work);
  if (!refined && refined.error().code == ErrorCode::kCancelled) return;
  refinement.running = false;
  if (!refined) {
    refinement.problem = refined.error().message;
    RefinedPose none;
    none.scan_from_object = start;
    return ProposePose(none, scan, refinement);
  }
  refinement.before = RefinedOf(RefineBy::kBoth, refined->before, task.up_in_scan);
  for (const RefineBy by : {RefineBy::kBoth, RefineBy::kScan, RefineBy::kImages}) {
    if (const JudgedPose* found = refined->Of(by)) {
      refinement.found.push_back(RefinedOf(by, *found, task.up_in_scan));
    }
  }
  if (evidence.scan != nullptr && !refined->by_scan) refinement.one_problem = refined->scan_problem;
  if (evidence.images != nullptr && !refined->by_images) {
    refinement.one_problem = refined->images_problem;
  }
  SetChange(refined->apart, refinement.apart);
  SetDeviations(refined->apart_expected, refinement.apart);
  refinement.contradict = refined->Contradict();
  ProposePose(RefinedOf(refined->best, *refined->Of(refined->best), task.up_in_scan), scan,
              refinement);
}

}  // namespace plumbline
