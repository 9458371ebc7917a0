// SPDX-License-Identifier: Apache-2.0
// What the commands parse besides what the engine does.
#pragma once

#include "cmake/precompiled/engine.h"

#include <CLI/CLI.hpp>
