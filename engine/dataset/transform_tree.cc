// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/transform_tree.h"

#include <algorithm>

#include "engine/dataset/recorded_sequence.h"

namespace plumbline {
namespace {

constexpr int kDeepestTree = 64;  ///< Beyond it frames lie above themselves.
constexpr std::int64_t kTransformStep_ns = 500'000'000, kTransformBeyond_ns = 10'000'000;

}  // namespace

void TransformTree::Add(const RosTransform& transform, bool fixed) {
  Edge& edge = edges_[transform.child];
  auto& poses = edge.parent_from_child.poses;
  if (poses.empty()) {
    edge.parent = transform.header.frame;
    edge.fixed = fixed;
  }
  if (edge.parent != transform.header.frame || (edge.fixed && !poses.empty())) return;
  poses.push_back({transform.header.stamp_ns, transform.parent_from_child});
}

void TransformTree::Finish() {
  for (auto& [child, edge] : edges_) {
    auto& poses = edge.parent_from_child.poses;
    std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
      return a.stamp_ns < b.stamp_ns;
    });
    poses.erase(std::unique(poses.begin(), poses.end(),
                            [](const StampedPose& a, const StampedPose& b) {
                              return a.stamp_ns == b.stamp_ns;
                            }),
                poses.end());
  }
}

std::string TransformTree::RootAbove(const std::string& frame) const {
  std::string root = frame;
  for (int i = 0; i < kDeepestTree; ++i) {
    const auto edge = edges_.find(root);
    if (edge == edges_.end()) return root;
    root = edge->second.parent;
  }
  return frame;
}

std::optional<Eigen::Isometry3d> TransformTree::EdgeAt(const Edge& edge,
                                                       std::int64_t stamp_ns) const {
  const Trajectory& poses = edge.parent_from_child;
  if (edge.fixed) return poses.poses.front().world_from_cam;
  if (stamp_ns < poses.poses.front().stamp_ns || stamp_ns > poses.poses.back().stamp_ns)
    return poses.Nearest(stamp_ns, kTransformBeyond_ns);
  return PoseAt(poses, stamp_ns, kTransformStep_ns);
}

bool TransformTree::Moves(const std::string& above, const std::string& frame) const {
  std::string at = frame;
  for (int i = 0; i < kDeepestTree && at != above; ++i) {
    const auto edge = edges_.find(at);
    if (edge == edges_.end()) return false;
    if (!edge->second.fixed && edge->second.parent_from_child.poses.size() > 1) return true;
    at = edge->second.parent;
  }
  return false;
}

std::optional<Eigen::Isometry3d> TransformTree::At(const std::string& above,
                                                   const std::string& frame,
                                                   std::int64_t stamp_ns) const {
  Eigen::Isometry3d at_from_frame = Eigen::Isometry3d::Identity();
  std::string at = frame;
  for (int i = 0; i < kDeepestTree; ++i) {
    if (at == above) return at_from_frame;
    const auto edge = edges_.find(at);
    if (edge == edges_.end()) return std::nullopt;
    const auto parent_from_at = EdgeAt(edge->second, stamp_ns);
    if (!parent_from_at) return std::nullopt;
    at_from_frame = *parent_from_at * at_from_frame;
    at = edge->second.parent;
  }
  return std::nullopt;
}

std::optional<Eigen::Isometry3d> TransformTree::Rigid(const std::string& target,
                                                      const std::string& source) const {
  // Where the way up from the one meets that from the other, if only fixed transforms lie between.
  std::map<std::string, Eigen::Isometry3d> above_target;
  for (const std::string* from : {&target, &source}) {
    Eigen::Isometry3d at_from_frame = Eigen::Isometry3d::Identity();
    std::string at = *from;
    for (int i = 0; i < kDeepestTree; ++i) {
      if (from == &target) {
        above_target.emplace(at, at_from_frame);
      } else if (const auto meeting = above_target.find(at); meeting != above_target.end()) {
        return meeting->second.inverse() * at_from_frame;
      }
      const auto edge = edges_.find(at);
      if (edge == edges_.end() ||
          (!edge->second.fixed && edge->second.parent_from_child.poses.size() > 1))
        break;
      at_from_frame = edge->second.parent_from_child.poses.front().world_from_cam * at_from_frame;
      at = edge->second.parent;
    }
  }
  return std::nullopt;
}

}  // namespace plumbline
