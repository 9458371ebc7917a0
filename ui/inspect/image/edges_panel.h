// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// What the edge detector sees.
std::unique_ptr<Panel> MakeEdgesPanel();

}  // namespace plumbline
