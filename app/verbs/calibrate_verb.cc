// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/report/html_page.h"
#include "app/report/svg_plot.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/dataset/growing_sequence.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/tracks_file.h"
#include "engine/geometry/angles.h"
#include "engine/snapshot/lens_entries.h"
#include "engine/vio/lens.h"
#include "engine/vio/own_poses.h"
#include "engine/vio/rig_calibration.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  std::string sequence, tracks, out, report, json;
  std::vector<std::string> settings, tracker_settings;
  int passes = 8;
  bool lens = false, read_out = false, live = false;
  VioOptions options = [] {
    VioOptions wide;  // what is asked for is known less well than usual
    wide.extrinsic_rotation_std_deg = 1;
    wide.extrinsic_translation_std_m = 0.02;
    wide.time_offset_std_s = 0.01;
    return wide;
  }();
  TrackerOptions tracker;
};

/// Where the camera sits, in units for people.
struct Told {
  Eigen::Vector3d turn_deg, arm_cm;
  double offset_ms = 0;
};

Told InWords(const RigEstimate& estimate) {
  const Eigen::AngleAxisd turn(estimate.body_from_cam.linear());
  return {kDegPerRad * turn.angle() * turn.axis(), 100 * estimate.body_from_cam.translation(),
          1e3 * estimate.time_offset_s};
}

/// What a calibration consists of, and the unit of its Sizes().
constexpr int kNumParts = 6;
struct Part {
  const char *title, *unit;
};
constexpr Part kParts[kNumParts] = {{"How the camera is turned on the body", "deg"},
                                    {"Where the camera sits on the body", "cm"},
                                    {"How the clocks differ", "ms"},
                                    {"Focal lengths and centre", "px"},
                                    {"Coefficients of the distortion", "1"},
                                    {"Read-out of an image", "ms"}};

/// Norms of the parts.
Eigen::Matrix<double, kNumParts, 1> Sizes(const RigVector& v) {
  return {kDegPerRad * v.head<3>().norm(), 100 * v.segment<3>(3).norm(), 1e3 * std::abs(v[6]),
          v.segment<4>(7).norm(),          v.segment<4>(11).norm(),      1e3 * std::abs(v[15])};
}

static_assert(kLensEntries.size() == kLensSize);

/// "fx 500.00 px +- 0.12 (503.00 given)" of each number of the lens that was estimated.
std::vector<std::string> LensLines(const RigEstimate& result, const LensVector& given) {
  std::vector<std::string> lines;
  for (int row = 0; row < kLensSize; ++row) {
    const double std = result.spread[7 + row];
    if (std <= 0) continue;
    const LensEntry entry = kLensEntries[static_cast<std::size_t>(row)];
    lines.push_back(fmt::format("{} {:.{}f} {} +- {:.{}f} ({:.{}f} given)", entry.name,
                                entry.factor * result.lens[row], entry.digits, entry.unit,
                                entry.factor * std, entry.digits, entry.factor * given[row],
                                entry.digits));
  }
  return lines;
}

/// The points of a sequence: as given, or tracked in its images. Errors: of the files; kCancelled.
Result<std::vector<TrackedImage>> TracksOf(CalibrateArguments& arguments, const Sequence& sequence,
                                           const VioInput& input, const WorkContext& work) {
  std::string file = arguments.tracks;
  if (file.empty() && !sequence.has_images() && sequence.tracks_file())
    file = sequence.tracks_file()->string();
  if (!file.empty()) {
    Result<FeatureTracks> tracks = ReadTracksFile(file);
    if (!tracks.ok()) return tracks.error();
    Warn(tracks->warnings);
    return std::move(tracks->images);
  }
  arguments.options.given_creep_px = arguments.options.creep_px;  // they are ours
  ImageSource images;
  for (int i = 0; i < sequence.num_frames(); ++i) images.stamps_ns.push_back(sequence.stamp_ns(i));
  images.read = [&](int index) { return sequence.ReadRawImage(index); };
  std::vector<TrackedImage> tracks;
  RunVio(input, images, arguments.options, arguments.tracker, work,
         [&](const VioMoment& moment) { tracks.push_back(moment.tracked); });
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  if (tracks.empty())
    return Error{ErrorCode::kNotFound,
                 "'" + arguments.sequence + "' has no image that can be read"};
  return tracks;
}

