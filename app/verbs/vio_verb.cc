// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/verbs/argument_checks.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/base/timer.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/tracks_file.h"
#include "engine/dataset/trajectory_writer.h"
#include "engine/geometry/angles.h"
#include "engine/models/mesh_file.h"
#include "engine/snapshot/lens_entries.h"
#include "engine/vio/loop_closer.h"
#include "engine/vio/own_poses.h"
#include "engine/vio/vio_run.h"

namespace plumbline {
namespace {

struct VioArguments {
  std::string sequence, tracks, out, init, json, frame = "body";
  std::vector<std::string> settings, tracker_settings, loop_settings;
  bool no_loops = false;
  double drop_tracks = 0;
  std::uint64_t seed = 0;
  VioOptions options;
  TrackerOptions tracker;
  LoopOptions loops;
};

/// What a recording gave, and what coming back to known places corrected.
struct ClosedRun {
  VioRun run;
  std::vector<std::int64_t> point_stamps_ns;  ///< Of the image after which each point was finished.
  LoopReport loops;
  TrajectoryCorrection correction;
};

Status ParseSettings(VioArguments& arguments) {
  for (const std::string& setting : arguments.settings) {
    if (Status status = SetOption(setting, arguments.options); !status.ok()) return status;
  }
  for (const std::string& setting : arguments.tracker_settings) {
    if (Status status = SetOption(setting, arguments.tracker); !status.ok()) return status;
  }
  for (const std::string& setting : arguments.loop_settings) {
    if (Status status = SetOption(setting, arguments.loops); !status.ok()) return status;
  }
  return {};
}

/// The first state that is not before the first image.
Result<ReferenceState> StartOf(const std::string& file, std::int64_t first_image_ns) {
  const Result<ReferenceStates> states = ReadReferenceStates(file);
  if (!states.ok()) return states.error();
  Warn(states->warnings);
  for (const ReferenceState& state : states->states) {
    if (state.stamp_ns >= first_image_ns) return state;
  }
  return Error{ErrorCode::kInvalidInput,
               "'" + file + "' has no state after the first image of the sequence"};
}

std::vector<WrittenPose> PosesOf(const VioRun& run, bool of_cam) {
  std::vector<WrittenPose> poses;
  for (const VioReport& report : run.reports) {
    if (report.phase != VioPhase::kTracking) continue;
    WrittenPose pose{report.stamp_ns, report.world_from_body, report.covariance};
    if (of_cam) {
      // The camera hangs on the body by an arm that turns with it.
      pose.world_from_sensor = report.world_from_body * report.body_from_cam;
      pose.covariance = MovedBy(
          report.world_from_body.linear() * report.body_from_cam.translation(), report.covariance);
    }
    poses.push_back(pose);
  }
  return poses;
}

/// Moves poses, their covariances and points to where closed loops have them.
void Correct(ClosedRun& closed) {
  if (closed.correction.empty()) return;
  for (VioReport& report : closed.run.reports) {
    const Eigen::Isometry3d move =
        closed.correction.At(report.stamp_ns, report.world_from_body.translation());
    report.world_from_body = move * report.world_from_body;
    report.velocity_in_world = move.linear() * report.velocity_in_world;
    report.covariance = closed.correction.CovarianceAt(report.stamp_ns, report.covariance);
  }
  for (std::size_t i = 0; i < closed.point_stamps_ns.size(); ++i) {
    Eigen::Vector3d& point = closed.run.points[i].point_in_world;
    point = closed.correction.At(closed.point_stamps_ns[i], point) * point;
  }
}

Status WriteOutputs(const VioArguments& arguments, const ClosedRun& closed) {
  const VioRun& run = closed.run;
  std::string frames = "world_from_" + arguments.frame;
  if (!closed.correction.empty())
    frames += ", corrected where closed loops showed drift: not causal";
  const std::vector<WrittenPose> poses = PosesOf(run, arguments.frame == "cam");
  if (Status status = WriteTrajectory(arguments.out, frames, poses); !status.ok()) return status;
  if (Status status = WriteCovariances(CovarianceFileOf(arguments.out), frames, poses);
      !status.ok())
    return status;
  TriangleMesh points;
  for (const MapPoint& point : run.points)
    points.vertices.push_back(point.point_in_world.cast<float>());
  if (points.vertices.empty()) return {};
  return WritePly(std::filesystem::path(arguments.out).replace_extension(".points.ply"), points);
}

/// What is said of a run, for people and machines.
struct VioSummary {
  int images = 0, tracked = 0, stretches = 0, accepted = 0, rejected = 0;
  double start_s = 0, propagate_ms = 0, update_ms = 0, tracking_ms = 0, nis = 0, path_m = 0;
  std::vector<std::string> messages;  ///< By kind, with the time of the first.
  const VioReport* last = nullptr;
};

VioSummary Summarise(const VioRun& run) {
  VioSummary summary;
  summary.images = run.images;
  double nis = 0, dof = 0;
  for (const VioReport& report : run.reports) {
    const double at = static_cast<double>(report.stamp_ns - run.reports.front().stamp_ns) * 1e-9;
    if (!report.message.empty()) {
      const std::string kind = report.message.substr(0, report.message.find_first_of("0123456789"));
      const bool known = std::any_of(
          summary.messages.begin(), summary.messages.end(),
          [&](const std::string& told) { return told.find(kind) != std::string::npos; });
      char time[32];
      std::snprintf(time, sizeof(time), "%.1f s: ", at);
      if (!known) summary.messages.push_back(time + report.message);
    }
    if (report.phase != VioPhase::kTracking) continue;
    if (summary.last == nullptr) {
      summary.start_s = at;
    } else {
      summary.path_m +=
          (report.world_from_body.translation() - summary.last->world_from_body.translation())
              .norm();
    }
    ++summary.tracked;
    summary.stretches = report.stretch;
    summary.accepted += report.step.accepted;
    summary.rejected += report.step.rejected;
    summary.propagate_ms += report.step.propagate_ms;
    summary.update_ms += report.step.update_ms;
    nis += report.step.nis;
    dof += report.step.nis_dof;
    summary.last = &report;
  }
  if (summary.tracked > 0) {
    summary.propagate_ms /= summary.tracked;
    summary.update_ms /= summary.tracked;
  }
  if (run.images > 0) summary.tracking_ms = run.tracking_ms / run.images;
  if (dof > 0) summary.nis = nis / dof;
  return summary;
}

std::vector<double> Listed(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json SummaryToJson(const VioSummary& s, const LoopReport& loops, double seconds) {
  nlohmann::json pose = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      pose[row][column] = s.last->body_from_cam.matrix()(row, column);
  }
  nlohmann::json lens = nlohmann::json::object();
  for (int row = 0; row < kLensSize; ++row) {
    if (s.last->lens_spread[row] <= 0) continue;
    lens[kLensEntries[static_cast<std::size_t>(row)].key] = {{"value", s.last->lens[row]},
                                                             {"std", s.last->lens_spread[row]}};
  }
  return {{"images", s.images},
          {"tracked", s.tracked},
          {"stretches", s.stretches},
          {"start_s", s.start_s},
          {"seconds", seconds},
          {"path_m", s.path_m},
          {"accepted", s.accepted},
          {"rejected", s.rejected},
          {"nis_per_dof", s.nis},
          {"messages", s.messages},
          {"timings_ms",
           {{"tracking", s.tracking_ms}, {"propagate", s.propagate_ms}, {"update", s.update_ms}}},
          {"gyro_bias_rad_s", Listed(s.last->gyro_bias)},
          {"accel_bias_m_s2", Listed(s.last->accel_bias)},
          {"body_from_cam", pose},
          {"time_offset_s", s.last->time_offset_s},
          {"lens", lens},
          {"loops", ToJson(loops)}};
}

void PrintLoops(const LoopReport& loops, bool asked) {
  if (!asked) {
    std::printf("loops: not looked for\n");
    return;
  }
  if (!loops.has_images) {
    std::printf(
        "loops: none closed; places are known again by images, and these are tracks alone\n");
    return;
  }
  const int given_up = static_cast<int>(loops.closures.size()) - loops.believed();
  std::printf(
      "loops: %d closed in %d corrections, %d given up again, %d farther off than drift can "
      "be, %d unconfirmed\n",
      loops.believed(), loops.epochs, given_up, loops.turned_away, loops.unconfirmed);
  if (!loops.closures.empty()) {
    std::printf(
        "       they move poses by up to %.3f m and %.2f deg, the last one by %.3f m and "
        "%.2f deg: not causal\n",
        loops.largest_move_m, loops.largest_turn_deg, loops.last_move_m, loops.last_turn_deg);
  }
  std::printf("       %d key frames, %.1f ms and %.0f kB each\n", loops.key_frames,
              loops.ms / std::max(1, loops.key_frames),
              loops.bytes / 1e3 / std::max(1, loops.key_frames));
}

void PrintSummary(const VioSummary& s, const LoopReport& loops, const VioArguments& arguments) {
  const VioReport& last = *s.last;
  const auto spread = [&](int row) { return last.spread.segment<3>(row).norm(); };
  std::printf("%d of %d images have a pose, from %.2f s on; path %.2f m; %d %s\n", s.tracked,
              s.images, s.start_s, s.path_m, s.stretches,
              s.stretches == 1 ? "stretch" : "stretches");
  std::printf("ms an image: tracking %.2f, propagation %.2f, update %.2f\n", s.tracking_ms,
              s.propagate_ms, s.update_ms);
  std::printf("measurements used %d, rejected %d; innovations %.2f of what they should be\n",
              s.accepted, s.rejected, s.nis);
  std::printf("gyro bias          %9.5f %9.5f %9.5f rad/s  +- %.5f\n", last.gyro_bias.x(),
              last.gyro_bias.y(), last.gyro_bias.z(), spread(0));
  std::printf("accelerometer bias %9.5f %9.5f %9.5f m/s^2  +- %.5f\n", last.accel_bias.x(),
              last.accel_bias.y(), last.accel_bias.z(), spread(3));
  const Eigen::AngleAxisd turn(last.body_from_cam.linear());
  const Eigen::Vector3d rotation = turn.angle() * kDegPerRad * turn.axis();
  const Eigen::Vector3d arm = last.body_from_cam.translation();
  std::printf("camera on body     %9.3f %9.3f %9.3f deg    +- %.3f (rotation vector)\n",
              rotation.x(), rotation.y(), rotation.z(), kDegPerRad * spread(6));
  std::printf("                   %9.4f %9.4f %9.4f m      +- %.4f\n", arm.x(), arm.y(), arm.z(),
              spread(9));
  std::printf("time offset        %9.3f ms  +- %.3f\n", 1e3 * last.time_offset_s,
              1e3 * last.spread(12));
  for (int row = 0; row < kLensSize; ++row) {
    if (last.lens_spread[row] <= 0) continue;
    const LensEntry entry = kLensEntries[static_cast<std::size_t>(row)];
    std::printf("%-18s %9.*f %s  +- %.*f\n", entry.name, entry.digits,
                entry.factor * last.lens[row], entry.unit, entry.digits,
                entry.factor * last.lens_spread[row]);
  }
  PrintLoops(loops, !arguments.no_loops);
  for (const std::string& message : s.messages) std::printf("%s\n", message.c_str());
  if (!arguments.out.empty()) std::printf("wrote %s\n", arguments.out.c_str());
}

Result<ClosedRun> RunOn(const VioArguments& arguments, const Sequence& sequence, VioInput& input,
                        const WorkContext& work) {
  std::string tracks_file = arguments.tracks;
  if (tracks_file.empty() && !sequence.has_images() && sequence.tracks_file())
    tracks_file = sequence.tracks_file()->string();
  if (!arguments.init.empty()) {
    const Result<ReferenceState> start = StartOf(arguments.init, sequence.stamp_ns(0));
    if (!start.ok()) return start.error();
    input.start = *start;
  }
  if (!tracks_file.empty()) {
    Result<FeatureTracks> tracks = ReadTracksFile(tracks_file);
    if (!tracks.ok()) return tracks.error();
    Warn(tracks->warnings);
    if (arguments.drop_tracks > 0)
      tracks->images = DropTracks(tracks->images, arguments.drop_tracks, arguments.seed);
    ClosedRun closed;
    closed.run = RunVio(input, tracks->images, arguments.options, work);
    return closed;
  }
  ImageSource images;
  for (int i = 0; i < sequence.num_frames(); ++i) images.stamps_ns.push_back(sequence.stamp_ns(i));
  images.read = [&](int index) { return sequence.ReadRawImage(index); };
  ClosedRun closed;
  LoopCloser closer(input.camera, arguments.loops);
  closed.run = RunVio(
      input, images, arguments.options, arguments.tracker, work, [&](const VioMoment& moment) {
        closed.point_stamps_ns.resize(closed.point_stamps_ns.size() + moment.points.size(),
                                      moment.tracked.stamp_ns);
        if (!arguments.no_loops) closer.See(moment);
      });
  closed.loops = closer.Report();
  closed.correction = closer.Correction();
  Correct(closed);
  return closed;
}

/// Whether there will be a place for the results, before minutes of work.
Status CheckOut(const std::string& out) {
  if (out.empty()) return {};
  const std::filesystem::path folder = std::filesystem::absolute(out).parent_path();
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored)) return {};
  return Error{ErrorCode::kNotFound, "cannot write '" + out + "': there is no folder '" +
                                         folder.string() + "'; create it first"};
}

