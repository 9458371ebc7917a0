// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/proposals.h"

#include <algorithm>
#include <map>
#include <tuple>

#include <opencv2/core/hal/intrin.hpp>

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
  if (!box.empty()) entries_.push_back({box, score});
}

void ScoredBoxes::Sort() {
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.score > b.score; });
  const std::size_t size = (entries_.size() + 3) / 4 * 4;
  for (std::vector<float>* numbers : {&x0_, &y0_, &x1_, &y1_, &score_}) numbers->assign(size, 0.0f);
  area_.assign(size, 1.0f);  // no division by zero where nothing is
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto& [box, score] = entries_[i];
    x0_[i] = box.x0;
    y0_[i] = box.y0;
    x1_[i] = box.x1;
    y1_[i] = box.y1;
    area_[i] = box.area();
    score_[i] = score;
  }
}

float ScoredBoxes::Score(const Box2& query) const {
  if (query.empty()) return 0;
  const cv::v_float32x4 x0 = cv::v_setall_f32(query.x0), y0 = cv::v_setall_f32(query.y0);
  const cv::v_float32x4 x1 = cv::v_setall_f32(query.x1), y1 = cv::v_setall_f32(query.y1);
  const cv::v_float32x4 area = cv::v_setall_f32(query.area()), zero = cv::v_setzero_f32();
  cv::v_float32x4 best = zero;
  for (std::size_t i = 0; i < score_.size(); i += 4) {
    // IoU is at most 1, and the rest score less.
    if (i % 16 == 0 && score_[i] <= cv::v_reduce_max(best)) break;
    const cv::v_float32x4 width =
        cv::v_max(zero, cv::v_min(x1, cv::v_load(&x1_[i])) - cv::v_max(x0, cv::v_load(&x0_[i])));
    const cv::v_float32x4 height =
        cv::v_max(zero, cv::v_min(y1, cv::v_load(&y1_[i])) - cv::v_max(y0, cv::v_load(&y0_[i])));
    const cv::v_float32x4 shared = width * height;
    const cv::v_float32x4 iou = shared / (area + cv::v_load(&area_[i]) - shared);
    best = cv::v_max(best, cv::v_load(&score_[i]) * iou);
  }
  return cv::v_reduce_max(best);
}

std::unique_ptr<const FrameDetections> DetectionsFromProposals(std::vector<Detection> proposals) {
  return std::make_unique<ProposalDetections>(std::move(proposals));
}

}  // namespace plumbline
