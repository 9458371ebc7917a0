// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/progress.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_header.h"
#include "engine/snapshot/sequence_view.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {

/// What the window needs of a sequence while it plays. Reads the scan and the ground truth where
/// there are any; one that cannot be read is left out with a warning in the log.
SequenceView MakeSequenceView(const Sequence& sequence, const ModelDatabase& database,
                              const WorkContext& work);

/// The same, leaving the scan out.
SequenceView MakeViewWithoutScan(const Sequence& sequence, const ModelDatabase& database);

/// The same of a run whose sequence is gone: no path, no scan, no truth.
SequenceView ViewWithoutSequence(const RunHeader& header, const ModelDatabase& database);

/// Moves the trajectory, and what came with the sequence (truth, scan, given poses), to where poses
/// are known to have been now that objects were seen again; nothing where that corrected none.
/// @param sequence  With the poses of the run.
void MoveWithCorrections(const Sequence& sequence, const LandmarkLoops& corrected,
                         SequenceView& view);

/// The same with all that corrected the poses of a run file. Errors: of the file.
Status MoveWithCorrections(const std::shared_ptr<const Sequence>& sequence, RunReader& reader,
                           SequenceView& view);

/// An instance of the ground truth as a view has it.
SequenceView::Truth ViewOfTruth(const GroundTruthInstance& instance);

}  // namespace plumbline