Status Vio(VioArguments arguments) {
  if (Status status = ParseSettings(arguments); !status.ok()) return status;
  if (Status status = CheckOut(arguments.out); !status.ok()) return status;
  const auto opened = OpenSequence(arguments.sequence);
  if (!opened.ok()) return opened.error();
  const Result<ImuRecording> imu = (*opened)->ReadImu();
  if (!imu.ok()) return imu.error();
  Warn((*opened)->warnings());
  Warn(imu->warnings);
  Result<VioInput> input = VioInputOf(**opened, *imu);
  if (!input.ok()) return input.error();
  ConsoleWork console;
  Stopwatch watch;
  const Result<ClosedRun> closed = RunOn(arguments, **opened, *input, console.context());
  if (!closed.ok()) return closed.error();
  const VioRun* run = &closed->run;
  const double seconds = watch.Milliseconds() / 1000;
  for (const std::string& skipped : run->skipped)
    std::fprintf(stderr, "image skipped: %s\n", skipped.c_str());
  const VioSummary summary = Summarise(*run);
  if (summary.last == nullptr) {
    return Error{ErrorCode::kDegenerate,
                 "no image of '" + arguments.sequence + "' got a pose; " +
                     (summary.messages.empty() ? std::string("there are no images")
                                               : summary.messages.back())};
  }
  if (!arguments.out.empty()) {
    if (Status status = WriteOutputs(arguments, *closed); !status.ok()) return status;
  }
  if (arguments.json != "-") PrintSummary(summary, closed->loops, arguments);
  if (!arguments.json.empty()) {
    if (Status status =
            WriteJsonResult(arguments.json, SummaryToJson(summary, closed->loops, seconds));
        !status.ok())
      return status;
  }
  if (!console.interrupted()) return {};
  return Error{ErrorCode::kCancelled, "stopped after " + std::to_string(run->images) +
                                          " images; what was estimated up to there is kept"};
}

}  // namespace

void AddVioVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<VioArguments>();
  CLI::App* verb =
      app.add_subcommand("vio", "Estimate poses, gravity and calibration from images and an IMU");
  verb->add_option("sequence", arguments->sequence, "Folder of the sequence")->required();
  verb->add_option("--out", arguments->out,
                   "Trajectory to write (TUM); beside it, .covariance.csv and .points.ply")
      ->type_name("T.txt");
  verb->add_option("--tracks", arguments->tracks,
                   "Use these tracked points instead of images (default: the sequence's own where "
                   "it has no images)")
      ->type_name("FILE.csv");
  verb->add_option("--init", arguments->init,
                   "Start from the first row of this file (columns as groundtruth.csv) instead of "
                   "finding a start")
      ->type_name("FILE.csv");
  verb->add_option("--frame", arguments->frame, "Whose poses are written")
      ->check(CLI::IsMember({"body", "cam"}))
      ->capture_default_str();
  verb->add_option("--drop-tracks", arguments->drop_tracks,
                   "Leave out this share of the given tracks, at random")
      ->check(CLI::Range(0.0, 0.99));
  verb->add_option("--seed", arguments->seed, "Seed of --drop-tracks")
      ->check(IsSeed())
      ->capture_default_str();
  verb->add_option("--set", arguments->settings, "One filter option, key=value; may be repeated");
  verb->add_option("--set-tracker", arguments->tracker_settings,
                   "One option of the tracker, key=value; may be repeated");
  verb->add_flag(
      "--no-loops", arguments->no_loops,
      "Do not correct drift where a known place is seen again: the filter's own poses, each "
      "from nothing that came later");
  verb->add_option("--set-loops", arguments->loop_settings,
                   "One option of closing loops, key=value; may be repeated");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Vio(*arguments); }; });
}

}  // namespace plumbline
