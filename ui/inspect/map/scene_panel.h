// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/actions.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// The map in 3-D.
std::unique_ptr<Panel> MakeScenePanel();
/// Where the map is looked at from.
ActionGroup MapActions();

}  // namespace plumbline
