// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/remote_detectors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/transport/wire_values.h"

namespace plumbline {
namespace {

class RemoteEdgeDetector : public EdgeDetector {
 public:
  RemoteEdgeDetector(NodeClient& node, const FramesAhead& ahead, std::stop_token stop)
      : requests_(node, ahead, EdgesRequestOf), stop_(std::move(stop)) {}

  Result<EdgeMap> Detect(const Frame& frame) override {
    return TakePixels(
        requests_, frame.index, stop_, [&](const wire::Reply& reply) -> Result<EdgeMap> {
          Result<EdgeMap> edges = EdgesFromWire(reply.edges());
          if (edges.ok() && edges->probability.size() != frame.image.size())
            return Error{ErrorCode::kCorrupt, "a node sent edges of another size than the image"};
          return edges;
        });
  }

 private:
  RequestsAhead requests_;
  const std::stop_token stop_;
};

class RemoteDetections : public FrameDetections {
 public:
  RemoteDetections(NodeClient& node, int frame, std::vector<Detection> proposals,
                   std::stop_token stop)
      : node_(node), frame_(frame), proposals_(std::move(proposals)), stop_(std::move(stop)) {}

  std::span<const Detection> proposals() const override { return proposals_; }

  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    PLB_CHECK(boxes.size() == scores.size());
    if (boxes.empty()) return;
    wire::Request request;
    wire::ScoresRequest& asked = *request.mutable_scores();
    asked.set_frame(frame_);
    asked.set_category(std::string(category));
    asked.mutable_boxes()->Reserve(static_cast<int>(boxes.size()) * 4);
    for (const Box2& box : boxes)
      for (const float edge : {box.x0, box.y0, box.x1, box.y1}) asked.add_boxes(edge);
    const Result<SharedReply> reply = node_.AskAndWait(std::move(request), stop_);
    if (!reply.ok() && reply.error().code == ErrorCode::kCancelled) throw StoppedWaiting();
    PLB_CHECK(reply.ok()) << reply.error().message;
    const auto& got = (*reply)->scores().scores();
    const bool fits = std::ssize(scores) == got.size() &&
                      std::all_of(got.begin(), got.end(), [](float s) { return s >= 0 && s <= 1; });
    PLB_CHECK(fits) << "the detector sent other than a score in [0, 1] for each box";
    std::copy(got.begin(), got.end(), scores.begin());
  }

 private:
  NodeClient& node_;
  const int frame_;
  const std::vector<Detection> proposals_;
  const std::stop_token stop_;
};

class RemoteDetector : public Detector {
 public:
  RemoteDetector(NodeClient& node, const FramesAhead& ahead, std::stop_token stop)
      : node_(node), requests_(node, ahead, ProposalsRequestOf), stop_(std::move(stop)) {}

  Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) override {
    const Result<SharedReply> reply = requests_.Get(frame.index, stop_);
    if (!reply.ok()) return reply.error();
    Result<std::vector<Detection>> proposals = ProposalsFromWire((*reply)->proposals());
    if (!proposals.ok()) return proposals.error();
    if (!(*reply)->proposals().scores_boxes())
      return DetectionsFromProposals(std::move(proposals).value());
    return std::unique_ptr<const FrameDetections>(std::make_unique<RemoteDetections>(
        node_, frame.index, std::move(proposals).value(), stop_));
  }

 private:
  NodeClient& node_;
  RequestsAhead requests_;
  const std::stop_token stop_;
};

}  // namespace

std::unique_ptr<EdgeDetector> MakeRemoteEdgeDetector(NodeClient& node, const FramesAhead& ahead,
                                                     std::stop_token stop) {
  return std::make_unique<RemoteEdgeDetector>(node, ahead, std::move(stop));
}

std::unique_ptr<Detector> MakeRemoteDetector(NodeClient& node, const FramesAhead& ahead,
                                             std::stop_token stop) {
  return std::make_unique<RemoteDetector>(node, ahead, std::move(stop));
}

}  // namespace plumbline
