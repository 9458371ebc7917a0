// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// The selected object's hypotheses over the image.
std::unique_ptr<Panel> MakeParticlesPanel();

}  // namespace plumbline