void Print(const RigCalibration& calibration, const VioInput& input) {
  std::printf(
      "pass               camera on body: turned [deg]      at [cm]                  clocks [ms]  "
      "innovations\n");
  const auto row = [](const std::string& name, const RigEstimate& estimate, double nis) {
    const Told told = InWords(estimate);
    std::printf("%-18s %9.3f %8.3f %8.3f   %7.2f %7.2f %7.2f   %8.3f", name.c_str(),
                told.turn_deg.x(), told.turn_deg.y(), told.turn_deg.z(), told.arm_cm.x(),
                told.arm_cm.y(), told.arm_cm.z(), told.offset_ms);
    if (nis > 0) std::printf("   %10.2f", nis);
    std::printf("\n");
  };
  RigEstimate given;
  given.body_from_cam = *input.camera.body_from_cam;
  given.time_offset_s = input.imu.time_offset_s;
  given.lens = LensOf(input.camera);
  row("given", given, 0);
  for (std::size_t i = 0; i < calibration.passes.size(); ++i) {
    const RigPass& pass = calibration.passes[i];
    row(fmt::format("{} {}", i + 1, pass.backward ? "backward" : "forward"), pass.estimates.back(),
        pass.nis_per_dof);
  }
  row("result", calibration.result, 0);
  const auto sure = Sizes(calibration.result.spread);
  const auto moved = Sizes(Difference(given, calibration.result));
  std::printf(
      "known to %.3f deg, %.2f cm, %.3f ms; %.3f deg, %.2f cm, %.3f ms from what was given\n",
      sure[0], sure[1], sure[2], moved[0], moved[1], moved[2]);
  for (const std::string& line : LensLines(calibration.result, given.lens))
    std::printf("%s\n", line.c_str());
  std::printf(
      "noise in the stillest second, at most: gyro %.2g rad/s/sqrt(Hz) (%.2g stated), "
      "accelerometer "
      "%.2g m/s^2/sqrt(Hz) (%.2g stated)\n",
      calibration.noise.gyro_density, input.imu.gyro_noise_density, calibration.noise.accel_density,
      input.imu.accel_noise_density);
  std::printf("%s\n", calibration.agreed ? "forward and backward agree"
                                         : "forward and backward do NOT agree: more motion, turns "
                                           "about all axes above all, tells more");
}

nlohmann::json MatrixToJson(const Eigen::Isometry3d& pose) {
  nlohmann::json json = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) json[r][c] = pose.matrix()(r, c);
  }
  return json;
}

nlohmann::json EstimateToJson(const RigEstimate& estimate) {
  nlohmann::json lens = nlohmann::json::object();
  for (int row = 0; row < kLensSize; ++row) {
    const double std = estimate.spread[7 + row];
    if (std > 0)
      lens[kLensEntries[static_cast<std::size_t>(row)].key] = {{"value", estimate.lens[row]},
                                                               {"std", std}};
  }
  return {{"body_from_cam", MatrixToJson(estimate.body_from_cam)},
          {"time_offset_s", estimate.time_offset_s},
          {"std", std::vector<double>(estimate.spread.begin(), estimate.spread.begin() + 7)},
          {"lens", lens}};
}

nlohmann::json ToJson(const RigCalibration& calibration) {
  nlohmann::json json = EstimateToJson(calibration.result);
  json["agreed"] = calibration.agreed;
  json["gyro_noise_density"] = calibration.noise.gyro_density;
  json["accel_noise_density"] = calibration.noise.accel_density;
  for (const RigPass& pass : calibration.passes) {
    nlohmann::json entry = EstimateToJson(pass.estimates.back());
    entry["backward"] = pass.backward;
    entry["nis_per_dof"] = pass.nis_per_dof;
    json["passes"].push_back(entry);
  }
  return json;
}

/// How far each pass was from the result, image by image, beside what it believed.
std::string Page(const RigCalibration& calibration, const Camera& given,
                 const std::string& sequence) {
  std::string body;
  const Told told = InWords(calibration.result);
  const auto sure = Sizes(calibration.result.spread);
  body += fmt::format(
      "<div class='cards'><div class='card'><b>{:.3f} {:.3f} {:.3f}</b><span>deg, rotation vector "
      "of the camera on the body &plusmn; {:.3f}</span></div><div class='card'><b>{:.2f} {:.2f} "
      "{:.2f}</b><span>cm, the camera on the body &plusmn; {:.2f}</span></div><div "
      "class='card'><b>{:.3f}</b><span>ms, time of the IMU less that of an image &plusmn; "
      "{:.3f}</span></div></div><p class='{}'>{}</p>",
      told.turn_deg.x(), told.turn_deg.y(), told.turn_deg.z(), sure[0], told.arm_cm.x(),
      told.arm_cm.y(), told.arm_cm.z(), sure[1], told.offset_ms, sure[2],
      calibration.agreed ? "good" : "bad",
      calibration.agreed ? "Forward and backward agree." : "Forward and backward do not agree.");
  for (const std::string& line : LensLines(calibration.result, LensOf(given)))
    body += "<p>" + line + "</p>";
  for (int k = 0; k < kNumParts; ++k) {
    if (sure[k] <= 0) continue;  // not asked for
    std::vector<SvgSeries> series;
    for (std::size_t i = 0; i < calibration.passes.size(); ++i) {
      const RigPass& pass = calibration.passes[i];
      const std::string name =
          fmt::format("pass {}, {}", i + 1, pass.backward ? "backward" : "forward");
      SvgSeries off{name, SvgColor(static_cast<int>(i)), true, {}, {}};
      SvgSeries believed{
          name + ": one standard deviation", SvgColor(static_cast<int>(i)), false, {}, {}};
      for (const RigEstimate& estimate : pass.estimates) {
        off.x.push_back(estimate.seconds);
        off.y.push_back(Sizes(Difference(calibration.result, estimate))[k]);
        believed.x.push_back(estimate.seconds);
        believed.y.push_back(Sizes(estimate.spread)[k]);
      }
      series.push_back(std::move(off));
      series.push_back(std::move(believed));
    }
    body += SvgLines(
        {kParts[k].title, "time [s]", fmt::format("off the result [{}]", kParts[k].unit)}, series);
  }
  body += "<p class='legend'>";
  for (std::size_t i = 0; i < calibration.passes.size(); ++i)
    body += fmt::format("<span><i class='dot' style='background:{}'></i>pass {}, {}</span>",
                        SvgColor(static_cast<int>(i)), i + 1,
                        calibration.passes[i].backward ? "backward" : "forward");
  return HtmlPage("Calibration", "Camera and IMU of " + sequence,
                  body + "bold: off the result; thin: one standard deviation</p>");
}

