// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/frame_pictures.h"

#include <set>

#include <opencv2/imgproc.hpp>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

/// A contour of pixels as a smoother line: each point the mean of itself and its neighbours.
std::vector<Eigen::Vector2f> Smoothed(const std::vector<cv::Point>& contour, float scale) {
  std::vector<Eigen::Vector2f> line;
  const std::size_t n = contour.size();
  line.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point sum = contour[(i + n - 1) % n] + contour[i] + contour[(i + 1) % n];
    line.emplace_back((static_cast<float>(sum.x) / 3 + 0.5f) * scale - 0.5f,
                      (static_cast<float>(sum.y) / 3 + 0.5f) * scale - 0.5f);
  }
  return line;
}

}  // namespace

std::vector<OutlineView> OutlinesOf(const cv::Mat& id, cv::Size image_size) {
  std::vector<OutlineView> outlines;
  if (id.empty()) return outlines;
  std::set<std::uint16_t> ids;
  for (int y = 0; y < id.rows; ++y)
    ids.insert(id.ptr<std::uint16_t>(y), id.ptr<std::uint16_t>(y) + id.cols);
  ids.erase(0);
  const float scale = static_cast<float>(image_size.width) / static_cast<float>(id.cols);
  std::vector<std::vector<cv::Point>> contours;
  for (const std::uint16_t object : ids) {
    const cv::Mat mask = id == object;
    cv::findContours(mask, contours, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    OutlineView outline{{object}, {}};
    for (const auto& contour : contours) {
      if (contour.size() > 3) outline.contours.push_back(Smoothed(contour, scale));
    }
    if (!outline.contours.empty()) outlines.push_back(std::move(outline));
  }
  return outlines;
}

Result<std::unique_ptr<FramePictures>> FramePictures::Create(
    std::shared_ptr<const Sequence> sequence, std::shared_ptr<const ModelDatabase> database,
    const std::optional<EdgeChoice>& edges) {
  auto pictures = std::make_unique<FramePictures>(sequence->camera(), *database);
  auto detector = CreateEdgeDetector(ToText(edges ? *edges : DefaultEdges(*sequence)), sequence);
  if (!detector.ok()) return detector.error();
  pictures->sequence_ = std::move(sequence);
  pictures->edges_ = std::move(detector).value();
  return pictures;
}

std::shared_ptr<MapSnapshot> FramePictures::Make(FrameReport report) {
  auto snapshot = std::make_shared<MapSnapshot>();
  if (sequence_ != nullptr) {
    if (auto frame = sequence_->ReadFrame(report.frame); frame.ok()) {
      snapshot->image = frame->image;
      if (auto edges = edges_->Detect(*frame); edges.ok()) {
        snapshot->edge_probability = edges->probability;
        snapshot->edge_angle = edges->angle;
      }
    }
  }
  if (report.world_from_cam) {
    std::vector<PlacedModel> placed;
    for (const ObjectReport& object : report.objects) {
      if (object.state == ObjectState::kRetired) continue;
      placed.push_back({object.id, object.label, object.world_from_object, object.scale});
    }
    const RenderedMaps maps = renderer_.Render(camera_, report.world_from_cam->inverse(), placed);
    snapshot->depth = maps.depth;
    snapshot->id = maps.id;
    snapshot->outlines = OutlinesOf(maps.id, {camera_.width, camera_.height});
  }
  snapshot->report = std::move(report);
  return snapshot;
}

}  // namespace plumbline
