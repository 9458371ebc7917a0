// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_checks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/annotation/check_frames.h"
#include "engine/session/annotation_jobs.h"

namespace plumbline {
namespace {

constexpr int kFrames = 6;
constexpr double kFarMove_m = 0.3, kFarTurn_rad = 0.6;

}  // namespace

bool InstanceImages::Suit(const AnnotationDocument& document,
                          const AnnotatedInstance& found) const {
  if (found.id != instance || found.model != model_name) return false;
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
  const auto model = scene.Model(found->model);
  if (!model) return model.error();
  InstanceImages images = InstanceImages::None(document, instance);
  images.model = *model;
  CheckFrameOptions options;
  options.frames = kFrames;
  options.max_candidates = 150;
  auto read = LoadCheckImages(sequence, document, **model, found->scan_from_object,
                              scene.OccludersOf(document, instance), options, "", work);
  if (!read) return read.error();
  images.images = std::move(*read);
  return images;
}

ImageChecksView CheckPose(const InstanceImages& images, const Eigen::Isometry3d& scan_from_object,
                          const Occluders& occluders) {
  ImageChecksView view;
  view.instance = images.instance;
  view.running = false;
  if (images.images == nullptr) {
    view.problem = "No frame of the sequence shows it well.";
    return view;
  }
  const auto checks = CheckImages(*images.images, *images.model, scan_from_object, occluders);
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
    for (const OutlinePolyline& line : checks[i].outline.lines) {
      check.lines.push_back({line.kind == OutlineKind::kCrease, line.hidden, line.pixels});
    }
    view.images.push_back(std::move(check));
  }
  return view;
}

void RefineInImages(const InstanceImages& images, const Occluders& occluders,
                    const Eigen::Vector3d& up_in_scan, FreeMotion motion, const WorkContext& work,
                    RefinementView& refinement) {
  refinement.by_images = true;
  refinement.running = false;
  if (images.images == nullptr) {
    refinement.problem = "No frame of the sequence shows it well.";
    return;
  }
  ImageRefinementOptions options;
  options.motion = motion;
  const auto refined = RefineByImages(*images.images, *images.model, refinement.scan_from_object,
                                      up_in_scan, occluders, options, work);
  if (!refined) {
    refinement.problem = refined.error().message;
    return;
  }
  refinement.scan_from_object = refined->scan_from_object;
  refinement.converged = refined->stop == RefinementStop::kConverged;
  if (refined->stop == RefinementStop::kNoBetter) {
    refinement.problem = "No place nearby agrees better with the images.";
  }
  refinement.iteration = refined->iterations;
  refinement.azimuth_rad = refined->azimuth_rad;
  refinement.horizontal_m = refined->horizontal_m;
  refinement.height_m = refined->height_m;
  refinement.agreement = refined->agreement_after;
  refinement.agreement_before = refined->agreement_before;
  refinement.offset_px = refined->offset_after_px;
  refinement.offset_before_px = refined->offset_before_px;
  SetDeviations(refined->covariance, up_in_scan, refinement);
}

}  // namespace plumbline
