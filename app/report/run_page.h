// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "engine/analysis/run_review.h"
#include "engine/evaluation/map_evaluation.h"

namespace plumbline {

/// What decides how large a page becomes.
struct RunPageOptions {
  int width = 560;           ///< Of the images [px]; narrower ones stay as they are.
  int quality = 60;          ///< Of their JPEG, 1 to 100.
  std::optional<int> every;  ///< Of the frames each that many-th; nothing: all, or kMostSteps.
};

/// Frames of a page whose number nobody chose.
inline constexpr int kMostSteps = 600;

struct RunPage {
  std::string html;
  int steps = 0;                ///< Frames that one can step to.
  std::size_t image_bytes = 0;  ///< Share of the images in `html`.
};

/// A web page in which one steps through a run: images with outlines and boxes over them, the map
/// in three dimensions, a timeline, objects and events. Everything is inside and nothing is
/// fetched. Of paths only the last names are kept. Without the folder of its sequence the small
/// pictures of the run stand in for its images. The same run gives the same page.
///
/// @param review  Of the same run.
/// Errors: those of RunReader and of the renderer; kCancelled.
Result<RunPage> MakeRunPage(const RunChoice& choice, const RunReview& review,
                            const std::optional<MapEvaluation>& evaluation,
                            const RunPageOptions& options, const WorkContext& work);

}  // namespace plumbline
