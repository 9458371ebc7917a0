// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/actions.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// Two runs of one sequence, and what differs.
std::unique_ptr<Panel> MakeWhatIfPanel();
/// Forking, and which of two runs shows.
ActionGroup TwoRunActions();

}  // namespace plumbline
