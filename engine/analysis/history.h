// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/run_history.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct FrameReport;
struct ObjectReport;

/// Thumbnails that a time line keeps, however long the run.
inline constexpr int kMaxThumbnails = 64;

/// What stays of a frame in the history.
FrameSample SampleOf(const FrameReport& report, const SequenceView& view);

/// Error of an object's mean against the nearest true instance of its category, within a metre;
/// nothing otherwise.
std::optional<TruthError> ErrorOf(const ObjectReport& object, const SequenceView& view);

/// 96 pixels wide; empty of an empty image.
cv::Mat ThumbnailOf(const cv::Mat& image);

/// Whether the frame at `position` of `size` gets a thumbnail.
bool WantsThumbnail(int position, int size);

}  // namespace plumbline
