// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_placement_images.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "engine/annotation/check_frames.h"
#include "engine/annotation/image_refinement.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr int kFrames = 6, kLeastFrames = 2, kFramesLookedAt = 150;
constexpr int kAzimuths = 24;
constexpr std::size_t kPromising = 4;
/// Of agreement, which is 0.4 to 0.7 for poses that are right, and 0.1 for those that are not.
constexpr double kAgrees = 0.3, kClearlyBetter = 0.1;
/// What the scan knows nothing of must convince: a chair's slats lie on other edges easily.
constexpr double kConvincing = 0.2;

std::shared_ptr<const AnnotationImages> ImagesOf(const PlacementImages& task,
                                                 const OutlineModel& model,
                                                 const Eigen::Isometry3d& start,
                                                 const Occluders& occluders,
                                                 const WorkContext& work) {
  CheckFrameOptions options;
  options.frames = kFrames;
  options.max_candidates = kFramesLookedAt;
  const auto frames =
      ChooseCheckFrames(*task.sequence, task.document, model, start, occluders, options, work);
  if (!frames || static_cast<int>(frames->size()) < kLeastFrames) return nullptr;
  std::vector<int> indices;
  for (const CheckFrame& frame : *frames) indices.push_back(frame.frame);
  auto images = AnnotationImages::Load(task.sequence, task.document, indices, "", work);
  return images ? *images : nullptr;
}

double Best(const PlacementView& placement) {
  double best = 0;
  for (const PlacementCandidate& candidate : placement.candidates) {
    best = std::max(best, candidate.agreement.value_or(0));
  }
  return best;
}

/// The candidate that the images clearly prefer comes first; the others stay in their order.
void PutBestFirst(PlacementView& placement) {
  auto& candidates = placement.candidates;
  const auto best =
      std::max_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
        return a.agreement.value_or(0) < b.agreement.value_or(0);
      });
  if (best == candidates.end() || best == candidates.begin()) return;
  if (*best->agreement < kAgrees) return;
  if (*best->agreement < candidates.front().agreement.value_or(0) + kClearlyBetter) return;
  std::rotate(candidates.begin(), best, best + 1);
  placement.by_images = true;
}

/// The best pose around the start that the outline finds in the images: all azimuths coarsely, then
/// the most promising as `By images` does it.
std::optional<PlacementCandidate> SearchInImages(
    const PlacementImages& task, const AnnotationImages& images, const OutlineModel& model,
    const Occluders& occluders, const Eigen::Isometry3d& start, const WorkContext& work) {
  ImageRefinementOptions coarse, fine;
  coarse.motion = fine.motion = task.motion;
  coarse.max_shift_m = 0.3;
  coarse.max_turn_deg = 10;
  coarse.coarse_samples = 1000;
  coarse.starts = 3;
  std::vector<ImageRefinement> found;
  const auto refine = [&](const Eigen::Isometry3d& from, const ImageRefinementOptions& options) {
    auto refined = RefineByImages(images, model, from, task.up_in_scan, occluders, options, work);
    if (refined && refined->stop != RefinementStop::kNoBetter) found.push_back(*refined);
  };
  for (int i = 0; i < kAzimuths && !work.stop.stop_requested(); ++i) {
    Eigen::Isometry3d turned = start;
    turned.linear() =
        Eigen::AngleAxisd(2 * std::numbers::pi * i / kAzimuths, task.up_in_scan) * start.linear();
    refine(turned, coarse);
  }
  const auto better = [](const ImageRefinement& a, const ImageRefinement& b) {
    return a.agreement_after > b.agreement_after;
  };
  std::sort(found.begin(), found.end(), better);
  const std::size_t promising = std::min(kPromising, found.size());
  for (std::size_t i = 0; i < promising && !work.stop.stop_requested(); ++i) {
    refine(Eigen::Isometry3d(found[i].scan_from_object), fine);
  }
  if (found.empty() || work.stop.stop_requested()) return std::nullopt;
  const ImageRefinement& best = *std::min_element(found.begin(), found.end(), better);
  PlacementCandidate candidate;
  candidate.scan_from_object = best.scan_from_object;
  candidate.azimuth_rad = UprightFrame(-task.up_in_scan).Azimuth(best.scan_from_object.linear());
  candidate.agreement = best.agreement_after;
  candidate.from_images = true;
  return candidate;
}

}  // namespace

void ComparePlacements(const PlacementImages& task, const Eigen::Isometry3d& start,
                       const WorkContext& work,
                       const std::function<void(const PlacementView&)>& changed,
                       PlacementView& placement) {
  const auto model = task.outlines->Model(task.model);
  if (!model || placement.candidates.empty()) return;
  const Occluders occluders = task.outlines->OccludersOf(task.document, placement.instance);
  const auto images = ImagesOf(task, **model, start, occluders, work);
  if (images == nullptr) return;
  for (PlacementCandidate& candidate : placement.candidates) {
    if (work.stop.stop_requested()) return;
    candidate.agreement =
        MeanAgreement(CheckImages(*images, **model, candidate.scan_from_object, occluders));
  }
  placement.images = static_cast<int>(images->images().size());
  PutBestFirst(placement);
  if (Best(placement) > kAgrees) return;
  placement.searching = true;
  changed(placement);
  auto found = SearchInImages(task, *images, **model, occluders, start, work);
  placement.searching = false;
  if (!found || *found->agreement < Best(placement) + kConvincing) return;
  placement.candidates.push_back(std::move(*found));
  PutBestFirst(placement);
}

}  // namespace plumbline