/// camera.json and imu.json of the sequence with what was found; of another layout what is known.
Status WriteSensorFiles(const fs::path& folder, const Sequence& sequence, const VioInput& input,
                        const RigEstimate& result) {
  const auto patched = [&](const char* name, nlohmann::json changes) -> Status {
    nlohmann::json json = nlohmann::json::object();
    const auto before = ReadJson(sequence.path() / name);
    if (before.ok() && before->is_object()) json = *before;
    json.update(changes);
    return WriteFileAtomically(folder / name, json.dump(1) + "\n");
  };
  Camera camera = WithLens(input.camera, result.lens);
  camera.body_from_cam = result.body_from_cam;
  if (Status status = patched("camera.json", CameraToJson(camera)); !status.ok()) return status;
  const ImuCalibration& imu = input.imu;
  return patched("imu.json", {{"rate_hz", imu.rate_hz},
                              {"gyro_noise_density", imu.gyro_noise_density},
                              {"accel_noise_density", imu.accel_noise_density},
                              {"gyro_bias_walk", imu.gyro_bias_walk},
                              {"accel_bias_walk", imu.accel_bias_walk},
                              {"gravity_m_s2", imu.gravity_m_s2},
                              {"time_offset_s", result.time_offset_s}});
}

/// What the filter knows by now of a recording that is being made.
std::string InWords(const VioReport& report, double seconds) {
  if (report.phase != VioPhase::kTracking)
    return fmt::format("{:4.0f} s: {}", seconds,
                       report.message.empty() ? "waiting" : report.message);
  RigEstimate estimate;
  estimate.body_from_cam = report.body_from_cam;
  estimate.time_offset_s = report.time_offset_s;
  const Told told = InWords(estimate);
  return fmt::format(
      "{:4.0f} s: clocks {:+.2f} +- {:.2f} ms; camera turned {:.2f} {:.2f} {:.2f} +- {:.2f} deg, "
      "at "
      "{:.1f} {:.1f} {:.1f} +- {:.1f} cm",
      seconds, told.offset_ms, 1e3 * report.spread[12], told.turn_deg.x(), told.turn_deg.y(),
      told.turn_deg.z(), kDegPerRad * report.spread.segment<3>(6).norm(), told.arm_cm.x(),
      told.arm_cm.y(), told.arm_cm.z(), 100 * report.spread.segment<3>(9).norm());
}

