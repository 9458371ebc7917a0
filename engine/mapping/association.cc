// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/association.h"

#include <algorithm>
#include <limits>
#include <map>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/assignment.h"

namespace plumbline {
namespace {

constexpr float kSameBoxIou = 0.8f;
constexpr float kSameObjectIou = 0.4f;  ///< Of a second box of an object that has one.
constexpr float kMatchIou = 0.3f;
constexpr double kGroupCover = 0.25;        ///< Of a box that is too large, by the masks in it.
constexpr double kTentativePenalty = 0.15;  ///< In IoU: what is settled comes first.
constexpr double kSharedFootprint = 0.3;
/// Of two that are confirmed, whose places are known: in 32 synthetic rooms, the office and the
/// kitchen no two of a category share .01.
constexpr double kSharedByConfirmed = 0.1;
constexpr float kSameViewIou = 0.5f;
/// Seen along a row, confirmed chairs that stand side by side show in one place. Twins of one chair
/// do, and share its back rest besides.
constexpr double kSharedByTwins = 0.03;
constexpr float kTentativeIou =
    0.2f;  // its mean may still be far off; a second birth would not find more

struct Mask {
  int pixels = 0;
  Box2 box{1e9f, 1e9f, -1e9f, -1e9f};  ///< In the maps' pixels.
};

std::map<int, Mask> FindMasks(const cv::Mat& id) {
  std::map<int, Mask> masks;
  for (int y = 0; y < id.rows; ++y) {
    const auto* row = id.ptr<std::uint16_t>(y);
    for (int x = 0; x < id.cols; ++x) {
      if (row[x] == 0) continue;
      Mask& mask = masks[row[x]];
      ++mask.pixels;
      mask.box = {std::min<float>(mask.box.x0, x), std::min<float>(mask.box.y0, y),
                  std::max<float>(mask.box.x1, x), std::max<float>(mask.box.y1, y)};
    }
  }
  return masks;
}

int PixelsInBox(const cv::Mat& id, int object, const Box2& box) {
  int count = 0;
  const int y0 = std::max(0, static_cast<int>(box.y0)),
            y1 = std::min(id.rows - 1, static_cast<int>(box.y1));
  const int x0 = std::max(0, static_cast<int>(box.x0)),
            x1 = std::min(id.cols - 1, static_cast<int>(box.x1));
  for (int y = y0; y <= y1; ++y) {
    const auto* row = id.ptr<std::uint16_t>(y);
    for (int x = x0; x <= x1; ++x) count += row[x] == object ? 1 : 0;
  }
  return count;
}

/// Image pixels to the half-size maps' (pixel centres at integers).
Box2 InMaps(const Box2& box) {
  return {(box.x0 + 0.5f) * 0.5f - 0.5f, (box.y0 + 0.5f) * 0.5f - 0.5f,
          (box.x1 + 0.5f) * 0.5f - 0.5f, (box.y1 + 0.5f) * 0.5f - 0.5f};
}

Box2 InImage(const Box2& box, const RenderedMaps& maps) {
  return Intersection(box,
                      {0, 0, static_cast<float>(maps.id.cols), static_cast<float>(maps.id.rows)});
}

/// The bounding box of an object at its mean state, seen from above.
struct Footprint {
  std::vector<cv::Point2f> corners;  ///< Convex, in the axes of the upright frame [m].
  double bottom = 0, top = 0;
  double size = 0;  ///< Larger side.
  Eigen::Vector3d center;
};

Footprint FootprintOf(const MapObject& object, const MapFrame& map) {
  Footprint footprint;
  const Eigen::AlignedBox3d box =
      Scaled(map.database->model(object.mean().label).bounds, object.mean().scale);
  const Eigen::Isometry3d upright_from_object =
      Eigen::Isometry3d(map.upright.upright_rotation().transpose()) *
      object.mean().world_from_object;
  for (const auto& [x, y] :
       {std::pair{box.min().x(), box.min().y()}, std::pair{box.max().x(), box.min().y()},
        std::pair{box.max().x(), box.max().y()}, std::pair{box.min().x(), box.max().y()}}) {
    const Eigen::Vector3d corner = upright_from_object * Eigen::Vector3d(x, y, box.min().z());
    footprint.corners.emplace_back(static_cast<float>(corner.x()), static_cast<float>(corner.y()));
    footprint.bottom = corner.z();
  }
  footprint.top = footprint.bottom + box.sizes().z();
  footprint.size = std::max(box.sizes().x(), box.sizes().y());
  footprint.center = upright_from_object * box.center();
  return footprint;
}

/// Of the smaller one; 0 where one stands above the other.
double SharedFootprint(const Footprint& a, const Footprint& b) {
  if (std::min(a.top, b.top) <= std::max(a.bottom, b.bottom)) return 0;
  std::vector<cv::Point2f> shared;
  const double area = cv::intersectConvexConvex(a.corners, b.corners, shared);
  return area / std::min(cv::contourArea(a.corners), cv::contourArea(b.corners));
}

}  // namespace

std::vector<std::optional<std::size_t>> MatchProposals(std::span<const Detection> proposals,
                                                       std::span<const MapObject> objects,
                                                       const RenderedMaps& maps) {
  const std::map<int, Mask> masks = maps.id.empty() ? std::map<int, Mask>{} : FindMasks(maps.id);
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(objects.size()),
                                                   static_cast<Eigen::Index>(proposals.size()),
                                                   std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto mask = masks.find(objects[i].id.value);
    if (mask == masks.end()) continue;
    const bool tentative = objects[i].state == ObjectState::kTentative;
    for (std::size_t k = 0; k < proposals.size(); ++k) {
      if (objects[i].category != proposals[k].category) continue;
      const float iou = Iou(InMaps(proposals[k].box), mask->second.box);
      if (iou < (tentative ? kTentativeIou : kMatchIou)) continue;
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          1.0 + kTentativePenalty - iou * (0.5 + 0.5 * proposals[k].score) +
          (tentative ? kTentativePenalty : 0.0);
    }
  }
  std::vector<std::optional<std::size_t>> matched(objects.size());
  if (proposals.empty() || objects.empty()) return matched;
  // As many pairs as possible is not the aim, the best pairs are: each object may stay alone at the
  // price of a pair that hardly overlaps.
  const Eigen::Index n = cost.rows(), m = cost.cols();
  Eigen::MatrixXd square =
      Eigen::MatrixXd::Constant(n, m + n, std::numeric_limits<double>::infinity());
  square.leftCols(m) = cost;
  for (Eigen::Index i = 0; i < n; ++i) square(i, m + i) = 1.0 + 2 * kTentativePenalty;
  const std::vector<std::optional<int>> columns = AssignOneToOne(square);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (columns[i] && *columns[i] < m) matched[i] = static_cast<std::size_t>(*columns[i]);
  }
  return matched;
}

