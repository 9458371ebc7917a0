// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "engine/base/timer.h"
#include "engine/base/worker.h"
#include "engine/nodes/frame_answers.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"
#include "engine/vision/edge_network.h"
#include "engine/vision/network.h"
#include "engine/vision/two_stage_detector.h"

namespace plumbline {
namespace {

/// Edges found, and boxes of frames that the mapper may still want scores of.
constexpr std::size_t kEdgesKept = 12, kDetectionsKept = 24;

/// A node that asks a player for images and makes something of each.
struct ImageNode {
  std::unique_ptr<NodeLink> link;
  std::shared_ptr<const RemoteSequence> sequence;
};

Result<ImageNode> OpenImageNode(const NodeSetup& setup) {
  ImageNode node;
  Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  node.link = std::move(link).value();
  node.link->SetState("waiting for '" + setup.node.images + "'");
  const Result<NodeClient*> player = node.link->Ask(setup.node.images);
  if (!player.ok()) return player.error();
  auto sequence = RemoteSequence::Open(**player, FramesOf(*setup.plan.recipe), setup.work.stop);
  if (!sequence.ok()) return sequence.error();
  node.sequence = std::move(sequence).value();
  return node;
}

/// As a recipe has it.
template <typename Choice>
std::string ChoiceText(const Choice& choice, std::string_view source) {
  nlohmann::json json = {{"source", source}};
  if (!choice.file.empty()) json["file"] = choice.file.string();
  if (!choice.hash.empty()) json["hash"] = choice.hash;
  return json.dump();
}

template <typename Source>
Status CompleteFile(InputChoice<Source>& choice) {
  if (choice.file.empty()) return {};
  choice.file = std::filesystem::absolute(choice.file);
  Result<std::string> hash = HashOfNetwork(choice.file);
  if (!hash.ok()) return hash.error();
  choice.hash = std::move(hash).value();
  return {};
}

struct FoundEdges {
  std::shared_ptr<SendablePixels> probability, angle;
};

bool IsStopped(const Status& status) {
  return !status.ok() && status.error().code == ErrorCode::kCancelled;
}

Status ServeEdges(const NodeSetup& setup) {
  Result<ImageNode> opened = OpenImageNode(setup);
  if (!opened.ok()) return opened.error();
  NodeLink& link = *opened->link;
  const RemoteSequence& sequence = *opened->sequence;
  EdgeChoice choice = setup.plan.recipe->edges.value_or(DefaultEdges(sequence));
  Result<std::unique_ptr<EdgeDetector>> detector =
      CreateEdgeDetector(ToText(choice), opened->sequence);
  if (!detector.ok()) return detector.error();
  if (Status status = CompleteFile(choice); !status.ok()) return status;
  if (choice.source == EdgeSource::kBuiltin || choice.source == EdgeSource::kBuiltinHalf)
    choice.hash = HashOfBuiltinEdges(choice.source == EdgeSource::kBuiltinHalf);
  link.SetChoice(
      ChoiceText(choice, EnumNames<EdgeSource>::names[static_cast<std::size_t>(choice.source)]));
  StreamMeter& found = link.AddStream("edges");
  FrameAnswers<FoundEdges> answers(kEdgesKept);
  link.SetState("ready");
  link.Serve(setup.work.stop, [&](const wire::Request& request) -> Result<wire::Reply> {
    if (!request.has_edges()) return DoesNotAnswer(request, setup.node);
    const int frame = request.edges().frame();
    if (!sequence.AwaitFrame(frame, setup.work.stop))
      return InvalidInput("there is no frame " + std::to_string(frame));
    const auto kept = answers.Of(frame, [&]() -> Result<std::shared_ptr<FoundEdges>> {
      const Stopwatch watch;
      const Result<Frame> image = sequence.ReadFrame(frame);
      if (!image.ok()) return image.error();
      const Result<EdgeMap> edges = (*detector)->Detect(*image);
      if (!edges.ok()) return edges.error();
      found.Count(watch.Milliseconds());
      link.SetState("found edges of frame " + std::to_string(frame));
      return std::make_shared<FoundEdges>(
          FoundEdges{std::make_shared<SendablePixels>(edges->probability, link.pixels()),
                     std::make_shared<SendablePixels>(edges->angle, link.pixels())});
    });
    if (!kept.ok()) return kept.error();
    return EdgesReply(request, *(*kept)->probability, *(*kept)->angle);
  });
  return {};
}

/// Answers of the detector. Objects are found in one thread; boxes of a frame that was looked at
/// are scored in that of the requests, so that the mapper does not wait while its next frames are
/// looked at.
class DetectorProcess {
 public:
  DetectorProcess(const NodeSetup& setup, ImageNode node, std::unique_ptr<Detector> detector,
                  bool scores_boxes)
      : setup_(setup),
        node_(std::move(node)),
        detector_(std::move(detector)),
        scores_boxes_(scores_boxes),
        found_(node_.link->AddStream("proposals")),
        scored_(node_.link->AddStream("scores")) {}

