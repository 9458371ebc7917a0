// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "engine/base/timer.h"
#include "engine/dataset/growing_sequence.h"
#include "engine/nodes/frame_answers.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/own_pose_message.h"

namespace plumbline {
namespace {

/// More than the windows of all who ask, so that a frame is read once.
constexpr std::size_t kFramesKept = 24;

struct RecordedEdges {
  std::shared_ptr<SendablePixels> probability, angle;
};

/// Answers of the player. Of one thread.
class Player {
 public:
  Player(const NodeSetup& setup, NodeLink& link, std::shared_ptr<const Sequence> sequence)
      : setup_(setup),
        link_(link),
        sequence_(std::move(sequence)),
        growing_(GrowingRecordingOf(*sequence_)),
        images_read_(link.AddStream("images")) {}

  Result<wire::Reply> Answer(const wire::Request& request) {
    wire::Reply reply;
    switch (request.what_case()) {
      case wire::Request::kSequence:
        *reply.mutable_sequence() = SequenceToWire(*sequence_);
        reply.mutable_sequence()->set_grows(growing_ != nullptr);
        return reply;
      case wire::Request::kGrowth:
        return Growth(request);
      case wire::Request::kImage:
        return Image(request);
      case wire::Request::kImu:
        return Imu(request);
      case wire::Request::kEdges:
        return Edges(request);
      case wire::Request::kProposals:
        return Proposals(request);
      default:
        return DoesNotAnswer(request, setup_.node);
    }
  }

 private:
  Status CheckFrame(int frame) const {
    if (frame >= 0 && frame < sequence_->num_frames()) return {};
    return Error{ErrorCode::kInvalidInput, "frame " + std::to_string(frame) +
                                               " was asked for; the sequence has " +
                                               std::to_string(sequence_->num_frames())};
  }

  Result<wire::Reply> Growth(const wire::Request& request) const {
    Result<wire::Growth> growth = GrowthToWire(*sequence_, growing_, request.growth());
    if (!growth.ok()) return growth.error();
    wire::Reply reply;
    *reply.mutable_growth() = std::move(growth).value();
    return reply;
  }

  Result<wire::Reply> Image(const wire::Request& request) {
    const int frame = request.image().frame();
    if (Status status = CheckFrame(frame); !status.ok()) return status.error();
    const bool raw = request.image().raw();
    auto& kept = raw ? raw_images_ : images_;
    const auto pixels = kept.Of(frame, [&]() -> Result<std::shared_ptr<SendablePixels>> {
      const Stopwatch watch;
      Result<cv::Mat> read = raw ? sequence_->ReadRawImage(frame) : ReadImage(frame);
      if (!read.ok()) return read.error();
      if (read->depth() != CV_8U)
        return Error{ErrorCode::kUnsupported, "images of more than 8 bits are not played"};
      images_read_.Count(watch.Milliseconds());
      link_.SetState("read frame " + std::to_string(frame) + " of " +
                     std::to_string(sequence_->num_frames()));
      return std::make_shared<SendablePixels>(*read, link_.pixels());
    });
    if (!pixels.ok()) return pixels.error();
    Result<wire::Pixels> sent = (*pixels)->For(request);
    if (!sent.ok()) return sent.error();
    wire::Reply reply;
    reply.mutable_image()->set_frame(frame);
    reply.mutable_image()->set_stamp_ns(sequence_->stamp_ns(frame));
    *reply.mutable_image()->mutable_pixels() = std::move(sent).value();
    return reply;
  }

  Result<cv::Mat> ReadImage(int frame) const {
    Result<Frame> read = sequence_->ReadFrame(frame);
    if (!read.ok()) return read.error();
    return std::move(read->image);
  }

  Result<wire::Reply> Imu(const wire::Request& request) {
    if (!imu_ || growing_ != nullptr) {
      Result<ImuRecording> read = sequence_->ReadImu();
      if (!read.ok()) return read.error();
      imu_ = std::move(read).value();
    }
    wire::Reply reply;
    *reply.mutable_imu() = ImuToWire(sequence_->calibration(), *imu_, request.imu().from());
    return reply;
  }

  Result<wire::Reply> Edges(const wire::Request& request) {
    const int frame = request.edges().frame();
    if (Status status = CheckFrame(frame); !status.ok()) return status.error();
    const auto kept = edges_.Of(frame, [&]() -> Result<std::shared_ptr<RecordedEdges>> {
      Result<std::optional<EdgeMap>> read = sequence_->ReadEdges(frame);
      if (!read.ok()) return read.error();
      if (!read->has_value())
        return Error{ErrorCode::kNotFound,
                     "no edges were recorded with frame " + std::to_string(frame)};
      return std::make_shared<RecordedEdges>(
          RecordedEdges{std::make_shared<SendablePixels>((*read)->probability, link_.pixels()),
                        std::make_shared<SendablePixels>((*read)->angle, link_.pixels())});
    });
    if (!kept.ok()) return kept.error();
    return EdgesReply(request, *(*kept)->probability, *(*kept)->angle);
  }

