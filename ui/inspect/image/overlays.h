// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "ui/framework/image_canvas.h"

namespace plumbline {

/// The objects of the frame that views leave out (FrameContext::Shows), by id.
std::vector<ObjectId> LeftOut(const FrameContext& context);
/// For textures of the frame's objects: another number where the frame, who shows, or a look is
/// another.
std::uint64_t VersionOfShown(const FrameContext& context, const std::vector<ObjectId>& left_out);
/// A map of the frame (CV_32F or CV_16U) with 0 where `id` (CV_16U, of the same size) is one of
/// `left_out`; the same one, not copied, if none is.
cv::Mat WithoutObjects(const cv::Mat& map, const cv::Mat& id,
                       const std::vector<ObjectId>& left_out);

struct ParticleOverlay {
  bool fronts = false;  ///< A line along each hypothesis' front.
  double radius_px = 2;
};

/// The hypotheses of an object as dots at the centres they propose, brighter the heavier, over the
/// image. Returns the index of the particle nearest to the mouse within a few pixels, else -1.
int DrawParticleOverlay(const FrameContext& context, const ImageCanvas& canvas,
                        const ObjectReport& object, const ParticleOverlay& overlay);

struct OutlineOverlay {
  double width_px = 1.75;
  double alpha = 1;
  bool shadow = true;  ///< A dark rim, to stand off bright images.
  ObjectId only;       ///< Draws this object alone; not valid: all.
};

/// Outlines of the mean states in their objects' colours; the selected one is bolder, tentative
/// ones are thin.
void DrawOutlineOverlay(const FrameContext& context, const ImageCanvas& canvas,
                        const OutlineOverlay& overlay);

/// The probe of the selected object, or true instance, in the frame that is shown; null if there is
/// none.
const ProbeView* ProbeOfSelection(const FrameContext& context);

/// Contour samples of the probed hypothesis that is selected: a tick along each search line, a dot
/// where the edge was found. Green hits well, red misses, grey is hidden or without
/// contrast to what is known to be behind it.
void DrawContourOverlay(const FrameContext& context, const ImageCanvas& canvas);

/// The points that the visual-inertial filter follows in the frame that shows, in a run with own
/// poses: green in the state, red turned away by the gate, grey followed only. Older ones are
/// larger; pointing at one tells its numbers.
void DrawTrackOverlay(const FrameContext& context, const ImageCanvas& canvas);

/// Outline of the particle under the mouse, else of the marked one, as far as it is known.
void DrawParticleOutline(const FrameContext& context, const ImageCanvas& canvas);

/// Position and colour of the pixel under the mouse, in a corner of the picture.
void DrawPixelValue(const FrameContext& context, const ImageCanvas& canvas);

/// The object whose mean state shows at a pixel of the image; not valid where there is none, or one
/// that views leave out.
ObjectId ObjectAt(const FrameContext& context, const Eigen::Vector2f& pixel);

}  // namespace plumbline
