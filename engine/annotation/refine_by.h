// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// What the refinement of a pose goes by.
enum class RefineBy { kBoth, kScan, kImages };

}  // namespace plumbline
