// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "ui/framework/scene_surface.h"

namespace plumbline {

/// The map in 3-D, drawn by VTK into a texture of the window's GL context. Make, use and destroy it
/// while that context is current. `software_gl` caps the points that are drawn and goes coarser
/// while it moves.
std::unique_ptr<SceneSurface> CreateMapScene(bool software_gl);

}  // namespace plumbline
