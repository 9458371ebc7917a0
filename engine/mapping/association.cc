// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/association.h"

#include <algorithm>
#include <map>

#include <opencv2/imgproc.hpp>

namespace plumbline {
namespace {

constexpr float kSameBoxIou = 0.8f;
constexpr float kSameObjectIou = 0.4f;
constexpr double kSharedFootprint = 0.3;
constexpr float kSameViewIou = 0.5f;
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

/// The bounding box of an object at its mean state, seen from above.
struct Footprint {
  std::vector<cv::Point2f> corners;  ///< Convex, in the axes of the upright frame [m].
  double bottom = 0, top = 0;
  double size = 0;  ///< Larger side.
  Eigen::Vector3d center;
};

Footprint FootprintOf(const MapObject& object, const MapFrame& map) {
  Footprint footprint;
  const Eigen::AlignedBox3d box = map.database->model(object.mean().label).bounds.cast<double>();
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

}  // namespace

std::vector<ProposalReport> ExplainProposals(std::span<const Detection> proposals,
                                             std::span<const MapObject> objects,
                                             const RenderedMaps& maps,
                                             const ModelDatabase& database,
                                             const MapperOptions& options) {
  const std::map<int, Mask> masks = maps.id.empty() ? std::map<int, Mask>{} : FindMasks(maps.id);
  std::vector<ProposalReport> reports;
  for (const Detection& proposal : proposals) {
    ProposalReport report{
        proposal.box, proposal.category, proposal.score, ProposalFate::kSpawned, {}};
    // Image pixels to the half-size maps' (pixel centres at integers).
    const Box2 box{(proposal.box.x0 + 0.5f) * 0.5f - 0.5f, (proposal.box.y0 + 0.5f) * 0.5f - 0.5f,
                   (proposal.box.x1 + 0.5f) * 0.5f - 0.5f, (proposal.box.y1 + 0.5f) * 0.5f - 0.5f};
    double best = 0;
    for (const MapObject& object : objects) {
      const auto mask = masks.find(object.id.value);
      if (mask == masks.end()) continue;
      const double inside = PixelsInBox(maps.id, object.id.value, box);
      const double of_box = inside / std::max(1.0f, box.area()),
                   of_mask = inside / mask->second.pixels;
      const float iou = Iou(box, mask->second.box);
      const bool same = object.category == proposal.category;
      const bool tentative = object.state == ObjectState::kTentative;
      const bool explained =
          (same && (of_box > options.explained_overlap || of_mask > options.explained_overlap ||
                    iou > kSameObjectIou || (tentative && iou > kTentativeIou))) ||
          iou > kSameBoxIou;
      const double strength = (same ? 1.0 : 0.0) + iou;
      if (explained && strength > best) {
        best = strength;
        report.fate = ProposalFate::kExplained;
        report.object = object.id;
      }
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
  if (std::min(fa.top, fb.top) > std::max(fa.bottom, fb.bottom)) {
    std::vector<cv::Point2f> shared;
    const double area = cv::intersectConvexConvex(fa.corners, fb.corners, shared);
    if (area >
        kSharedFootprint * std::min(cv::contourArea(fa.corners), cv::contourArea(fb.corners)))
      return true;
  }
  const double reach = std::max(fa.size, fb.size);
  return a.updated && b.updated && Iou(a.visible_box, b.visible_box) > kSameViewIou &&
         (fa.center - fb.center).norm() < reach;
}

}  // namespace plumbline
