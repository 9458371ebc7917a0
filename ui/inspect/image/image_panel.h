// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/actions.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// The camera's image with proposals and outlines.
std::unique_ptr<Panel> MakeImagePanel();
/// How many image views there are.
ActionGroup ImageViewActions();

}  // namespace plumbline
