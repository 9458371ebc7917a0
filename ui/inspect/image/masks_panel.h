// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// Visible parts of the mean states.
std::unique_ptr<Panel> MakeMasksPanel();

}  // namespace plumbline
