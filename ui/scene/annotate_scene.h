// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/annotate_view.h"

namespace plumbline {

/// A scan and the models in it, drawn by VTK into a texture of the window's GL context. Make, use
/// and destroy it while that context is current.
std::unique_ptr<AnnotateSurface> CreateAnnotateScene(bool software_gl);

}  // namespace plumbline
