// SPDX-License-Identifier: Apache-2.0
// What the tests parse besides what the engine does.
#pragma once

#include "cmake/precompiled/engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
