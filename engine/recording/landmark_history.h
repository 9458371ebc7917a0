// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/mapping/event_report.h"
#include "engine/recording/run_file.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {

/// Takes what corrected poses out of a life event of a frame; others say nothing.
void AddLandmarks(int frame, const LifeEvent& event, LandmarkHistory& history);

/// All of a run file, as far as it is written. Errors: kCorrupt.
Result<LandmarkHistory> ReadLandmarks(RunReader& reader);

}  // namespace plumbline
