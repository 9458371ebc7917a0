// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// What each stage takes.
std::unique_ptr<Panel> MakeTimingsPanel();

}  // namespace plumbline
