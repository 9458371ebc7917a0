// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/mapping_source.h"

#include <chrono>
#include <thread>
#include <utility>

#include "engine/analysis/history.h"
#include "engine/analysis/sequence_view.h"
#include "engine/analysis/true_instances.h"
#include "engine/pipeline/frame_pictures.h"
#include "engine/pipeline/hypothesis_probe.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/past_frame.h"
#include "engine/runtime/probe_answer.h"
#include "engine/runtime/run_file_place.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr std::size_t kMemoryBytes = 300u << 20;
constexpr auto kWriterPatience = std::chrono::seconds(5);

class MappingSource : public SnapshotSource {
 public:
  MappingSource(std::unique_ptr<MappingPipeline> pipeline, std::unique_ptr<FramePictures> pictures,
                RunFilePlace place, std::unique_ptr<RunWriter> writer, const RunHeader& header,
                SequenceView view, const MappingChoice& choice)
      : place_(std::move(place)),
        pipeline_(std::move(pipeline)),
        pictures_(std::move(pictures)),
        writer_(std::move(writer)),
        view_(std::move(view)),
        truths_(view_),
        range_(pipeline_->recipe().frames),
        probe_(pipeline_->sequence().camera(), pipeline_->database(),
               pipeline_->sequence().floor_in_world()),
        header_(std::make_shared<const RunHeader>(header)),
        mapped_with_(header),
        options_(choice.recipe.options) {}

  ProbeView Probe(const MapSnapshot& snapshot, const ProbeCommand& request) override {
    return AnswerProbe(probe_, snapshot, view_, mapped_with_.At(snapshot.report.frame), request);
  }
  MapperOptions options() const override { return options_; }
  MapperOptions OptionsAt(int frame) const override { return mapped_with_.At(frame); }
  std::shared_ptr<const RunHeader> header() const override { return header_; }
  Status SetOptions(const MapperOptions& options) override {
    options_ = options;
    pipeline_->SetOptions(options);
    return {};
  }
  std::filesystem::path recording() const override { return place_.path(); }

  const SequenceView& view() const override { return view_; }
  int view_version() const override { return view_version_; }
  int size() const override { return mapped() + pipeline_->num_selected() - pipeline_->num_done(); }
  int mapped() const override { return static_cast<int>(frames_.size()); }
  int FrameAt(int position) const override {
    if (position < mapped()) return frames_[static_cast<std::size_t>(position)];
    const int next = frames_.empty() ? range_.begin : frames_.back() + range_.step;
    return next + (position - mapped()) * range_.step;
  }
  std::optional<LiveReport> live() const override { return pipeline_->live(); }
  bool recorded() const override { return false; }
  const std::vector<FrameEvent>& events() const override { return events_; }
  const RunHistory& history() const override { return history_; }

  Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token stop) override {
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    const auto next = pipeline_->Next(stop);
    if (!next && stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    if (!next && pipeline_->grows()) {
      writer_->SetGrown(HeaderOf(*pipeline_, header_->program_version),
                        pipeline_->TakeGrownPoses());
      return Error{ErrorCode::kCancelled, "the recording has ended"};
    }
    if (!next) return Error{ErrorCode::kIo, "the sequence ended before its last frame"};
    const PinholeCamera& camera = pipeline_->sequence().camera();
    (*next)->outlines = OutlinesOf((*next)->id, {camera.width, camera.height});
    std::shared_ptr<const MapSnapshot> snapshot = *next;
    const auto grown = pipeline_->TakeGrownPoses();
    if (Status status = writer_->Write(snapshot->report, snapshot->image, grown); !status.ok())
      return status.error();
    if (grown != nullptr) {  // live: truth and trajectory find their places as they are known
      view_ = MakeViewWithoutScan(pipeline_->sequence(), *pipeline_->database());
      MoveView();
    }
    for (const LifeEvent& event : snapshot->report.events) {
      if (event.kind == EventKind::kPosesCorrected) MoveView();
      mapped_with_.Add(snapshot->report.frame, event);
      events_.push_back({snapshot->report.frame, event});
    }
    history_.frames.push_back(
        std::make_shared<const FrameSample>(SampleOf(snapshot->report, view_, &truths_)));
    if (WantsThumbnail(mapped(), pipeline_->num_selected()) && !snapshot->image.empty())
      history_.thumbnails.push_back({snapshot->report.frame, ThumbnailOf(snapshot->image)});
    memory_.Put(mapped(), snapshot);
    frames_.push_back(snapshot->report.frame);
    return snapshot;
  }

  Result<std::shared_ptr<const MapSnapshot>> Past(int position, std::stop_token stop) override {
    if (auto known = memory_.Get(position)) return known;
    const auto deadline = std::chrono::steady_clock::now() + kWriterPatience;
    while (writer_->num_written() <= position) {
      if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
      if (std::chrono::steady_clock::now() > deadline) {
        return Error{ErrorCode::kIo,
                     "'" + place_.path().string() +
                         "' is not written fast enough to look back; is the disk full?"};
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    if (reader_ == nullptr) {
      auto reader = RunReader::Open(place_.path());
      if (!reader.ok()) return reader.error();
      reader_ = std::move(reader).value();
    }
    return PastFrame(position, *reader_, *pictures_, memory_);
  }

 private:
  void MoveView() {
    MoveWithCorrections(pipeline_->sequence(), *pipeline_->landmarks(), view_);
    truths_ = TruthVisibility(view_);
    ++view_version_;
  }

  RunFilePlace place_;  ///< First: removed after reader and writer are closed.
  std::unique_ptr<MappingPipeline> pipeline_;
  std::unique_ptr<FramePictures> pictures_;
  std::unique_ptr<RunWriter> writer_;
  std::unique_ptr<RunReader> reader_;
  SequenceView view_;
  int view_version_ = 0;
  TruthVisibility truths_;
  FrameRange range_;
  LazyProbe probe_;
  std::shared_ptr<const RunHeader> header_;
  OptionHistory mapped_with_;
  MapperOptions options_;  ///< Of the next frame.
  SnapshotMemory memory_{kMemoryBytes};
  std::vector<FrameEvent> events_;
  RunHistory history_;
  std::vector<int> frames_;  ///< Mapped.
};

}  // namespace

Result<std::unique_ptr<SnapshotSource>> OpenMappingSource(const MappingChoice& choice,
                                                          const WorkContext& work) {
  work.report({"Opening the sequence"});
  auto pipeline = MappingPipeline::Open(choice.recipe, work);
  if (!pipeline.ok()) return pipeline.error();
  auto place = RunFilePlace::Choose(choice.out);
  if (!place.ok()) return place.error();
  const RunHeader header = HeaderOf(**pipeline, choice.program_version);
  auto writer = RunWriter::Create(place->path(), header, {}, (*pipeline)->own_poses().get());
  if (!writer.ok()) return writer.error();
  const std::shared_ptr<const Sequence> sequence = (*pipeline)->shared_sequence();
  auto pictures =
      FramePictures::Create(sequence, (*pipeline)->database(), (*pipeline)->recipe().edges);
  if (!pictures.ok()) return pictures.error();
  SequenceView view = MakeSequenceView(*sequence, *(*pipeline)->database(), work);
  return std::unique_ptr<SnapshotSource>(std::make_unique<MappingSource>(
      std::move(pipeline).value(), std::move(pictures).value(), std::move(place).value(),
      std::move(writer).value(), header, std::move(view), choice));
}

}  // namespace plumbline
