// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/base/progress.h"
#include "engine/mapping/mapper.h"
#include "engine/smoothing/lookback.h"
#include "engine/smoothing/looks.h"
#include "engine/smoothing/smoothed_map_report.h"

namespace plumbline {

/// A run that has ended, and how its frames are read again.
struct SmoothingTask {
  MapperSetup setup;                ///< As the run had it at its end.
  std::vector<PassedFrame> frames;  ///< Those that it used, in order of time.
  /// Every object that it ever had, by id, as it was last reported, with particles.
  std::vector<ObjectReport> objects;
  LoadFrame load;  ///< Called from one thread.
};

/// The second pass over a recording (docs/algorithms/smoothing.md): every object is looked for in
/// all frames, before and after the run found it, its pose is refined in views from the whole
/// recording, and all objects are brought to agree with one another. The run is only read. The same
/// for the same task, whatever the number of threads.
///
/// Errors: kCancelled; kCorrupt (an object without particles);
/// kInvalidInput for a run that used no frame.
Result<SmoothedMap> Smooth(const SmoothingTask& task, const WorkContext& work);

}  // namespace plumbline
