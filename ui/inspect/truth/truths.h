// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/snapshot/truths_view.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/widgets.h"

namespace plumbline {

/// What the history knows of the frame that shows; null if it has not come that far.
const FrameSample* ShownSample(const FrameContext& context);

/// The true instance that is selected; null if none is, or nothing is known of it yet.
const TruthView* SelectedTruth(const FrameContext& context);

/// "chair_B, 2400 px show, a box explained by object 4, object 7 is 31 cm away": a true instance in
/// one frame.
std::string TruthInWords(const TruthView& truth, const TruthSample& sample);

/// Boxes around what shows of the true instances in this frame: those that the map lacks are
/// dashed. The selected one is drawn always, the others only if `all`.
void DrawTruthOverlay(const FrameContext& context, const ImageCanvas& canvas, bool all);
/// Their names.
void LabelTruths(const FrameContext& context, const ImageCanvas& canvas, bool all,
                 PictureLabels& labels);

/// The true instance whose box holds the pixel, the smallest of several; "": none.
std::string TruthAt(const FrameContext& context, const Eigen::Vector2f& pixel);

}  // namespace plumbline
