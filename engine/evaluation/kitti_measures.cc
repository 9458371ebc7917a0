// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/kitti_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "engine/evaluation/object_pairs.h"

namespace plumbline {
namespace {

/// Of the development kit: least height of the 2-D box [px] and largest share cut off.
struct LevelLimits {
  double height_px, truncation;
};
constexpr std::array<LevelLimits, 3> kLimits = {{{40, 0.15}, {25, 0.30}, {25, 0.50}}};
constexpr double kNear_m = 0.1;

double OverlapOf(const StandingBox& a, const StandingBox& b, KittiOverlap overlap) {
  return overlap == KittiOverlap::kVolume ? Iou(a, b) : BaseIou(a, b);
}

double OrientationSimilarity(double azimuth_a, double azimuth_b) {
  return 0.5 * (1 + std::cos(azimuth_a - azimuth_b));
}

bool CountsAt(const KittiBox& box, KittiLevel level) { return box.level && *box.level <= level; }

/// What has been counted once the candidates down to one are taken.
struct Point {
  int right = 0, wrong = 0;
  double similarity = 0;  ///< Sum over the right ones.
};

/// Mean over places of recall of the highest value at that recall or beyond.
/// @param of  Of a point: precision, or orientation similarity.
template <typename Of>
double Interpolated(const std::vector<Point>& points, int truths, int places, bool from_zero,
                    Of&& of) {
  if (truths == 0) return 0;
  double sum = 0;
  for (int i = from_zero ? 0 : 1; i <= places; ++i) {
    const double recall = static_cast<double>(i) / places;
    double best = 0;
    for (const Point& point : points) {
      if (point.right >= recall * truths - 1e-9) best = std::max(best, of(point));
    }
    sum += best;
  }
  return sum / (from_zero ? places + 1 : places);
}

}  // namespace

std::optional<KittiLevel> LevelIn(const KittiViews& views, const StandingBox& box,
                                  const UprightFrame& upright) {
  const std::array<Eigen::Vector3d, 8> corners = CornersOf(box, upright);
  std::optional<KittiLevel> easiest;
  for (const Eigen::Isometry3d& cam_from_world : views.cam_from_world) {
    Eigen::AlignedBox2d whole;
    bool in_front = true;
    for (const Eigen::Vector3d& corner : corners) {
      const Eigen::Vector3d in_cam = cam_from_world * corner;
      in_front = in_front && in_cam.z() > kNear_m;
      if (in_front) whole.extend(views.camera.Project(in_cam));
    }
    if (!in_front) continue;
    const Eigen::AlignedBox2d image(
        Eigen::Vector2d(0, 0), Eigen::Vector2d(views.camera.width - 1, views.camera.height - 1));
    const Eigen::AlignedBox2d inside = whole.intersection(image);
    if (inside.isEmpty()) continue;
    const double height_px = inside.sizes().y();
    const double truncation = 1 - inside.volume() / std::max(1e-9, whole.volume());
    for (std::size_t level = 0; level < kLimits.size(); ++level) {
      if (height_px < kLimits[level].height_px || truncation > kLimits[level].truncation) continue;
      const auto met = static_cast<KittiLevel>(level);
      easiest = easiest ? std::min(*easiest, met) : met;
    }
  }
  return easiest;
}

KittiPrecision KittiPrecisionOf(std::vector<KittiCandidate> candidates,
                                std::span<const KittiBox> truths, KittiOverlap overlap,
                                double least_iou, KittiLevel level) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  KittiPrecision result;
  for (const KittiBox& truth : truths) result.truths += CountsAt(truth, level);
  std::vector<bool> taken(truths.size(), false);
  std::vector<Point> points;
  Point now;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const KittiCandidate& candidate = candidates[i];
    std::optional<std::size_t> best;
    double best_iou = least_iou;
    for (std::size_t j = 0; j < truths.size(); ++j) {
      const double iou = taken[j] ? 0 : OverlapOf(candidate.box, truths[j].box, overlap);
      if (iou < best_iou || (best && iou == best_iou)) continue;
      best = j;
      best_iou = iou;
    }
    if (best) {
      taken[*best] = true;
      if (CountsAt(truths[*best], level)) {
        ++now.right;
        now.similarity += OrientationSimilarity(candidate.azimuth_rad, truths[*best].azimuth_rad);
      }
    } else if (CountsAt(candidate, level)) {
      ++now.wrong;
    }
    // A threshold cannot tell equal scores apart.
    if (i + 1 < candidates.size() && candidates[i + 1].score == candidate.score) continue;
    if (now.right + now.wrong > 0) points.push_back(now);
  }
  result.found = now.right;
  result.wrong = now.wrong;
  const auto precision = [](const Point& p) {
    return static_cast<double>(p.right) / (p.right + p.wrong);
  };
  const auto similarity = [](const Point& p) { return p.similarity / (p.right + p.wrong); };
  result.ap_40 = Interpolated(points, result.truths, 40, false, precision);
  result.ap_11 = Interpolated(points, result.truths, 10, true, precision);
  result.aos_40 = Interpolated(points, result.truths, 40, false, similarity);
  result.aos_11 = Interpolated(points, result.truths, 10, true, similarity);
  return result;
}

