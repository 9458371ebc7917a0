// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/image_canvas.h"

namespace plumbline {

struct ParticleOverlay {
  double needle_m = 0;  ///< Length of the line along the model's front; 0: none.
  double radius_px = 2;
};

/// The hypotheses of an object as dots at the centres they propose, brighter the heavier, over the
/// image. Returns the index of the particle nearest to the mouse within a few pixels, else -1.
int DrawParticleOverlay(const FrameContext& context, const ImageCanvas& canvas,
                        const ObjectReport& object, const ParticleOverlay& overlay);

}  // namespace plumbline
