// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/actions.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// All objects of the map.
std::unique_ptr<Panel> MakeObjectsPanel();
/// What is selected.
ActionGroup SelectionActions();

}  // namespace plumbline