Result<KittiMeasures> MeasureKitti(std::span<const EstimatedObject> candidates,
                                   const GroundTruth& truth, const ModelDatabase& database,
                                   const MapEvaluation& evaluation, const std::string& category,
                                   const std::optional<KittiViews>& views) {
  const Result<CountedObjects> objects = CollectObjects(candidates, truth, database, {});
  if (!objects) return objects.error();
  const UprightFrame& upright = objects->upright;
  const auto level_of = [&](const StandingBox& box) {
    return views ? LevelIn(*views, box, upright) : std::optional(KittiLevel::kEasy);
  };
  KittiMeasures measures;
  measures.category = category;
  measures.has_levels = views.has_value();
  std::vector<KittiCandidate> ranked;
  std::vector<KittiBox> true_boxes;
  std::vector<std::string> estimate_ids, truth_ids;
  for (std::size_t i = 0; i < objects->estimates.size(); ++i) {
    const EstimatedObject& estimate = objects->estimates[i];
    if (estimate.category != category) continue;
    const Eigen::Isometry3d pose = evaluation.truth_from_estimate * estimate.world_from_object;
    KittiCandidate candidate;
    candidate.box = BoxOf(*objects->estimate_models[i], pose, estimate.scale, upright);
    candidate.azimuth_rad = upright.Azimuth(pose.linear());
    candidate.level = level_of(candidate.box);
    candidate.score = estimate.probability;
    ranked.push_back(candidate);
    estimate_ids.push_back(estimate.id);
  }
  for (std::size_t j = 0; j < objects->truths.size(); ++j) {
    const GroundTruthInstance& instance = objects->truths[j];
    if (instance.category != category) continue;
    KittiBox box;
    box.box = instance.size_m ? BoxOf(*instance.size_m, instance.world_from_object, upright)
                              : BoxOf(*objects->truth_models[j], instance.world_from_object,
                                      instance.scale, upright);
    box.azimuth_rad = upright.Azimuth(instance.world_from_object.linear());
    box.level = level_of(box.box);
    true_boxes.push_back(box);
    truth_ids.push_back(instance.id);
  }
  for (std::size_t k = 0; k < KittiMeasures::kLeastIous.size(); ++k) {
    for (std::size_t level = 0; level < kLimits.size(); ++level) {
      const auto at = [&](KittiOverlap overlap) {
        return KittiPrecisionOf(ranked, true_boxes, overlap, KittiMeasures::kLeastIous[k],
                                static_cast<KittiLevel>(level));
      };
      measures.volume[k][level] = at(KittiOverlap::kVolume);
      measures.base[k][level] = at(KittiOverlap::kBase);
    }
  }
  for (const MatchedObject& matched : evaluation.matched) {
    const auto estimate = std::find(estimate_ids.begin(), estimate_ids.end(), matched.estimate.id);
    const auto instance = std::find(truth_ids.begin(), truth_ids.end(), matched.truth.id);
    if (estimate == estimate_ids.end() || instance == truth_ids.end()) continue;
    const KittiCandidate& a = ranked[static_cast<std::size_t>(estimate - estimate_ids.begin())];
    const KittiBox& b = true_boxes[static_cast<std::size_t>(instance - truth_ids.begin())];
    measures.pairs.push_back({matched.estimate.id, matched.truth.id, Iou(a.box, b.box),
                              BaseIou(a.box, b.box),
                              OrientationSimilarity(a.azimuth_rad, b.azimuth_rad)});
  }
  return measures;
}

nlohmann::json KittiToJson(const KittiMeasures& measures) {
  const auto precision_to_json = [](const KittiPrecision& p) {
    return nlohmann::json{{"ap_40", p.ap_40},   {"ap_11", p.ap_11},   {"aos_40", p.aos_40},
                          {"aos_11", p.aos_11}, {"truths", p.truths}, {"found", p.found},
                          {"wrong", p.wrong}};
  };
  nlohmann::json json = {{"category", measures.category}, {"levels", measures.has_levels}};
  constexpr std::array<const char*, 2> kIouNames = {"iou_70", "iou_50"};
  for (std::size_t k = 0; k < kIouNames.size(); ++k) {
    for (std::size_t level = 0; level < kKittiLevelNames.size(); ++level) {
      const std::string name(kKittiLevelNames[level]);
      json["box_3d"][kIouNames[k]][name] = precision_to_json(measures.volume[k][level]);
      json["birds_eye"][kIouNames[k]][name] = precision_to_json(measures.base[k][level]);
    }
  }
  json["pairs"] = nlohmann::json::array();
  for (const KittiPair& pair : measures.pairs)
    json["pairs"].push_back({{"id", pair.estimate},
                             {"ground_truth", pair.truth},
                             {"iou_3d", pair.iou},
                             {"iou_birds_eye", pair.base_iou},
                             {"orientation_similarity", pair.orientation}});
  return json;
}

}  // namespace plumbline
