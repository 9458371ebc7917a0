// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// What is believed about the selected object.
std::unique_ptr<Panel> MakeDetailsPanel();

}  // namespace plumbline
