// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/proposals.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "engine/base/check.h"
#include "engine/vision/detector.h"

namespace plumbline {
namespace {

void SortByScore(std::vector<Detection>& detections) {
  const auto key = [](const Detection& d) {
    return std::tie(d.category, d.box.x0, d.box.y0, d.box.x1, d.box.y1);
  };
  std::sort(detections.begin(), detections.end(), [&](const Detection& a, const Detection& b) {
    return a.score != b.score ? a.score > b.score : key(a) < key(b);
  });
}

class ProposalDetections : public FrameDetections {
 public:
  explicit ProposalDetections(std::vector<Detection> proposals) : proposals_(std::move(proposals)) {
    SortByScore(proposals_);
    for (const Detection& proposal : proposals_)
      by_category_[proposal.category].Add(proposal.box, proposal.score);
    for (auto& [category, boxes] : by_category_) boxes.Sort();
  }
  std::span<const Detection> proposals() const override { return proposals_; }
  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    PLB_CHECK(boxes.size() == scores.size());
    const auto found = by_category_.find(category);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      scores[i] = found == by_category_.end() ? 0.0f : found->second.Score(boxes[i]);
    }
  }

 private:
  std::vector<Detection> proposals_;
  std::map<std::string, ScoredBoxes, std::less<>> by_category_;
};

}  // namespace

std::vector<Detection> SuppressNonMaxima(std::vector<Detection> detections, float max_iou) {
  SortByScore(detections);
  std::vector<Detection> kept;
  for (Detection& candidate : detections) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const Detection& better) {
      return better.category == candidate.category && Iou(better.box, candidate.box) > max_iou;
    });
    if (!covered) kept.push_back(std::move(candidate));
  }
  return kept;
}

void ScoredBoxes::Add(const Box2& box, float score) {
  if (!box.empty()) entries_.push_back({box, box.area(), score});
}

void ScoredBoxes::Sort() {
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.score > b.score; });
}

float ScoredBoxes::Score(const Box2& query) const {
  if (query.empty()) return 0;
  const float area = query.area();
  float best = 0;
  for (const Entry& entry : entries_) {
    if (entry.score <= best) break;  // IoU is at most 1, and the rest score less
    const float width = std::min(query.x1, entry.box.x1) - std::max(query.x0, entry.box.x0);
    const float height = std::min(query.y1, entry.box.y1) - std::max(query.y0, entry.box.y0);
    if (width <= 0 || height <= 0) continue;
    const float shared = width * height;
    best = std::max(best, entry.score * shared / (area + entry.area - shared));
  }
  return best;
}

std::unique_ptr<const FrameDetections> DetectionsFromProposals(std::vector<Detection> proposals) {
  return std::make_unique<ProposalDetections>(std::move(proposals));
}

}  // namespace plumbline