/// Tells once a second what is known, until the recording ends, or Ctrl-C is pressed. Errors: as of
/// FollowRecording and OwnPoseEstimator.
Status WatchRecording(const CalibrateArguments& arguments, const WorkContext& work) {
  const auto sequence = FollowRecording(arguments.sequence, work);
  if (!sequence.ok()) return sequence.error();
  OwnPoseOptions options;
  options.filter = arguments.options;
  options.filter.estimate_extrinsics = true;
  options.tracker = arguments.tracker;
  options.loops = LoopUse::kOff;
  auto estimator = OwnPoseEstimator::Create(*sequence, std::numeric_limits<int>::max(), options);
  if (!estimator.ok()) return estimator.error();
  std::optional<std::int64_t> first_ns, told_ns;
  while ((*estimator)->Next(work.stop)) {
    const VioReport now = (*estimator)->TakeReport().vio;
    if (!first_ns) first_ns = now.stamp_ns;
    if (told_ns && now.stamp_ns - *told_ns < 1'000'000'000) continue;
    told_ns = now.stamp_ns;
    std::fprintf(stderr, "%s\n",
                 InWords(now, 1e-9 * static_cast<double>(now.stamp_ns - *first_ns)).c_str());
  }
  return {};
}

Status Calibrate(CalibrateArguments arguments) {
  for (const std::string& setting : arguments.settings) {
    if (Status status = SetOption(setting, arguments.options); !status.ok()) return status;
  }
  for (const std::string& setting : arguments.tracker_settings) {
    if (Status status = SetOption(setting, arguments.tracker); !status.ok()) return status;
  }
  arguments.options.estimate_intrinsics |= arguments.lens;
  arguments.options.estimate_rolling_shutter |= arguments.read_out;
  if (!arguments.out.empty()) {
    std::error_code error;
    fs::create_directories(arguments.out, error);
    if (!fs::is_directory(arguments.out))
      return Error{ErrorCode::kIo, "cannot create the folder '" + arguments.out + "'"};
  }
  // Before minutes of work: whether there will be a place for the results.
  for (const std::string& file : {arguments.report, arguments.json}) {
    if (file.empty() || file == "-") continue;
    const fs::path folder = fs::absolute(file).parent_path();
    if (!fs::is_directory(folder))
      return Error{ErrorCode::kNotFound, "cannot write '" + file + "': there is no folder '" +
                                             folder.string() + "'; create it first"};
  }
  ConsoleWork console;
  if (arguments.live && !IsBeingRecorded(arguments.sequence)) {
    return Error{ErrorCode::kInvalidInput, "nobody records into '" + arguments.sequence +
                                               "' now; without --live its recording is used"};
  }
  if (arguments.live) {
    if (Status status = WatchRecording(arguments, console.context()); !status.ok()) return status;
    if (console.interrupted()) return Error{ErrorCode::kCancelled, "stopped"};
    std::fprintf(stderr, "the recording has ended; forward and backward over all of it:\n");
  }
  const auto sequence = OpenSequence(arguments.sequence);
  if (!sequence.ok()) return sequence.error();
  const Result<ImuRecording> imu = (*sequence)->ReadImu();
  if (!imu.ok()) return imu.error();
  Warn((*sequence)->warnings());
  Warn(imu->warnings);
  const Result<VioInput> input = VioInputOf(**sequence, *imu);
  if (!input.ok()) return input.error();
  const auto tracks = TracksOf(arguments, **sequence, *input, console.context());
  if (!tracks.ok()) return tracks.error();
  const Result<RigCalibration> calibration =
      CalibrateRig(*input, *tracks, arguments.options, arguments.passes, console.context());
  if (!calibration.ok()) return calibration.error();
  if (arguments.json != "-") Print(*calibration, *input);
  if (!arguments.json.empty()) {
    if (Status status = WriteJsonResult(arguments.json, ToJson(*calibration)); !status.ok())
      return status;
  }
  if (!arguments.report.empty()) {
    if (Status status = WriteFileAtomically(arguments.report,
                                            Page(*calibration, input->camera, arguments.sequence));
        !status.ok())
      return status;
  }
  if (arguments.out.empty()) return {};
  return WriteSensorFiles(arguments.out, **sequence, *input, calibration->result);
}

}  // namespace

void AddCalibrateVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* verb = app.add_subcommand(
      "calibrate",
      "Find where the camera sits on the body, how its clock differs from the IMU's, "
      "and whether the stated noise is right, from a recording; on request its lens, too");
  verb->add_option("sequence", arguments->sequence, "Folder of the sequence")->required();
  verb->add_option("--out", arguments->out,
                   "Folder for camera.json and imu.json with what was found")
      ->type_name("DIR");
  verb->add_option("--report", arguments->report, "Web page with the curves of all passes")
      ->type_name("FILE.html");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output")
      ->type_name("FILE");
  verb->add_option("--tracks", arguments->tracks,
                   "Use these tracked points instead of images (default: the sequence's own where "
                   "it has no images)")
      ->type_name("FILE.csv");
  verb->add_flag("--lens", arguments->lens,
                 "Find focal lengths, centre and distortion as well, near those given");
  verb->add_flag("--read-out", arguments->read_out,
                 "Find the time from the first row of an image to its last, of a rolling shutter");
  verb->add_flag("--live", arguments->live,
                 "While somebody records: tell once a second what is known of clocks and camera, "
                 "until the recording ends");
  verb->add_option("--passes", arguments->passes, "Most passes, forward and backward in turn")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  verb->add_option("--set", arguments->settings, "One filter option, key=value; may be repeated");
  verb->add_option("--set-tracker", arguments->tracker_settings,
                   "One option of the tracker, key=value; may be repeated");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Calibrate(*arguments); }; });
}

}  // namespace plumbline
