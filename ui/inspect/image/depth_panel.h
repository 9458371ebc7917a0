// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// The Z-buffer of the mean states.
std::unique_ptr<Panel> MakeDepthPanel();

}  // namespace plumbline
