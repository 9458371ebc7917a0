// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/geometry/surface_gap.h"
#include "engine/snapshot/object_relation.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct FrameReport;

/// Tells how the confirmed objects of a frame stand to one another. Gaps are between the surfaces
/// of the models, which are made ready when they are first met and kept. Use it in one thread.
class RelationFinder {
 public:
  /// Milliseconds for ten objects; less where only some have moved since the last call.
  /// @param depth, id  Z-buffer of the mean states, as in MapSnapshot; empty: nothing hides
  /// anything.
  std::vector<ObjectRelation> Find(const FrameReport& report, const SequenceView& view,
                                   const cv::Mat& depth, const cv::Mat& id);

 private:
  struct Body;
  struct Gap {
    ModelId label_a, label_b;
    Eigen::Affine3d b_from_a;  ///< Of their meshes.
    double scale_b = 1;
    double gap_m = 0;
  };
  std::vector<Body> BodiesOf(const FrameReport& report, const SequenceView& view);
  double GapOf(const Body& a, const Body& b);
  const Body* NearestOf(const Body& a, const std::vector<Body>& bodies, double& gap_m);

  /// By the mesh, which is kept so that no other takes its place.
  std::map<std::shared_ptr<const TriangleMesh>, std::shared_ptr<const MeasuredSurface>> surfaces_;
  std::map<std::pair<ObjectId, ObjectId>, Gap> gaps_;  ///< Of the frame before.
};

}  // namespace plumbline
