// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// How objects stand to one another.
std::unique_ptr<Panel> MakeRelationsPanel();

}  // namespace plumbline
