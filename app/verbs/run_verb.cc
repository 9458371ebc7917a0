// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/smoothed_table.h"
#include "app/verbs/verb.h"
#include "engine/analysis/sequence_view.h"
#include "engine/analysis/true_instances.h"
#include "engine/base/timer.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/recording/landmark_history.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_fork.h"
#include "engine/recording/run_summary.h"
#include "engine/recording/smoothed_record.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

struct RunArguments {
  PipelineArguments pipeline;
  std::string out, json;
  bool resume = false, smooth = false;
  std::string fork;       ///< A run whose past this one takes over.
  std::optional<int> at;  ///< Up to this frame; nothing: all of it.
  std::string plant;      ///< A true instance that the mapper is given then; "": none.
};

/// The run file to write to, new, forked or resumed; `pipeline` then stands where the run goes on.
/// @param summary  Gets every report that a fork takes over.
Result<std::unique_ptr<RunWriter>> OpenWriter(const RunArguments& arguments,
                                              MappingPipeline& pipeline, RunSummary& summary) {
  RunHeader header = HeaderOf(pipeline, PLUMBLINE_VERSION);
  header.forked_after = arguments.at;
  if (!arguments.fork.empty()) {
    const auto take_over = [&](RunWriter& past) -> Status {
      const auto at = TakeOverPast(arguments.fork, *arguments.at, pipeline, past,
                                   [&](const FrameReport& report) { summary.Add(report); });
      if (!at.ok()) return at.error();
      std::fprintf(stderr, "forking after frame %d\n", *at);
      return {};
    };
    return RunWriter::Create(arguments.out, header, take_over, pipeline.own_poses().get());
  }
  std::error_code ignored;
  if (!arguments.resume || !std::filesystem::exists(arguments.out, ignored)) {
    return RunWriter::Create(arguments.out, header, {}, pipeline.own_poses().get());
  }
  Result<RunWriter::Resumed> resumed =
      RunWriter::OpenToResume(arguments.out, header, pipeline.own_poses().get());
  if (!resumed.ok()) return resumed.error();
  if (resumed->last) {
    const auto reader = RunReader::Open(arguments.out);
    if (!reader.ok()) return reader.error();
    const auto options = OptionHistory::Read(**reader);  // the window may have changed some
    if (!options.ok()) return options.error();
    const auto landmarks = ReadLandmarks(**reader);
    if (!landmarks.ok()) return landmarks.error();
    if (Status status = pipeline.Resume(*resumed->last, options->newest(), *landmarks);
        !status.ok())
      return status.error();
    std::fprintf(stderr, "resuming after frame %d\n", resumed->last->frame);
  }
  return std::move(resumed->writer);
}

/// The poses that the run keeps which this one goes on from; null where it keeps none or was made
/// with other options of the filter.
Result<std::shared_ptr<const OwnPoses>> StoredPoses(const RunArguments& arguments) {
  using Poses = std::shared_ptr<const OwnPoses>;
  const RunRecipe& recipe = arguments.pipeline.recipe;
  const std::string& run = arguments.fork.empty() ? arguments.out : arguments.fork;
  std::error_code ignored;
  const bool goes_on = !arguments.fork.empty() || arguments.resume;
  if (recipe.poses.source != PoseSource::kVio || !goes_on || !std::filesystem::exists(run, ignored))
    return Poses();
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return reader.error();
  const RunRecipe& stored = (*reader)->header().recipe;
  if (stored.poses.source != PoseSource::kVio ||
      HashOf(stored.own_poses) != HashOf(recipe.own_poses))
    return Poses();
  // A longer run needs more poses than are kept.
  constexpr int kAll = std::numeric_limits<int>::max();
  if (stored.frames.end.value_or(kAll) < recipe.frames.end.value_or(kAll)) return Poses();
  return (*reader)->ReadOwnPoses();
}

void PrintObjects(const FrameReport& report, const ModelDatabase& database) {
  std::printf("%6s  %-16s %-14s %-10s %9s  %-24s %8s\n", "object", "model", "category", "state",
              "confirmed", "position [m]", "std [cm]");
  for (const ObjectReport& object : report.objects) {
    if (object.state != ObjectState::kConfirmed) continue;
    const Eigen::Vector3d t = object.world_from_object.translation();
    std::printf("%6d  %-16s %-14s %-10s %9d  %7.3f %7.3f %7.3f  %8.1f", object.id.value,
                database.model(object.label).name.c_str(), object.category.c_str(), "confirmed",
                object.confirmed_frame.value_or(-1), t.x(), t.y(), t.z(),
                100 * object.modes.front().position_std_m);
    if (object.scale_std > 0)
      std::printf("  size %+.1f +- %.1f %%", 100 * (object.scale - 1), 100 * object.scale_std);
    std::printf("\n");
  }
}

/// What was confirmed on the way and is not at the end.
void PrintWithdrawn(const std::vector<WithdrawnObject>& objects) {
  for (const WithdrawnObject& object : objects) {
    const std::string into =
        object.merged_into ? ", merged into " + std::to_string(object.merged_into->value) : "";
    std::printf("%6d  %-31s confirmed in frame %d, withdrawn in %d%s: %s\n", object.id.value,
                object.category.c_str(), object.confirmed_frame, object.withdrawn_frame,
                into.c_str(), object.why.c_str());
  }
}

