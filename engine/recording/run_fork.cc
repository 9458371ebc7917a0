// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_fork.h"

#include <chrono>
#include <limits>
#include <thread>
#include <utility>

#include "engine/recording/landmark_history.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr auto kPatience = std::chrono::seconds(5);

/// A run that is being recorded is a few frames behind what was mapped.
Status WaitForFrame(const std::filesystem::path& run, int frame, const std::stop_token& stop) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    const auto last = LastFrameOf(run);
    if (last.ok() && *last >= frame) return {};
    if (!last.ok() && last.error().code != ErrorCode::kInvalidInput) return last.error();
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    if (std::chrono::steady_clock::now() > deadline)
      return Error{ErrorCode::kIo, "'" + run.string() + "' does not hold frame " +
                                       std::to_string(frame) + "; fork from an earlier one"};
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// Whether the pipeline maps what the run `file` mapped.
Status CheckSameInputs(const RunHeader& past, const MappingPipeline& pipeline,
                       const std::filesystem::path& file) {
  const RunRecipe& now = pipeline.recipe();
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!past.recipe.poses.SameContent(now.poses)) {
    return refuse("was made with the poses '" + ToText(past.recipe.poses) +
                  "', and these are others or have changed; give the same with --poses");
  }
  if (past.sequence_hash != SequenceFingerprint(pipeline.sequence()) ||
      past.models_hash != pipeline.database()->content_hash())
    return refuse("is of another sequence or other models; a run can only be forked over its own");
  if (past.recipe.frames.begin != now.frames.begin || past.recipe.frames.step != now.frames.step)
    return refuse("took other frames; give the same --frames");
  return {};
}

}  // namespace

Result<int> LastFrameOf(const std::filesystem::path& file) {
  auto reader = RunReader::Open(file);
  if (!reader.ok()) return reader.error();
  const auto last = (*reader)->FindFrame(std::numeric_limits<int>::max());
  if (!last.ok()) return last.error();
  if (!*last) return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' holds no frames yet"};
  const auto frames = (*reader)->Frames(**last);
  if (!frames.ok()) return frames.error();
  return frames->back().frame;
}

Result<int> TakeOverPast(const std::filesystem::path& file, int at, MappingPipeline& pipeline,
                         RunWriter& writer, const std::function<void(const FrameReport&)>& seen) {
  auto reader = RunReader::Open(file);
  if (!reader.ok()) return reader.error();
  if (Status status = CheckSameInputs((*reader)->header(), pipeline, file); !status.ok())
    return status.error();
  const auto last = (*reader)->FindFrame(at);
  if (!last.ok()) return last.error();
  if (!*last)
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' has no frame that early"};
  std::optional<FrameReport> restored;
  LandmarkHistory landmarks;
  for (int i = 0; i <= **last; ++i) {
    auto report = (*reader)->ReadFrame(i);
    if (!report.ok()) return report.error();
    const auto image = (*reader)->ReadThumbnail(i);
    seen(*report);
    for (const LifeEvent& event : report->events) AddLandmarks(report->frame, event, landmarks);
    if (Status status = writer.Write(*report, image.ok() ? *image : cv::Mat()); !status.ok())
      return status.error();
    restored = std::move(report).value();
  }
  if (Status status = pipeline.Resume(*restored, {}, landmarks); !status.ok())
    return status.error();
  return restored->frame;
}

Status ForkRun(const ForkChoice& choice, const WorkContext& work) {
  std::error_code ignored;
  if (std::filesystem::equivalent(choice.run.run, choice.out, ignored))
    return Error{ErrorCode::kInvalidInput,
                 "'" + choice.out.string() + "' is the run that is forked; name another file"};
  RunRecipe recipe;
  std::shared_ptr<const OwnPoses> own_poses;
  {
    auto reader = RunReader::Open(choice.run.run);
    if (!reader.ok()) return reader.error();
    recipe = RecipeOf(choice.run, (*reader)->header());
    auto stored = (*reader)->ReadOwnPoses();
    if (!stored.ok()) return stored.error();
    own_poses = *stored;
  }
  recipe.options = choice.options;
  recipe.seed = choice.seed;
  auto pipeline = MappingPipeline::Open(recipe, work, std::move(own_poses));
  if (!pipeline.ok()) return pipeline.error();
  RunHeader header = HeaderOf(**pipeline, choice.program_version);
  header.forked_after = choice.at;
  if (Status status = WaitForFrame(choice.run.run, choice.at, work.stop); !status.ok())
    return status;
  auto writer = RunWriter::Create(
      choice.out, header,
      [&](RunWriter& past) -> Status {
        const auto at =
            TakeOverPast(choice.run.run, choice.at, **pipeline, past, [](const FrameReport&) {});
        return at.ok() ? Status() : at.error();
      },
      (*pipeline)->own_poses().get());
  if (!writer.ok()) return writer.error();
  if (choice.plant) {
    if (Status status = (*pipeline)->Plant(*choice.plant); !status.ok()) return status;
  }
  while (!work.stop.stop_requested()) {
    const auto snapshot = (*pipeline)->Next();
    if (!snapshot) return (*writer)->Close();
    if (Status status = (*writer)->Write((*snapshot)->report, (*snapshot)->image); !status.ok())
      return status;
    work.report({"Mapping the fork", (*pipeline)->num_done(), (*pipeline)->num_selected()});
  }
  if (Status status = (*writer)->Close(); !status.ok()) return status;
  return Error{ErrorCode::kCancelled, "stopped"};
}

}  // namespace plumbline
