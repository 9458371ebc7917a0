// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// What the visual-inertial filter believes at the frame that shows.
std::unique_ptr<Panel> MakeInertialPanel();

}  // namespace plumbline
