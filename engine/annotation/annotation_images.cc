// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_images.h"

#include <optional>
#include <utility>

#include "engine/annotation/pose_exchange.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {
namespace {

Result<AnnotationImage> LoadImage(const Sequence& sequence, const AnnotationDocument& document,
                                  int index, EdgeDetector& detector) {
  const std::optional<Eigen::Isometry3d> scan_from_cam = ScanFromCam(document, sequence, index);
  if (!scan_from_cam) {
    return Error{ErrorCode::kNotFound, "frame " + std::to_string(index) + " has no camera pose"};
  }
  Result<Frame> frame = sequence.ReadFrame(index);
  if (!frame) return frame.error();
  Result<EdgeMap> edges = detector.Detect(*frame);
  if (!edges) return edges.error();
  return AnnotationImage{index, frame->image, std::move(*edges), *scan_from_cam};
}

}  // namespace

Result<std::shared_ptr<const AnnotationImages>> AnnotationImages::Load(
    std::shared_ptr<const Sequence> sequence, const AnnotationDocument& document,
    const std::vector<int>& frames, const std::string& edges, const WorkContext& work) {
  std::string choice = edges;
  if (choice.empty()) choice = sequence->has_edges() ? "dataset" : "gradient";
  auto detector = CreateEdgeDetector(choice, sequence);
  if (!detector) return detector.error();
  const std::shared_ptr<AnnotationImages> result(new AnnotationImages);
  result->camera_ = sequence->camera();
  for (const int index : frames) {
    if (work.stop.stop_requested()) {
      return Error{ErrorCode::kCancelled, "loading the images was cancelled"};
    }
    Result<AnnotationImage> image = LoadImage(*sequence, document, index, **detector);
    if (image) {
      result->images_.push_back(std::move(*image));
    } else {
      result->warnings_.push_back(image.error().message);
    }
    work.report(
        {"images", static_cast<int>(result->images_.size()), static_cast<int>(frames.size())});
  }
  if (result->images_.empty()) {
    return Error{ErrorCode::kNotFound,
                 "none of the chosen frames of '" + sequence->path().string() + "' can be used" +
                     (result->warnings_.empty() ? "" : ": " + result->warnings_.front())};
  }
  return std::shared_ptr<const AnnotationImages>(result);
}

std::shared_ptr<const AnnotationImages> AnnotationImages::FromImages(
    const PinholeCamera& camera, std::vector<AnnotationImage> images) {
  const std::shared_ptr<AnnotationImages> result(new AnnotationImages);
  result->camera_ = camera;
  result->images_ = std::move(images);
  return result;
}

HeldOutImages HoldOutEveryThird(const std::shared_ptr<const AnnotationImages>& images) {
  if (images == nullptr || images->images().size() < 3) return {images, nullptr};
  std::vector<AnnotationImage> used, held_out;
  for (std::size_t i = 0; i < images->images().size(); ++i) {
    (i % 3 == 2 ? held_out : used).push_back(images->images()[i]);
  }
  return {AnnotationImages::FromImages(images->camera(), std::move(used)),
          AnnotationImages::FromImages(images->camera(), std::move(held_out))};
}

}  // namespace plumbline