  void Serve(const std::stop_token& stop) {
    Worker detecting;
    node_.link->SetState("ready");
    while (auto asked = node_.link->server().Next(stop)) {
      const wire::Request& request = asked->request;
      if (request.has_scores()) {
        if (const auto known = answers_.Known(request.scores().frame()); known != nullptr) {
          node_.link->Answer(*asked, Scores(request, *known));
          continue;
        }
      }
      detecting.Do([this, stop, waiting = std::move(*asked)] {
        if (!stop.stop_requested()) node_.link->Answer(waiting, Detected(waiting.request));
      });
    }
  }

 private:
  using Detections = FrameDetections;

  Result<wire::Reply> Detected(const wire::Request& request) {
    if (!request.has_proposals() && !request.has_scores())
      return DoesNotAnswer(request, setup_.node);
    const int frame = request.has_scores() ? request.scores().frame() : request.proposals().frame();
    if (!node_.sequence->AwaitFrame(frame, setup_.work.stop))
      return InvalidInput("there is no frame " + std::to_string(frame));
    const auto detections = answers_.Of(frame, [&] { return Look(frame); });
    if (!detections.ok()) return detections.error();
    if (request.has_scores()) return Scores(request, **detections);
    wire::Reply reply;
    *reply.mutable_proposals() = ProposalsToWire((*detections)->proposals());
    reply.mutable_proposals()->set_frame(frame);
    reply.mutable_proposals()->set_scores_boxes(scores_boxes_);
    return reply;
  }

  Result<std::shared_ptr<const Detections>> Look(int frame) {
    const Stopwatch watch;
    Frame image;
    image.index = frame;
    if (scores_boxes_) {  // recorded boxes need no image
      Result<Frame> read = node_.sequence->ReadFrame(frame);
      if (!read.ok()) return read.error();
      image = std::move(read).value();
    }
    Result<std::unique_ptr<const Detections>> detections = detector_->Detect(image);
    if (!detections.ok()) return detections.error();
    found_.Count(watch.Milliseconds());
    node_.link->SetState("found objects in frame " + std::to_string(frame));
    return std::shared_ptr<const Detections>(std::move(detections).value());
  }

  Result<wire::Reply> Scores(const wire::Request& request, const Detections& detections) {
    const Stopwatch watch;
    const auto& edges = request.scores().boxes();
    if (edges.size() % 4 != 0) return InvalidInput("a box has four numbers");
    std::vector<Box2> boxes;
    for (int i = 0; i < edges.size(); i += 4)
      boxes.push_back({edges[i], edges[i + 1], edges[i + 2], edges[i + 3]});
    std::vector<float> scores(boxes.size());
    detections.ScoreBoxes(request.scores().category(), boxes, scores);
    wire::Reply reply;
    reply.mutable_scores()->mutable_scores()->Add(scores.begin(), scores.end());
    scored_.Count(watch.Milliseconds());
    return reply;
  }

  const NodeSetup& setup_;
  const ImageNode node_;
  const std::unique_ptr<Detector> detector_;
  const bool scores_boxes_;
  StreamMeter& found_;
  StreamMeter& scored_;
  FrameAnswers<const Detections> answers_{kDetectionsKept};
};

Status ServeDetections(const NodeSetup& setup) {
  Result<ImageNode> opened = OpenImageNode(setup);
  if (!opened.ok()) return opened.error();
  DetectorChoice choice = setup.plan.recipe->detector.value_or(DefaultDetector(*opened->sequence));
  Result<std::unique_ptr<Detector>> detector = CreateDetector(ToText(choice), opened->sequence);
  if (!detector.ok()) return detector.error();
  if (Status status = CompleteFile(choice); !status.ok()) return status;
  if (choice.source == DetectorSource::kBuiltin) choice.hash = HashOfBuiltinDetector();
  opened->link->SetChoice(ChoiceText(
      choice, EnumNames<DetectorSource>::names[static_cast<std::size_t>(choice.source)]));
  DetectorProcess process(setup, std::move(opened).value(), std::move(detector).value(),
                          choice.source != DetectorSource::kDataset);
  process.Serve(setup.work.stop);
  return {};
}

}  // namespace

Status RunEdgesNode(const NodeSetup& setup) {
  Status status = ServeEdges(setup);
  return IsStopped(status) ? Status() : status;
}

Status RunDetectorNode(const NodeSetup& setup) {
  Status status = ServeDetections(setup);
  return IsStopped(status) ? Status() : status;
}

}  // namespace plumbline
