// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// The image of the other run, beside that of the first.
std::unique_ptr<Panel> MakeOtherImagePanel();

}  // namespace plumbline
