// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/mapping/map_report.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

enum class RelationKind {
  kNear,      ///< `b` is the nearest neighbour of `a`; value: gap between them [m].
  kStandsOn,  ///< `a` stands on `b`; value: gap between them [m].
  kHides      ///< `a` hides a share `value` of `b` from the camera of this frame.
};

struct ObjectRelation {
  RelationKind kind = RelationKind::kNear;
  ObjectId a, b;
  double value = 0;
};

/// How the confirmed objects of a frame stand to one another. Gaps are between the vertices of one
/// model (a few hundred of them) and the bounding box of the other. Milliseconds for ten objects.
/// @param depth, id  Z-buffer of the mean states, as in MapSnapshot; empty: nothing hides anything.
std::vector<ObjectRelation> RelationsOf(const FrameReport& report, const SequenceView& view,
                                        const cv::Mat& depth, const cv::Mat& id);

/// "hides", "stands on", "near": between the names of two objects.
const char* RelationName(RelationKind kind);

}  // namespace plumbline
