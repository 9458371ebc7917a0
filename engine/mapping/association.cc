// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/association.h"

#include <algorithm>
#include <map>

namespace plumbline {
namespace {

constexpr float kSameBoxIou = 0.8f;
constexpr float kSameObjectIou = 0.4f;

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
      mask.box = {std::min<float>(mask.box.x0, x), std::min<float>(mask.box.y0, y), std::max<float>(mask.box.x1, x),
                  std::max<float>(mask.box.y1, y)};
    }
  }
  return masks;
}

int PixelsInBox(const cv::Mat& id, int object, const Box2& box) {
  int count = 0;
  const int y0 = std::max(0, static_cast<int>(box.y0)), y1 = std::min(id.rows - 1, static_cast<int>(box.y1));
  const int x0 = std::max(0, static_cast<int>(box.x0)), x1 = std::min(id.cols - 1, static_cast<int>(box.x1));
  for (int y = y0; y <= y1; ++y) {
    const auto* row = id.ptr<std::uint16_t>(y);
    for (int x = x0; x <= x1; ++x) count += row[x] == object ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<ProposalReport> ExplainProposals(std::span<const Detection> proposals, std::span<const MapObject> objects,
                                             const RenderedMaps& maps, const ModelDatabase& database,
                                             const MapperOptions& options) {
  const std::map<int, Mask> masks = maps.id.empty() ? std::map<int, Mask>{} : FindMasks(maps.id);
  std::vector<ProposalReport> reports;
  for (const Detection& proposal : proposals) {
    ProposalReport report{proposal.box, proposal.category, proposal.score, ProposalFate::kSpawned, {}};
    // Image pixels to the half-size maps' (pixel centres at integers).
    const Box2 box{(proposal.box.x0 + 0.5f) * 0.5f - 0.5f, (proposal.box.y0 + 0.5f) * 0.5f - 0.5f,
                   (proposal.box.x1 + 0.5f) * 0.5f - 0.5f, (proposal.box.y1 + 0.5f) * 0.5f - 0.5f};
    double best = 0;
    for (const MapObject& object : objects) {
      const auto mask = masks.find(object.id.value);
      if (mask == masks.end()) continue;
      const double inside = PixelsInBox(maps.id, object.id.value, box);
      const double of_box = inside / std::max(1.0f, box.area()), of_mask = inside / mask->second.pixels;
      const float iou = Iou(box, mask->second.box);
      const bool same = object.category == proposal.category;
      const bool explained = (same && (of_box > options.explained_overlap || of_mask > options.explained_overlap ||
                                       iou > kSameObjectIou)) ||
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
      } else if (proposal.score < options.min_birth_score) {
        report.fate = ProposalFate::kLowScore;
      }
    }
    reports.push_back(report);
  }
  return reports;
}

bool SamePlace(const MapObject& a, const MapObject& b, const MapFrame& map) {
  if (a.category != b.category) return false;
  const PoseHypothesis pa = ToHypothesis(a.mean(), map), pb = ToHypothesis(b.mean(), map);
  const auto width = [&](ModelId label) {
    const Eigen::Vector3f size = map.database->model(label).bounds.sizes();
    return std::min(size.x(), size.y());
  };
  const double reach = 0.33 * std::max(width(pa.label), width(pb.label));
  return (pa.center_in_world - pb.center_in_world).norm() < reach;
}

}  // namespace plumbline