/// Of a run that is closed.
Result<std::vector<WithdrawnObject>> WithdrawnOf(const std::string& run) {
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return reader.error();
  return ReadWithdrawn(**reader);
}

/// How the poses of a run came to be; "" where they were given.
std::string PosesInWords(const OwnPoses* poses) {
  if (poses == nullptr) return "";
  const int closed = poses->loops.believed();
  if (closed == 0) return "own poses, each from nothing that came later; no loop was closed";
  char text[240];
  std::snprintf(text, sizeof(text),
                poses->causal
                    ? "own poses, corrected by %d closed loops from each closure on, by up "
                      "to %.3f m and %.2f deg; none knows of later images"
                    : "own poses, corrected by %d closed loops before mapping, by up to "
                      "%.3f m and %.2f deg: not causal (--set-poses loops=causal is)",
                closed, poses->loops.largest_move_m, poses->loops.largest_turn_deg);
  return text;
}

/// What a live run cannot be combined with.
Status CheckLiveArguments(const RunArguments& arguments) {
  if (!arguments.pipeline.recipe.live_speed) return {};
  const char* other = arguments.resume ? "--resume" : !arguments.fork.empty() ? "--fork" : nullptr;
  if (other == nullptr) return {};
  return Error{ErrorCode::kInvalidInput,
               std::string("--live cannot go with ") + other +
                   ": the clock of a recording starts with its first image, not in the middle of a "
                   "run"};
}

/// @param skipped  Frames that were taken and could not be used.
std::string LiveInWords(const LiveReport& live, int skipped) {
  char speed[40] = "", unused[60] = "", text[300];
  if (live.speed != 1) std::snprintf(speed, sizeof(speed), " at speed %g", live.speed);
  if (skipped > 0) std::snprintf(unused, sizeof(unused), ", %d could not be used", skipped);
  std::snprintf(text, sizeof(text),
                "mapped %d of %d frames as they came (%.1f s%s); %d passed over%s; an image was "
                "%.0f ms old on average when it was taken, %.0f ms when it was mapped",
                live.done - skipped, live.came(), live.recorded_s, speed, live.passed_over, unused,
                live.taken_age_ms, live.done_age_ms);
  return text;
}

nlohmann::json LiveToJson(const LiveReport& live, int skipped) {
  return {{"speed", live.speed},
          {"came", live.came()},
          {"taken", live.taken},
          {"mapped", live.done - skipped},
          {"passed_over", live.passed_over},
          {"recorded_s", live.recorded_s},
          {"taken_age_ms", live.taken_age_ms},
          {"mapped_age_ms", live.done_age_ms}};
}

/// Says of frames that follow one another and cannot be used for one reason only the first and the
/// last: a filter that waits for gravity would fill the screen.
class SkippedFrames {
 public:
  void See(const FrameReport& report) {
    const std::string& why = report.skipped;
    if (why.empty() || KindOf(why) != kind_) Tell();
    if (why.empty()) return;
    if (count_++ == 0) {
      kind_ = KindOf(why);
      std::fprintf(stderr, "frame skipped: %s\n", why.c_str());
    }
    last_ = why;
  }
  void Tell() {
    if (count_ > 2) std::fprintf(stderr, "   and %d more for that reason, up to:\n", count_ - 2);
    if (count_ > 1) std::fprintf(stderr, "frame skipped: %s\n", last_.c_str());
    count_ = 0;
    kind_.clear();
  }

