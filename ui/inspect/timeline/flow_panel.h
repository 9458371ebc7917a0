// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// How a frame becomes map, with the time of each step.
std::unique_ptr<Panel> MakeFlowPanel();

}  // namespace plumbline
