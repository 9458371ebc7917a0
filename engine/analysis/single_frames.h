// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/analysis/run_review.h"
#include "engine/dataset/sequence.h"
#include "engine/evaluation/bop_recall.h"

namespace plumbline {

/// What the map said in single images, judged as the BOP benchmark does (VSD, MSSD, MSPD).
struct SingleFrames {
  int frames = 0;  ///< That were judged.
  /// What hides things in them: depth that was measured, the scan drawn, or the true models drawn.
  int measured = 0, scan = 0, models = 0;
  BopRecall all;                              ///< Over all targets.
  std::map<std::string, BopRecall> by_truth;  ///< By the instances' names.
};

struct SingleFrameOptions {
  int frames = 20;             ///< At most, spread evenly over those that were used; >= 1.
  double least_visible = 0.1;  ///< Less of an instance (BOP's visib_fract) is no target.
};

/// A target is a true instance that shows in an image; its estimate is what the map held in that
/// frame, confirmed by then, of the right model and paired with it (TruthsOfObjects). Of equally
/// good frames one with measured depth is taken. Draws by OpenGL.
/// @param review  Of the run that `reader` reads; categories that are left out of it do not count.
/// @param sequence  That of the run, with its camera.
/// @param scan  In the frame of the ground truth as it was given; may be null.
/// Errors: kUnsupported without OpenGL, kCancelled, those of the reader.
Result<SingleFrames> MeasureSingleFrames(const RunReview& review, RunReader& reader,
                                         const Sequence& sequence, const TriangleMesh* scan,
                                         const SingleFrameOptions& options,
                                         const WorkContext& work);

/// `single_frames` of `plumbline evaluate --json`.
nlohmann::json SingleFramesToJson(const SingleFrames& frames);

}  // namespace plumbline
