// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "engine/snapshot/comparison_view.h"
#include "engine/snapshot/run_history.h"

namespace plumbline {

struct FrameReport;

/// The confirmed objects of two frames, paired by category, nearest first, within 0.5 m; then those
/// that one frame lacks. It points into both reports.
std::vector<ObjectPair> PairObjects(const FrameReport& a, const FrameReport& b,
                                    const Eigen::Vector3d& up_in_world);

/// The first frame, of those that both know, in which beliefs differ, bit by bit.
std::optional<int> FirstDifference(const RunHistory& a, const RunHistory& b);

/// Over all frames that each history knows.
std::vector<StageDifference> CompareStages(const RunHistory& a, const RunHistory& b);

}  // namespace plumbline
