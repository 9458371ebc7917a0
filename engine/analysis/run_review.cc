// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/run_review.h"

#include <algorithm>
#include <utility>

#include "engine/analysis/history.h"
#include "engine/analysis/sequence_view.h"
#include "engine/analysis/true_instances.h"
#include "engine/base/log.h"
#include "engine/dataset/ground_truth.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

Result<SequenceView> ViewOfRun(const RunChoice& choice, const std::filesystem::path& ground_truth,
                               RunReader& reader, const ModelDatabase& database) {
  const RunHeader& header = reader.header();
  auto sequence = OpenSequenceOfRun(choice, header);
  if (!sequence.ok() && !choice.sequence.empty()) return sequence.error();
  SequenceView view = sequence.ok() ? MakeViewWithoutScan(**sequence, database)
                                    : ViewWithoutSequence(header, database);
  if (!sequence.ok()) log::warn("{}; --sequence names another folder", sequence.error().message);
  if (sequence.ok()) {
    if (Status status = MoveWithCorrections(*sequence, reader, view); !status.ok())
      return status.error();
  }
  if (ground_truth.empty()) return view;
  const Result<GroundTruth> truth = ReadGroundTruth(ground_truth);
  if (!truth.ok()) return truth.error();
  view.truth.clear();
  for (const GroundTruthInstance& instance : truth->instances) {
    view.truth.push_back(ViewOfTruth(instance));
    view.truth.back().world_from_object =
        view.world_from_given * view.truth.back().world_from_object;
  }
  return view;
}

}  // namespace

Result<RunReview> ReviewRun(const RunChoice& choice, const std::filesystem::path& ground_truth,
                            const WorkContext& work) {
  auto reader = RunReader::Open(choice.run);
  if (!reader.ok()) return reader.error();
  RunReview review;
  review.last = std::make_shared<const FrameReport>();
  review.header = (*reader)->header();
  auto database = LoadModelsOfRun(choice, review.header);
  if (!database.ok()) return database.error();
  review.database = *database;
  auto view = ViewOfRun(choice, ground_truth, **reader, **database);
  if (!view.ok()) return view.error();
  review.view = std::move(view).value();
  auto events = (*reader)->Events();
  if (!events.ok()) return events.error();
  review.events = std::move(events).value();
  auto timings = (*reader)->Timings();
  if (!timings.ok()) return timings.error();
  review.timings = std::move(timings).value();
  auto tracks = (*reader)->ObjectTracks();
  if (!tracks.ok()) return tracks.error();
  review.tracks = std::move(tracks).value();
  const auto count = (*reader)->NumFrames();
  if (!count.ok()) return count.error();
  const TruthVisibility truths(review.view);
  for (int i = 0; i < *count; ++i) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    work.report({"Reading the run", i, *count});
    auto frame = (*reader)->ReadFrameBrief(i);
    if (!frame.ok()) return frame.error();
    review.history.frames.push_back(
        std::make_shared<const FrameSample>(SampleOf(*frame, review.view, &truths)));
    if (frame->skipped.empty()) {
      review.last = std::make_shared<const FrameReport>(std::move(frame).value());
    }
  }
  return review;
}

void LeaveOut(std::span<const std::string> categories, RunReview& review) {
  const auto left_out = [&](const ModelView& model) {
    return std::find(categories.begin(), categories.end(), model.category) != categories.end();
  };
  const std::vector<ModelView>& models = review.view.models;
  std::vector<SequenceView::Truth>& truths = review.view.truth;
  std::vector<bool> kept_truth;
  for (const SequenceView::Truth& truth : truths) {
    const ModelView* model = ModelByName(review.view, truth.model);
    kept_truth.push_back(model == nullptr || !left_out(*model));
  }
  const auto keep = [&](auto& of_truths) {
    std::size_t i = 0;
    std::erase_if(of_truths, [&](const auto&) { return !kept_truth[i++]; });
  };
  keep(truths);
  for (auto& frame : review.history.frames) {
    FrameSample kept = *frame;
    std::erase_if(kept.objects, [&](const ObjectSample& object) {
      const auto label = static_cast<std::size_t>(object.label.value);
      return label < models.size() && left_out(models[label]);
    });
    if (!kept.truths.empty()) keep(kept.truths);
    frame = std::make_shared<const FrameSample>(std::move(kept));
  }
}

}  // namespace plumbline
