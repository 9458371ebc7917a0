// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ui/framework/panel.h"

namespace plumbline {

/// The selected object's hypotheses in numbers.
std::unique_ptr<Panel> MakeParticleTablePanel();

}  // namespace plumbline
