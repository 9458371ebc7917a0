// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_inputs.h"
#include "engine/snapshot/run_history.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct FrameReport;

/// A recorded run as a whole: what reports, tables and comparisons are made of. Particles are left
/// out.
struct RunReview {
  RunHeader header;
  std::shared_ptr<const ModelDatabase> database;
  SequenceView view;   ///< With the truth, where there is any; no scan.
  RunHistory history;  ///< Every frame; no thumbnails.
  std::vector<RunEvent> events;
  std::vector<RunTiming> timings;
  std::vector<ObjectTrack> tracks;
  /// The last frame that was used, without particles; never null, empty in a run without one.
  std::shared_ptr<const FrameReport> last;
};

/// Reads the run. Without the folder of its sequence there are no camera poses; models are needed.
/// @param ground_truth  Empty: that of the sequence, if it has any.
/// Errors: kNotFound, kInvalidInput, kCorrupt, kCancelled, naming the file.
Result<RunReview> ReviewRun(const RunChoice& choice, const std::filesystem::path& ground_truth,
                            const WorkContext& work);

/// Takes objects and truth of these categories out of the view and the history.
void LeaveOut(std::span<const std::string> categories, RunReview& review);

}  // namespace plumbline
