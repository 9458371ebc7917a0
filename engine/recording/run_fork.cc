// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_fork.h"

#include <chrono>
#include <ctime>
#include <limits>
#include <thread>
#include <utility>

namespace plumbline {
namespace {

constexpr auto kPatience = std::chrono::seconds(5);

std::string Now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  return text;
}

/// What CreateDetector takes, from what a detector said of itself.
std::string DetectorChoice(const std::string& description) {
  constexpr std::string_view kNetwork = "fastestdet ";
  const std::size_t end = description.find(".onnx");
  if (!description.starts_with(kNetwork) || end == std::string::npos) return "dataset";
  return description.substr(kNetwork.size(), end + 5 - kNetwork.size());
}

PipelineChoice InputsOf(const RunChoice& choice, const RunHeader& header) {
  PipelineChoice pipeline;
  pipeline.sequence =
      choice.sequence.empty() ? std::filesystem::path(header.sequence_path) : choice.sequence;
  pipeline.models =
      choice.models.empty() ? std::filesystem::path(header.models_path) : choice.models;
  pipeline.detector = DetectorChoice(header.detector);
  pipeline.edges = EdgeChoice(header.edges);
  if (!header.poses_path.empty()) pipeline.poses = header.poses_path;
  pipeline.frames = {header.first_frame, header.end_frame, header.frame_step};
  return pipeline;
}

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
  const RunHeader past = (*reader)->header(), now = HeaderOf(pipeline);
  if (past.poses != now.poses) {
    const std::string as = past.poses_path.empty() ? "the sequence" : "'" + past.poses_path + "'";
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() + "' was made with the poses of " + as +
                     ", and these are others or have changed; give the same with --poses"};
  }
  if (past.sequence_hash != now.sequence_hash || past.models_hash != now.models_hash)
    return Error{ErrorCode::kInvalidInput, "'" + file.string() +
                                               "' is of another sequence or other models; a run "
                                               "can only be forked over its own"};
  if (past.first_frame != now.first_frame || past.frame_step != now.frame_step)
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() + "' took other frames; give the same --frames"};
  const auto last = (*reader)->FindFrame(at);
  if (!last.ok()) return last.error();
  if (!*last)
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' has no frame that early"};
  std::optional<FrameReport> restored;
  for (int i = 0; i <= **last; ++i) {
    auto report = (*reader)->ReadFrame(i);
    if (!report.ok()) return report.error();
    const auto image = (*reader)->ReadThumbnail(i);
    seen(*report);
    if (Status status = writer.Write(*report, image.ok() ? *image : cv::Mat()); !status.ok())
      return status.error();
    restored = std::move(report).value();
  }
  if (Status status = pipeline.Resume(*restored); !status.ok()) return status.error();
  return restored->frame;
}

Status ForkRun(const ForkChoice& choice, const WorkContext& work) {
  std::error_code ignored;
  if (std::filesystem::equivalent(choice.run.run, choice.out, ignored))
    return Error{ErrorCode::kInvalidInput,
                 "'" + choice.out.string() + "' is the run that is forked; name another file"};
  PipelineChoice inputs;
  {
    auto reader = RunReader::Open(choice.run.run);
    if (!reader.ok()) return reader.error();
    inputs = InputsOf(choice.run, (*reader)->header());
  }
  inputs.options = choice.options;
  inputs.seed = choice.seed;
  auto pipeline = MappingPipeline::Open(inputs, work);
  if (!pipeline.ok()) return pipeline.error();
  RunHeader header = HeaderOf(**pipeline);
  header.forked_after = choice.at;
  header.program_version = choice.program_version;
  header.started = Now();
  if (Status status = WaitForFrame(choice.run.run, choice.at, work.stop); !status.ok())
    return status;
  auto writer = RunWriter::Create(choice.out, header, [&](RunWriter& past) -> Status {
    const auto at =
        TakeOverPast(choice.run.run, choice.at, **pipeline, past, [](const FrameReport&) {});
    return at.ok() ? Status() : at.error();
  });
  if (!writer.ok()) return writer.error();
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
