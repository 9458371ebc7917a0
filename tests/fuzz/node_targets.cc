// SPDX-License-Identifier: Apache-2.0
// What processes send to one another, the graphs and keys that they find one another by.
#include <array>
#include <string>

#include "engine/base/json_text.h"
#include "engine/nodes/graph_plan.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/nodes/report_message.h"
#include "engine/recording/run_header.h"
#include "engine/transport/curve_keys.h"
#include "engine/transport/message_checks.h"
#include "engine/transport/wire_values.h"
#include "engine/vio/landmark_loops.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

constexpr int kModels = 64;

Status NodeRequest(std::string_view input) {
  const ParsedRequest parsed = ParseRequest(input);
  if (parsed.fault == MessageFault::kNone) return {};
  return InvalidInput(parsed.sentence);
}

Status NodeReply(std::string_view input) {
  const auto reply = ParseReply(input);
  if (!reply.ok()) return reply.error();
  switch (reply->what_case()) {
    case wire::Reply::kRefusal: {
      const Error error = ErrorOf(reply->refusal());
      return RefusalOf(error).has_refusal() ? Status() : Status(error);
    }
    case wire::Reply::kSequence: {
      const auto sequence = RemoteSequence::FromWire(reply->sequence(), nullptr, {}, {});
      if (!sequence.ok()) return sequence.error();
      (void)SequenceToWire(**sequence);
      return Status();
    }
    case wire::Reply::kImage:
      return StatusOf(PixelsFromWire(reply->image().pixels()));
    case wire::Reply::kEdges:
      return StatusOf(EdgesFromWire(reply->edges()));
    case wire::Reply::kProposals:
      return StatusOf(ProposalsFromWire(reply->proposals()));
    case wire::Reply::kHeader:
      return StatusOf(HeaderFromJson(ParseJson(reply->header().json())));
    case wire::Reply::kReport:
      return StatusOf(ReportFromWire(reply->report(), kModels));
    case wire::Reply::kResume:
      if (const auto options = ParseJson(reply->resume().options()); options.is_object())
        (void)KnownOptions(options);  // as the mapper does
      for (const wire::Landmarks& row : reply->resume().landmarks())
        (void)LandmarkEdgesFromText(row.edges());
      return StatusOf(ReportFromWire(reply->resume().last(), kModels));
    case wire::Reply::kImu: {
      Calibration calibration;
      std::vector<ImuSample> samples;
      return StatusOf(AddImuFromWire(reply->imu(), calibration, samples));
    }
    case wire::Reply::kOwnPoses: {
      OwnPoses by_now, poses;
      (void)AddOwnPosesByNow(reply->own_poses(), 0, by_now);
      return StatusOf(AddOwnPosesFromWire(reply->own_poses(), poses));
    }
    case wire::Reply::kGrowth: {
      std::vector<ImuSample> samples;
      return AddGrowthFromWire(reply->growth(), samples);
    }
    case wire::Reply::kRecorded: {
      const auto header = HeaderFromJson(ParseJson(reply->recorded().header()));
      if (!header.ok()) return header.error();
      for (const wire::RecordedFrame& frame : reply->recorded().frames()) {
        if (auto report = ReportFromWire(frame.report(), kModels); !report.ok())
          return report.error();
        (void)PixelsFromWire(frame.thumbnail());
      }
      return Status();
    }
    case wire::Reply::kMap:
      return StatusOf(ReportFromWire(reply->map().report(), kModels));
    default:
      return {};
  }
}

Status Graph(std::string_view input) {
  auto plan = ReadGraph(FileOf("graph.json", input));
  if (!plan.ok()) return plan.error();
  (void)ResolveGraph("graph", *plan);
  return StatusOf(GraphFromJson(GraphToJson(*plan)));  // what is written is read again
}

Status Keys(std::string_view input) {
  const auto folder = FolderOf(input);
  std::error_code ignored;
  std::filesystem::permissions(
      folder / "node.secret",
      std::filesystem::perms::owner_read | std::filesystem::perms::owner_write, ignored);
  return StatusOf(ReadCurveKeys(folder, "node"));
}

constexpr std::array kNodeTargets = {Target{"node_request", NodeRequest},
                                     Target{"node_reply", NodeReply}, Target{"graph", Graph},
                                     Target{"keys", Keys}};

}  // namespace

std::span<const Target> NodeTargets() { return kNodeTargets; }

}  // namespace plumbline::fuzz