  Result<wire::Reply> Proposals(const wire::Request& request) {
    const int frame = request.proposals().frame();
    if (Status status = CheckFrame(frame); !status.ok()) return status.error();
    const auto read = sequence_->ReadProposals(frame);
    if (!read.ok()) return read.error();
    if (!read->has_value())
      return Error{ErrorCode::kNotFound,
                   "no boxes were recorded with frame " + std::to_string(frame)};
    wire::Reply reply;
    *reply.mutable_proposals() = ProposalsToWire(**read);
    reply.mutable_proposals()->set_frame(frame);
    return reply;
  }

  const NodeSetup& setup_;
  NodeLink& link_;
  const std::shared_ptr<const Sequence> sequence_;
  const GrowingRecording* const growing_;  ///< Null: all is recorded.
  StreamMeter& images_read_;
  FrameAnswers<SendablePixels> images_{kFramesKept}, raw_images_{kFramesKept};
  FrameAnswers<RecordedEdges> edges_{kFramesKept};
  std::optional<ImuRecording> imu_;  ///< Once it was asked for.
};

}  // namespace

Result<wire::Reply> EdgesReply(const wire::Request& request, SendablePixels& probability,
                               SendablePixels& angle) {
  Result<wire::Pixels> probability_sent = probability.For(request);
  if (!probability_sent.ok()) return probability_sent.error();
  Result<wire::Pixels> angle_sent = angle.For(request);
  if (!angle_sent.ok()) return angle_sent.error();
  wire::Reply reply;
  wire::Edges& edges = *reply.mutable_edges();
  edges.set_frame(request.edges().frame());
  *edges.mutable_probability() = std::move(probability_sent).value();
  *edges.mutable_angle() = std::move(angle_sent).value();
  return reply;
}

FramesAhead FramesOf(const RunRecipe& recipe) {
  FramesAhead ahead;
  ahead.begin = recipe.frames.begin;
  ahead.end = recipe.frames.end.value_or(std::numeric_limits<int>::max() / 2);
  ahead.step = recipe.frames.step;
  if (recipe.live_speed) ahead.window = 1;  // what comes next has not come yet
  return ahead;
}

Status RunPlayerNode(const NodeSetup& setup) {
  const RunRecipe& recipe = *setup.plan.recipe;
  SequenceOptions options;
  if (recipe.poses.source == PoseSource::kTrajectory) options.poses = recipe.poses.file;
  Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  // A recording of this graph's own is followed also when a player that was started again comes to
  // its end.
  const bool follow = setup.plan.FirstOf(NodeKind::kCamera) != nullptr ||
                      (recipe.live_speed && recipe.poses.source == PoseSource::kVio &&
                       IsBeingRecorded(recipe.sequence));
  if (follow) (*link)->SetState("waiting for the first images of the recording");
  Result<std::shared_ptr<const Sequence>> sequence =
      follow ? FollowRecording(recipe.sequence, setup.work)
             : OpenSequence(recipe.sequence, options);
  if (!sequence.ok() && setup.work.stop.stop_requested()) return {};
  if (!sequence.ok()) return sequence.error();
  Player player(setup, **link, *sequence);
  (*link)->SetState("ready");
  (*link)->Serve(setup.work.stop,
                 [&](const wire::Request& request) { return player.Answer(request); });
  return {};
}

Status RunNode(const NodeSetup& setup) {
  switch (setup.node.kind) {
    case NodeKind::kPlayer:
      return RunPlayerNode(setup);
    case NodeKind::kEdges:
      return RunEdgesNode(setup);
    case NodeKind::kDetector:
      return RunDetectorNode(setup);
    case NodeKind::kVio:
      return RunVioNode(setup);
    case NodeKind::kCamera:
      return RunCameraNode(setup);
    case NodeKind::kImu:
      return RunImuNode(setup);
    case NodeKind::kMapper:
      return RunMapperNode(setup);
    case NodeKind::kRecorder:
      return RunRecorderNode(setup);
    default:
      return Error{ErrorCode::kInvalidInput, "the node '" + setup.node.name +
                                                 "' is another program's; start its \"command\""};
  }
}

}  // namespace plumbline
