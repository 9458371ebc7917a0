// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/run_source.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "engine/analysis/history.h"
#include "engine/analysis/sequence_view.h"
#include "engine/analysis/true_instances.h"
#include "engine/base/log.h"
#include "engine/pipeline/frame_pictures.h"
#include "engine/pipeline/hypothesis_probe.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/recording/smoothed_record.h"
#include "engine/runtime/past_frame.h"
#include "engine/runtime/probe_answer.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr std::size_t kPictureMemoryBytes = 300u << 20;
constexpr auto kReadAheadTime = std::chrono::milliseconds(8);

class RunSource : public SnapshotSource {
 public:
  RunSource(std::unique_ptr<RunReader> reader, std::vector<RunFrame> frames,
            std::vector<FrameEvent> events, std::unique_ptr<FramePictures> pictures,
            SequenceView view, LazyProbe probe)
      : reader_(std::move(reader)),
        frames_(std::move(frames)),
        events_(std::move(events)),
        pictures_(std::move(pictures)),
        view_(std::move(view)),
        truths_(view_),
        probe_(std::move(probe)),
        mapped_with_(reader_->header()) {
    history_.frames.resize(frames_.size());
    for (const FrameEvent& event : events_) mapped_with_.Add(event.frame, event.event);
  }

  const SequenceView& view() const override { return view_; }
  int size() const override { return static_cast<int>(frames_.size()); }
  int mapped() const override { return size(); }
  int FrameAt(int position) const override {
    return frames_[static_cast<std::size_t>(position)].frame;
  }
  bool recorded() const override { return true; }
  const std::vector<FrameEvent>& events() const override { return events_; }
  const RunHistory& history() const override { return history_; }
  ProbeView Probe(const MapSnapshot& snapshot, const ProbeCommand& request) override {
    return AnswerProbe(probe_, snapshot, view_, mapped_with_.At(snapshot.report.frame), request);
  }
  MapperOptions options() const override { return mapped_with_.newest(); }
  MapperOptions OptionsAt(int frame) const override { return mapped_with_.At(frame); }
  std::shared_ptr<const RunHeader> header() const override {
    return std::make_shared<const RunHeader>(reader_->header());
  }
  std::filesystem::path recording() const override { return reader_->file(); }

  bool ReadAhead() override {
    const auto until = std::chrono::steady_clock::now() + kReadAheadTime;
    while (read_ < size() && std::chrono::steady_clock::now() < until) {
      if (auto report = reader_->ReadFrameBrief(read_); report.ok()) {
        history_.frames[static_cast<std::size_t>(read_)] =
            std::make_shared<const FrameSample>(SampleOf(*report, view_, &truths_));
      }
      if (WantsThumbnail(read_, size())) {
        if (auto image = reader_->ReadThumbnail(read_); image.ok() && !image->empty())
          history_.thumbnails.push_back({FrameAt(read_), ThumbnailOf(*image)});
      }
      ++read_;
    }
    return read_ < size();
  }

  Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token) override {
    return Error{ErrorCode::kUnsupported, "a recorded run has no further frames"};
  }

  Result<std::shared_ptr<const MapSnapshot>> Past(int position, std::stop_token) override {
    return PastFrame(position, *reader_, *pictures_, memory_);
  }

 private:
  std::unique_ptr<RunReader> reader_;
  std::vector<RunFrame> frames_;
  std::vector<FrameEvent> events_;
  std::unique_ptr<FramePictures> pictures_;
  SequenceView view_;
  TruthVisibility truths_;
  LazyProbe probe_;
  OptionHistory mapped_with_;
  SnapshotMemory memory_{kPictureMemoryBytes};
  RunHistory history_;
  int read_ = 0;  ///< Positions that the history knows.
};

struct Inputs {
  std::unique_ptr<FramePictures> pictures;
  SequenceView view;
  std::shared_ptr<const ModelDatabase> database;
};

Result<Inputs> OpenInputs(const RunChoice& choice, RunReader& reader, const WorkContext& work) {
  const RunHeader& header = reader.header();
  auto database = LoadModelsOfRun(choice, header);
  if (!database.ok()) return database.error();
  auto sequence = OpenSequenceOfRun(choice, header);
  if (!sequence.ok() && !choice.sequence.empty()) return sequence.error();
  if (!sequence.ok()) {
    log::warn(
        "{}; the run's small pictures stand in for its images (--sequence names another folder)",
        sequence.error().message);
    auto pictures = FramePictures::CreateWithoutImages(header.camera, *database);
    if (!pictures.ok()) return pictures.error();
    return Inputs{std::move(pictures).value(), ViewWithoutSequence(header, **database), *database};
  }
  auto pictures = FramePictures::Create(*sequence, *database, header.recipe.edges);
  if (!pictures.ok()) return pictures.error();
  SequenceView view = MakeSequenceView(**sequence, **database, work);
  if (Status status = MoveWithCorrections(*sequence, reader, view); !status.ok())
    return status.error();
  return Inputs{std::move(pictures).value(), std::move(view), *database};
}

}  // namespace

Result<std::unique_ptr<SnapshotSource>> OpenRunSource(const RunChoice& choice,
                                                      const WorkContext& work) {
  work.report({"Opening the run"});
  auto reader = RunReader::Open(choice.run);
  if (!reader.ok()) return reader.error();
  const RunHeader header = (*reader)->header();
  auto frames = (*reader)->Frames();
  if (!frames.ok()) return frames.error();
  if (frames->empty())
    return Error{ErrorCode::kInvalidInput, "'" + choice.run.string() + "' holds no frames yet"};
  auto run_events = (*reader)->Events();
  if (!run_events.ok()) return run_events.error();
  std::vector<FrameEvent> events;
  for (const RunEvent& event : *run_events) events.push_back({event.frame, event.event});

  auto inputs = OpenInputs(choice, **reader, work);
  if (!inputs.ok()) return inputs.error();
  inputs->view.name += ", " + choice.run.filename().string();
  auto smoothed = ReadSmoothed(choice.run);
  if (!smoothed.ok()) {
    log::warn("{}; the run is shown without its second pass", smoothed.error().message);
  } else if (*smoothed) {
    inputs->view.smoothed = std::make_shared<const SmoothedMap>(**smoothed);
  }
  return std::unique_ptr<SnapshotSource>(std::make_unique<RunSource>(
      std::move(reader).value(), std::move(frames).value(), std::move(events),
      std::move(inputs->pictures), std::move(inputs->view),
      LazyProbe(header.camera, inputs->database, header.floor_in_world)));
}

}  // namespace plumbline
