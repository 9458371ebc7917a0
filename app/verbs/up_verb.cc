// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/graph_arguments.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/nodes/graph_runner.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/running_graph.h"
#include "engine/sources/recording_rig.h"
#include "engine/sources/sensor_recorder.h"

namespace plumbline {
namespace {

/// What is played again begins once its nodes have opened it.
constexpr std::int64_t kNodesStart_ns = 1'500'000'000;

struct UpArguments {
  PipelineArguments pipeline;
  std::string graph, out, json, folder;
  bool resume = false;
  std::string camera, imu, calibration, exposure = kNoExposure;  ///< Of a graph that records.
  double seconds = 0;
  bool png = false;
};

/// A new folder that this user alone can enter, with a name short enough for sockets.
Result<std::filesystem::path> NewGraphFolder() {
  const std::filesystem::path place = PlaceOfGraphs();
  std::string name = (place / (std::string(kGraphFolderPrefix) + "XXXXXX")).string();
  if (::mkdtemp(name.data()) != nullptr) return std::filesystem::path(name);
  return Error{ErrorCode::kIo,
               "cannot make a folder in '" + place.string() + "'; name another with --folder"};
}

Result<std::filesystem::path> GraphFolder(const std::string& wanted) {
  if (wanted.empty()) return NewGraphFolder();
  std::error_code error;
  std::filesystem::path folder = std::filesystem::absolute(wanted);
  if (std::filesystem::exists(folder, error)) {
    if (std::filesystem::is_directory(folder, error) && std::filesystem::is_empty(folder, error))
      return folder;
    return Error{ErrorCode::kInvalidInput,
                 "'" + wanted + "' is there already; --folder names a new or an empty one"};
  }
  std::filesystem::create_directories(folder, error);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  if (!error) return folder;
  return Error{ErrorCode::kIo, "cannot make the folder '" + wanted + "': " + error.message()};
}

int FramesRecorded(const std::filesystem::path& run) {
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return 0;
  const Result<int> frames = (*reader)->NumFrames();
  return frames.ok() ? *frames : 0;
}

/// Poses of the filter come from a node of its own, and others do not.
Status CheckPoses(const GraphPlan& plan, const RunRecipe& recipe) {
  const GraphNode* mapper = plan.FirstOf(NodeKind::kMapper);
  const bool found = mapper != nullptr && !mapper->poses.empty();
  if (recipe.poses.source == PoseSource::kVio && !found) {
    return Error{ErrorCode::kInvalidInput,
                 "this graph has nobody who finds poses: --poses vio needs a node of kind vio, as "
                 "the graph paper_vio has it"};
  }
  if (recipe.poses.source != PoseSource::kVio && found) {
    return Error{ErrorCode::kInvalidInput,
                 "in this graph the node '" + mapper->poses +
                     "' finds poses; say --poses vio, or choose a graph without it (paper)"};
  }
  return {};
}

/// Gives camera and IMU of the graph what they read. Errors: kInvalidInput.
Status TakeSensors(UpArguments& arguments, GraphPlan& plan) {
  bool camera = false;
  for (GraphNode& node : plan.nodes) {
    if (node.kind != NodeKind::kCamera && node.kind != NodeKind::kImu) continue;
    const bool is_camera = node.kind == NodeKind::kCamera;
    camera = camera || is_camera;
    const std::string& named = is_camera ? arguments.camera : arguments.imu;
    if (!named.empty()) node.source = named;
    if (node.source.empty()) {
      return Error{ErrorCode::kInvalidInput, "the node '" + node.name + "' needs " +
                                                 (is_camera ? "--camera" : "--imu") +
                                                 ", or a \"source\" in the graph"};
    }
    if (node.source == "-")
      return Error{ErrorCode::kInvalidInput, "a node has no standard input to read an IMU from"};
    // graph.json is read by processes that may be started elsewhere.
    if (IsPlayed(node.source))
      node.source = "play:" + std::filesystem::absolute(node.source.substr(5)).string();
  }
  if (!camera) {
    if (arguments.camera.empty() && arguments.imu.empty() && arguments.calibration.empty() &&
        arguments.exposure == kNoExposure && arguments.seconds == 0 && !arguments.png)
      return {};
    return Error{ErrorCode::kInvalidInput,
                 "this graph has no camera; --camera, --imu, --calibration, --exposure, --seconds "
                 "and --png go with one that has, as the graph live"};
  }
  if (arguments.calibration.empty())
    return Error{ErrorCode::kInvalidInput, "a graph with a camera needs --calibration"};
  const auto exposure = ParseExposure(arguments.exposure);
  if (!exposure.ok()) return exposure.error();
  if (*exposure) plan.recording.exposure_ms = (*exposure)->milliseconds;
  if (arguments.resume)
    return Error{ErrorCode::kInvalidInput, "what is recorded cannot go with --resume"};
  plan.recording.seconds = arguments.seconds;
  plan.recording.lossless = arguments.png;
  arguments.pipeline.live = "true";
  arguments.pipeline.poses = "vio";
  return {};
}

/// Makes the folder that camera and IMU write into; what is returned keeps it open.
Result<std::unique_ptr<FileLock>> BeginRecording(const UpArguments& arguments, GraphPlan& plan) {
  const Result<RecordingRig> rig = ReadRecordingRig(arguments.calibration);
  if (!rig.ok()) return rig.error();
  if (!rig->camera.body_from_cam)
    return Error{ErrorCode::kInvalidInput, NoBodyFromCam(arguments.calibration)};
  const auto writer =
      RecordingWriter::Create(plan.recipe->sequence, rig->camera_json, rig->imu_json);
  if (!writer.ok()) return writer.error();
  plan.recording.began_ns = SteadyNs() + kNodesStart_ns;
  return (*writer)->TakeLock();
}

Status Up(UpArguments& arguments) {
  Result<GraphPlan> plan = GraphNamed(arguments.graph);
  if (!plan.ok()) return plan.error();
  if (Status status = TakeSensors(arguments, *plan); !status.ok()) return status;
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  const bool records = plan->FirstOf(NodeKind::kCamera) != nullptr;
  if (records)
    arguments.pipeline.recipe.sequence =
        std::filesystem::absolute(arguments.pipeline.recipe.sequence);
  if (Status status = CheckPoses(*plan, arguments.pipeline.recipe); !status.ok()) return status;
  if (arguments.resume && arguments.pipeline.recipe.live_speed)
    return Error{ErrorCode::kInvalidInput, "--live cannot go with --resume"};
  const Result<std::filesystem::path> program = ThisProgram();
  if (!program.ok()) return program.error();
  const Result<std::filesystem::path> folder = GraphFolder(arguments.folder);
  if (!folder.ok()) return folder.error();
  plan->recipe = arguments.pipeline.recipe;
  plan->out = std::filesystem::absolute(arguments.out);
  plan->resume = arguments.resume;
  if (Status status = ResolveGraph(*folder, *plan); !status.ok()) return status;
  GraphRunOptions options;
  if (records) {
    auto recording = BeginRecording(arguments, *plan);
    if (!recording.ok()) {
      std::error_code ignored;
      if (arguments.folder.empty()) std::filesystem::remove_all(*folder, ignored);
      return recording.error();
    }
    options.recording = std::move(recording).value();
  }
  options.program = *program;
  options.graph_file = *folder / "graph.json";
  if (Status status = WriteJson(options.graph_file, GraphToJson(*plan)); !status.ok())
    return status;
  std::fprintf(stderr, "%zu nodes; 'plumbline graph %s' shows them\n", plan->nodes.size(),
               folder->c_str());
  options.tell = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  ConsoleWork console;
  const WorkContext work = console.context();
  const Stopwatch watch;
  const Result<GraphRunEnd> end = RunGraph(*plan, std::move(options), work);
  const double seconds = watch.Milliseconds() / 1000;
  if (records && !end.ok()) RecordingWriter::RemoveIfEmpty(plan->recipe->sequence);
  // What a node that failed has said is kept.
  if (arguments.folder.empty() && (end.ok() || console.interrupted())) {
    std::error_code ignored;
    std::filesystem::remove_all(*folder, ignored);
  }
  if (console.interrupted() && !end.ok()) {
    const char* then = plan->recipe->live_speed ? "" : ", --resume goes on with it";
    return Error{ErrorCode::kCancelled,
                 "stopped; '" + arguments.out + "' keeps what was done" + then};
  }
  if (!end.ok()) return end.error();
  const int frames = FramesRecorded(plan->out);
  int restarts = 0;
  nlohmann::json json = {{"frames", frames},
                         {"seconds", seconds},
                         {"fps", frames / seconds},
                         {"restarts", nlohmann::json::object()}};
  for (const auto& [name, count] : end->restarts) {
    json["restarts"][name] = count;
    restarts += count;
  }
  if (arguments.json != "-") {
    std::printf("%d frames in %.1f s, %.1f frames/s, in %zu processes", frames, seconds,
                frames / seconds, plan->nodes.size());
    if (restarts > 0) std::printf(", %d started again", restarts);
    std::printf("; wrote %s\n", arguments.out.c_str());
  }
  return arguments.json.empty() ? Status() : WriteJsonResult(arguments.json, json);
}

}  // namespace

void AddUpVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<UpArguments>();
  CLI::App* verb = app.add_subcommand(
      "up", "Map a sequence with modules as processes of their own, as a graph says");
  verb->add_option("graph", arguments->graph,
                   "GRAPH.json, or paper: player, edges, detector, mapper and recorder; paper_vio: "
                   "also a node that finds poses (--poses vio); live: also a camera and an IMU")
      ->required();
  verb->add_option("sequence", arguments->pipeline.recipe.sequence,
                   "Folder of the sequence; of a graph with a camera: the folder to record into")
      ->required();
  verb->add_option("--out", arguments->out, "Run file to write (.plb)")->required();
  arguments->pipeline.AddTo(*verb);
  arguments->pipeline.AddLiveTo(*verb);
  verb->add_option("--camera", arguments->camera, "What a node of kind camera reads, as of record");
  verb->add_option("--imu", arguments->imu, "What a node of kind imu reads, as of record");
  verb->add_option("--calibration", arguments->calibration, "Of both, as of record");
  verb->add_option("--exposure", arguments->exposure, "As of record")->capture_default_str();
  verb->add_option("--seconds", arguments->seconds,
                   "Record so long (default: until Ctrl-C, or until the camera gives no more)")
      ->check(CLI::PositiveNumber);
  verb->add_flag("--png", arguments->png, "Record images as PNG (default: JPEG)");
  verb->add_flag("--resume", arguments->resume, "Resume the run in --out, if it exists");
  verb->add_option(
      "--folder", arguments->folder,
      "Where sockets and logs lie; kept (default: a new one, removed if all went well)");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Up(*arguments); }; });
}

}  // namespace plumbline
