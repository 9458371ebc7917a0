// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// How the selected object scores, and why.
std::unique_ptr<Panel> MakeWhyPanel();

}  // namespace plumbline
