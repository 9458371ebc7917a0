// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// How the belief about the selected object spreads, and whether it is reliable.
std::unique_ptr<Panel> MakePosteriorPanel();

}  // namespace plumbline
