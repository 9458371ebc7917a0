// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// The processes of a graph.
std::unique_ptr<Panel> MakeProcessesPanel();

}  // namespace plumbline
