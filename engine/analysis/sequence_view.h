// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/progress.h"
#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/models/model_database.h"
#include "engine/recording/run_header.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

/// What the window needs of a sequence while it plays. Reads the scan and the ground truth where
/// there are any; one that cannot be read is left out with a warning in the log.
SequenceView MakeSequenceView(const Sequence& sequence, const ModelDatabase& database,
                              const WorkContext& work);

/// The same, leaving the scan out.
SequenceView MakeViewWithoutScan(const Sequence& sequence, const ModelDatabase& database);

/// The same of a run whose sequence is gone: no path, no scan, no truth.
SequenceView ViewWithoutSequence(const RunHeader& header, const ModelDatabase& database);

/// An instance of the ground truth as a view has it.
SequenceView::Truth ViewOfTruth(const GroundTruthInstance& instance);

}  // namespace plumbline
