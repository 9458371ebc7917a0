// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// How networks of the sidecar's kind are usually fed: fit, order of colours, scale of values.
/// @return what that is, and how sure, in a sentence.
std::string FeedAsUsual(NetworkSidecar& sidecar);

}  // namespace plumbline
