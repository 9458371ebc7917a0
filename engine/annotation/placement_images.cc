// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/placement_images.h"

#include <algorithm>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/annotation/image_refinement.h"

namespace plumbline {
namespace {

constexpr int kFrames = 6, kLeastFrames = 2, kFramesLookedAt = 150;
constexpr int kAzimuths = 24;
constexpr std::size_t kPromising = 4;
constexpr double kAgrees = 0.3, kClearlyBetter = 0.1, kConvincing = 0.2;

double Best(std::span<const double> agreements) {
  return agreements.empty()
             ? 0
             : std::max(0.0, *std::max_element(agreements.begin(), agreements.end()));
}

}  // namespace

std::optional<PlacementImages> PlacementImages::Choose(const PlacementQuestion& question,
                                                       const Eigen::Isometry3d& start,
                                                       const WorkContext& work) {
  const auto model = question.outlines->Model(question.model, question.scale);
  if (!model) return std::nullopt;
  PlacementImages chosen;
  chosen.up_in_scan_ = question.up_in_scan;
  chosen.motion_ = question.motion;
  chosen.model_ = *model;
  chosen.occluders_ = question.outlines->OccludersOf(question.document, question.instance);
  CheckFrameOptions options;
  options.frames = kFrames;
  options.max_candidates = kFramesLookedAt;
  options.among = question.among;
  const auto images = LoadCheckImages(question.sequence, question.document, **model, start,
                                      chosen.occluders_, options, question.edges, work);
  if (!images || *images == nullptr) return std::nullopt;
  chosen.images_ = *images;
  if (chosen.size() < kLeastFrames) return std::nullopt;
  return chosen;
}

double PlacementImages::Agreement(const Eigen::Isometry3d& scan_from_object) const {
  return MeanAgreement(CheckImages(*images_, *model_, scan_from_object, occluders_));
}

std::optional<PlacementImages::Found> PlacementImages::Search(const Eigen::Isometry3d& start,
                                                              const WorkContext& work) const {
  ImageRefinementOptions coarse, fine;
  coarse.motion = fine.motion = motion_;
  coarse.max_shift_m = 0.3;
  coarse.max_turn_deg = 10;
  coarse.coarse_samples = 1000;
  coarse.starts = 3;
  std::vector<ImageRefinement> found;
  const auto refine = [&](const Eigen::Isometry3d& from, const ImageRefinementOptions& options) {
    auto refined = RefineByImages(*images_, *model_, from, up_in_scan_, occluders_, options, work);
    if (refined && refined->stop != RefinementStop::kNoBetter) found.push_back(*refined);
  };
  for (int i = 0; i < kAzimuths && !work.stop.stop_requested(); ++i) {
    Eigen::Isometry3d turned = start;
    turned.linear() =
        Eigen::AngleAxisd(2 * std::numbers::pi * i / kAzimuths, up_in_scan_) * start.linear();
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
  return Found{best.scan_from_object, best.agreement_after};
}

bool AnyAgrees(std::span<const double> agreements) { return Best(agreements) > kAgrees; }

std::size_t PreferredByImages(std::span<const double> agreements) {
  const auto best = std::max_element(agreements.begin(), agreements.end());
  if (best == agreements.end() || *best < kAgrees || *best < agreements.front() + kClearlyBetter) {
    return 0;
  }
  return static_cast<std::size_t>(best - agreements.begin());
}

bool Convinces(double agreement, std::span<const double> agreements) {
  return agreement >= Best(agreements) + kConvincing;
}

}  // namespace plumbline
