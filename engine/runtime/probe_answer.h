// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/pipeline/hypothesis_probe.h"

namespace plumbline {

/// Lets `probe` answer about an object beside its true instance, or about a true instance beside
/// the candidate that could become it.
ProbeView AnswerProbe(LazyProbe& probe, const MapSnapshot& snapshot, const SequenceView& view,
                      const MapperOptions& options, const ProbeCommand& request);

}  // namespace plumbline