 private:
  /// The sentence without its numbers.
  static std::string KindOf(std::string text) {
    std::erase_if(text, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
    return text;
  }

  int count_ = 0;
  std::string kind_, last_;
};

/// Gives the mapper a true instance of the sequence as a candidate.
Status Plant(const std::string& instance, MappingPipeline& pipeline) {
  if (instance.empty()) return {};
  const auto planted =
      PlantTruth(MakeViewWithoutScan(pipeline.sequence(), *pipeline.database()), instance);
  if (!planted) {
    return Error{ErrorCode::kInvalidInput,
                 "the ground truth of '" + pipeline.sequence().path().string() +
                     "' has no instance '" + instance + "'; 'plumbline info' lists them"};
  }
  return pipeline.Plant(*planted);
}

Status Run(RunArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  if (Status status = CheckLiveArguments(arguments); !status.ok()) return status;
  std::error_code ignored;
  if (!arguments.fork.empty() &&
      std::filesystem::equivalent(arguments.fork, arguments.out, ignored))
    return Error{ErrorCode::kInvalidInput, "--fork and --out name the same file"};
  ConsoleWork console;
  const WorkContext work = console.context();
  const auto own_poses = StoredPoses(arguments);
  if (!own_poses.ok()) return own_poses.error();
  Result<std::unique_ptr<MappingPipeline>> opened =
      MappingPipeline::Open(arguments.pipeline.recipe, work, *own_poses);
  if (!opened.ok()) return opened.error();
  MappingPipeline& pipeline = **opened;
  if (!arguments.fork.empty() && !arguments.at) {
    const auto last = LastFrameOf(arguments.fork);
    if (!last.ok()) return last.error();
    arguments.at = *last;
  }
  RunSummary summary;
  Result<std::unique_ptr<RunWriter>> writer = OpenWriter(arguments, pipeline, summary);
  if (!writer.ok()) return writer.error();
  if (Status status = Plant(arguments.plant, pipeline); !status.ok()) return status;

  std::shared_ptr<const MapSnapshot> last;
  SkippedFrames skipped;
  Stopwatch watch;
  while (!work.stop.stop_requested()) {
    const auto snapshot = pipeline.Next(work.stop);
    if (!snapshot) break;
    last = *snapshot;
    skipped.See(last->report);
    summary.Add(last->report);
    if (Status status = (*writer)->Write(last->report, last->image, pipeline.TakeGrownPoses());
        !status.ok())
      return status;
    work.report({"mapping", pipeline.num_done(), pipeline.num_selected()});
  }
  skipped.Tell();
  if (pipeline.grows())
    (*writer)->SetGrown(HeaderOf(pipeline, PLUMBLINE_VERSION), pipeline.TakeGrownPoses(true));
  if (Status status = (*writer)->Close(); !status.ok()) return status;
  const double seconds = watch.Milliseconds() / 1000;
  const auto withdrawn = WithdrawnOf(arguments.out);
  if (!withdrawn.ok()) return withdrawn.error();
  if (last && arguments.json != "-") {
    PrintObjects(last->report, *pipeline.database());
    PrintWithdrawn(*withdrawn);
    const std::string poses = PosesInWords(pipeline.own_poses().get());
    if (!poses.empty()) std::printf("%s\n", poses.c_str());
    const RunRecipe& used = pipeline.recipe();
    if (used.detector && used.edges)
      std::printf("boxes: %s, edges: %s\n", ToText(*used.detector).c_str(),
                  ToText(*used.edges).c_str());
    std::printf("%d frames in %.1f s, %.1f frames/s; wrote %s\n", summary.frames(), seconds,
                summary.frames() / seconds, arguments.out.c_str());
    if (const auto live = pipeline.live())
      std::printf("%s\n", LiveInWords(*live, summary.skipped()).c_str());
  }
  const RunHeader header = HeaderOf(pipeline, PLUMBLINE_VERSION);
  nlohmann::json json = summary.ToJson(header, seconds, pipeline.database().get());
  json["withdrawn"] = WithdrawnToJson(*withdrawn);
  if (const auto poses = pipeline.own_poses()) {
    json["own_poses"] = {{"causal", poses->causal}, {"loops", ToJson(poses->loops)}};
  }
  if (const auto live = pipeline.live()) json["live"] = LiveToJson(*live, summary.skipped());
  Status status = summary.CheckAnyFrameUsed(arguments.pipeline.recipe.sequence.string());
  if (console.interrupted()) {
    const char* then = pipeline.live() ? "" : ", --resume goes on with it";
    status =
        Error{ErrorCode::kCancelled, "stopped; '" + arguments.out + "' keeps what was done" + then};
  } else if (status.ok() && arguments.smooth) {
    Result<SmoothedMap> smoothed = SmoothRun(arguments.out, pipeline, work);
    if (smoothed.ok()) {
      json["smoothed"] = SmoothedToJson(*smoothed, header, pipeline.database().get());
      if (arguments.json != "-") PrintSmoothed(*smoothed, *pipeline.database());
    } else {
      status = NotSmoothed(smoothed.error(), arguments.out);
    }
  }
  if (!arguments.json.empty()) {
    if (Status written = WriteJsonResult(arguments.json, json); !written.ok()) return written;
  }
  return status;
}

}  // namespace

void AddRunVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* verb =
      app.add_subcommand("run", "Map a sequence: find its objects and leave a run file");
  verb->add_option("sequence", arguments->pipeline.recipe.sequence, "Folder of the sequence")
      ->required();
  verb->add_option("--out", arguments->out, "Run file to write (.plb)")->required();
  arguments->pipeline.AddTo(*verb);
  arguments->pipeline.AddLiveTo(*verb);
  verb->add_flag("--resume", arguments->resume, "Resume the run in --out, if it exists");
  verb->add_option("--fork", arguments->fork,
                   "Copy the past of this run and continue with other options or another seed")
      ->type_name("RUN.plb")
      ->excludes("--resume");
  verb->add_option("--at", arguments->at, "The last frame that is copied (default: all)")
      ->type_name("FRAME")
      ->needs("--fork");
  verb->add_option("--plant", arguments->plant,
                   "After --at, give the mapper this true instance as a candidate: what would have "
                   "become of it?")
      ->type_name("ID")
      ->needs("--fork");
  verb->add_flag("--smooth", arguments->smooth,
                 "Afterwards, smooth: a second pass over all frames, kept beside the result");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Run(*arguments); }; });
}

}  // namespace plumbline