std::vector<ProposalReport> ExplainProposals(std::span<const Detection> proposals,
                                             std::span<const MapObject> objects,
                                             std::span<const std::optional<std::size_t>> matched,
                                             const RenderedMaps& maps,
                                             const ModelDatabase& database,
                                             const MapperOptions& options) {
  const std::map<int, Mask> masks = maps.id.empty() ? std::map<int, Mask>{} : FindMasks(maps.id);
  std::vector<ProposalReport> reports;
  for (std::size_t k = 0; k < proposals.size(); ++k) {
    const Detection& proposal = proposals[k];
    ProposalReport report{
        proposal.box, proposal.category, proposal.score, ProposalFate::kSpawned, {}};
    const Box2 box = InMaps(proposal.box);
    double best = 0;
    double masks_inside = 0;
    std::optional<ObjectId> in_group;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const MapObject& object = objects[i];
      if (matched[i] == k) {
        report.fate = ProposalFate::kExplained;
        report.object = object.id;
        best = std::numeric_limits<double>::infinity();
        break;
      }
      const auto mask = masks.find(object.id.value);
      if (mask == masks.end()) continue;
      const double inside = PixelsInBox(maps.id, object.id.value, box);
      const double of_box = inside / std::max(1.0f, box.area()),
                   of_mask = inside / mask->second.pixels;
      const float iou = Iou(box, mask->second.box);
      const bool same = object.category == proposal.category;
      if (same && of_mask > options.explained_overlap) {
        masks_inside += inside;
        if (!in_group) in_group = object.id;
      }
      // A part of an object, a second box of it, or the same thing under another name.
      const bool explained =
          (same && (of_box > options.explained_overlap || iou > kSameObjectIou)) ||
          iou > kSameBoxIou;
      const double strength = (same ? 1.0 : 0.0) + iou;
      if (explained && strength > best) {
        best = strength;
        report.fate = ProposalFate::kExplained;
        report.object = object.id;
      }
    }
    // A box about one or several objects that it holds, as long as they fill it: another object in
    // front of one of them leaves most of its box to itself.
    if (report.fate != ProposalFate::kExplained && in_group &&
        masks_inside > kGroupCover * InImage(box, maps).area()) {
      report.fate = ProposalFate::kExplained;
      report.object = *in_group;
    }
    if (report.fate != ProposalFate::kExplained) {
      if (database.OfCategory(proposal.category).empty()) {
        report.fate = ProposalFate::kUnknownCategory;
      } else if (proposal.score < options.min_spawn_score) {
        report.fate = ProposalFate::kLowScore;
      }
    }
    reports.push_back(report);
  }
  return reports;
}

bool Compete(const MapObject& a, const MapObject& b, const MapFrame& map) {
  if (a.category != b.category) return false;
  const Footprint fa = FootprintOf(a, map), fb = FootprintOf(b, map);
  const bool both_confirmed =
      a.state == ObjectState::kConfirmed && b.state == ObjectState::kConfirmed;
  const double shared = SharedFootprint(fa, fb);
  if (shared > (both_confirmed ? kSharedByConfirmed : kSharedFootprint)) return true;
  if (both_confirmed && shared <= kSharedByTwins) return false;
  const double reach = std::max(fa.size, fb.size);
  return a.updated && b.updated && Iou(a.visible_box, b.visible_box) > kSameViewIou &&
         (fa.center - fb.center).norm() < reach;
}

}  // namespace plumbline
