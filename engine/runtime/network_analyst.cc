// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/network_analyst.h"

#include <algorithm>
#include <vector>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

/// Columns of a score map: enough to see peaks a tenth of a chair wide.
constexpr int kScoreColumns = 120;

const ObjectReport* FindReported(const MapSnapshot& snapshot, ObjectId id) {
  for (const ObjectReport& object : snapshot.report.objects)
    if (object.id == id) return &object;
  return nullptr;
}

}  // namespace

OtherEdges NetworkAnalyst::EdgesOf(const cv::Mat& image, const std::string& choice) {
  OtherEdges other;
  other.choice = choice;
  if (image.empty()) {
    other.problem = "This frame has no image.";
    return other;
  }
  if (choice != edges_choice_) {
    auto detector = CreateEdgeDetector(choice, nullptr);
    edges_choice_ = choice;
    edges_problem_ = detector.ok() ? "" : detector.error().message;
    edges_ = detector.ok() ? std::move(detector).value() : nullptr;
  }
  other.problem = edges_problem_;
  if (edges_ == nullptr) return other;
  Frame frame;
  frame.image = image;
  const Result<EdgeMap> edges = edges_->Detect(frame);
  if (!edges.ok()) {
    other.problem = edges.error().message;
    return other;
  }
  other.probability = edges->probability;
  other.angle = edges->angle;
  return other;
}

const FrameDetections* NetworkAnalyst::Detect(const MapSnapshot& snapshot, const RunRecipe* recipe,
                                              std::string& problem) {
  const bool by_network =
      recipe != nullptr && recipe->detector && recipe->detector->source != DetectorSource::kDataset;
  const std::string choice = by_network ? ToText(*recipe->detector) : "";
  if (choice != detector_choice_) {
    detector_choice_ = choice;
    detector_problem_.clear();
    detector_ = nullptr;
    if (by_network) {
      auto detector = CreateDetector(choice, nullptr);
      detector_problem_ = detector.ok() ? "" : detector.error().message;
      if (detector.ok()) detector_ = std::move(detector).value();
    }
  }
  problem = detector_problem_;
  if (!by_network) {
    std::vector<Detection> proposals;
    for (const ProposalReport& proposal : snapshot.report.proposals)
      proposals.push_back({proposal.box, proposal.category, proposal.score});
    detections_ = DetectionsFromProposals(std::move(proposals));
    return detections_.get();
  }
  if (detector_ == nullptr) return nullptr;
  Frame frame;
  frame.image = snapshot.image;
  auto found = detector_->Detect(frame);
  if (!found.ok()) {
    problem = found.error().message;
    return nullptr;
  }
  detections_ = std::move(found).value();
  return detections_.get();
}

ScoreMap NetworkAnalyst::ScoresOf(const MapSnapshot& snapshot, ObjectId object,
                                  const RunRecipe* recipe) {
  ScoreMap map;
  const ObjectReport* report = FindReported(snapshot, object);
  if (report == nullptr || report->visible_box.empty()) {
    map.problem = "Select an object that is in view.";
    return map;
  }
  if (snapshot.image.empty()) {
    map.problem = "This frame has no image.";
    return map;
  }
  map.category = report->category;
  map.width_px = report->visible_box.x1 - report->visible_box.x0;
  map.height_px = report->visible_box.y1 - report->visible_box.y0;
  const FrameDetections* detections = Detect(snapshot, recipe, map.problem);
  if (detections == nullptr) return map;
  const int width = snapshot.image.cols, height = snapshot.image.rows;
  map.step_px = std::max(1, (width + kScoreColumns - 1) / kScoreColumns);
  map.scores.create((height + map.step_px - 1) / map.step_px,
                    (width + map.step_px - 1) / map.step_px, CV_32FC1);
  std::vector<Box2> boxes;
  boxes.reserve(map.scores.total());
  const auto half_width = static_cast<float>(map.width_px / 2);
  const auto half_height = static_cast<float>(map.height_px / 2);
  for (int row = 0; row < map.scores.rows; ++row) {
    for (int column = 0; column < map.scores.cols; ++column) {
      const auto x = static_cast<float>(column * map.step_px);
      const auto y = static_cast<float>(row * map.step_px);
      // The part inside of the image: that is what a detector can see of it.
      boxes.push_back({std::max(-0.5f, x - half_width), std::max(-0.5f, y - half_height),
                       std::min(static_cast<float>(width) - 0.5f, x + half_width),
                       std::min(static_cast<float>(height) - 0.5f, y + half_height)});
    }
  }
  detections->ScoreBoxes(map.category, boxes, {map.scores.ptr<float>(), boxes.size()});
  return map;
}

}  // namespace plumbline
