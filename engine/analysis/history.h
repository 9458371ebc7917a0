// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/run_history.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

class TruthVisibility;
struct FrameReport;

/// Thumbnails that a time line keeps, however long the run.
inline constexpr int kMaxThumbnails = 64;

/// What stays of a frame in the history.
/// @param truths  Null: nothing is kept of the true instances but the errors of the objects.
FrameSample SampleOf(const FrameReport& report, const SequenceView& view,
                     const TruthVisibility* truths = nullptr);

/// Errors of the means of the frame's objects against their true instances, one to one
/// (true_instances.h); nothing for an object that has none. As in `report.objects`.
std::vector<std::optional<TruthError>> ErrorsOf(const FrameReport& report,
                                                const SequenceView& view);

/// 96 pixels wide; empty of an empty image.
cv::Mat ThumbnailOf(const cv::Mat& image);

/// Whether the frame at `position` of `size` gets a thumbnail.
bool WantsThumbnail(int position, int size);

}  // namespace plumbline
