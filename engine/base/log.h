// SPDX-License-Identifier: Apache-2.0
#pragma once

// A thin doorway to spdlog. info: worth reading once; warn: the result may differ from what was
// wished; error: something asked for was not done. Expected failures are returned as Result, not
// logged here.
#include <spdlog/spdlog.h>

namespace plumbline::log {
using spdlog::error;
using spdlog::info;
using spdlog::warn;
}  // namespace plumbline::log
