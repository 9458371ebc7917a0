// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// Where in the sequence the window is, and what happened when.
std::unique_ptr<Panel> MakeTimelinePanel();

}  // namespace plumbline
