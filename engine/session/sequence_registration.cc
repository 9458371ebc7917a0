// SPDX-License-Identifier: Apache-2.0
#include "engine/session/sequence_registration.h"

#include "engine/models/mesh_file.h"
#include "engine/recording/run_summary.h"

namespace plumbline {

Result<GravityPair> GravityOf(const AnnotationDocument& document, const Sequence& sequence) {
  const auto down = sequence.gravity_in_world();
  if (!down) {
    return Error{ErrorCode::kInvalidInput, "'" + sequence.path().string() +
                                               "' does not say where down is: it needs a "
                                               "gravity.json"};
  }
  return GravityPair{down->normalized(), document.gravity_in_scan.normalized()};
}

Result<SequenceAlignment> RegisterByPicks(const AnnotationDocument& document,
                                          const Sequence& sequence,
                                          const std::vector<FramePick>& picks,
                                          const std::vector<PickedPair>& more) {
  const auto gravity = GravityOf(document, sequence);
  if (!gravity) return gravity.error();
  std::vector<PickedPair> pairs;
  for (const FramePick& pick : picks) {
    const bool exists = pick.frame >= 0 && pick.frame < sequence.num_frames();
    const auto pose = exists ? sequence.world_from_cam(pick.frame) : std::nullopt;
    if (!pose) {
      return Error{ErrorCode::kInvalidInput, "frame " + std::to_string(pick.frame) +
                                                 " has no pose; pick in another frame of 0 to " +
                                                 std::to_string(sequence.num_frames() - 1)};
    }
    const Eigen::Vector2d bearing = sequence.camera().Bearing(pick.pixel);
    pairs.push_back({pick.in_scan, WorldRay{pose->translation(),
                                            (pose->linear() * bearing.homogeneous()).normalized(),
                                            1 / sequence.camera().fx}});
  }
  pairs.insert(pairs.end(), more.begin(), more.end());
  return AlignByPairs(pairs, *gravity);
}

Result<SequenceAlignment> RegisterByPoints(const AnnotationDocument& document,
                                           const Sequence& sequence, const ScanTarget& scan,
                                           const std::filesystem::path& points,
                                           const WorkContext& work) {
  const auto gravity = GravityOf(document, sequence);
  if (!gravity) return gravity.error();
  const auto map = ReadMesh(points);
  if (!map) return map.error();
  return AlignByPoints(map->vertices, scan, *gravity, document.scan_from_world, work);
}

Result<SequenceAlignment> RegisterByObjects(const AnnotationDocument& document,
                                            const Sequence& sequence,
                                            const std::filesystem::path& run,
                                            std::vector<std::string>& names) {
  const auto gravity = GravityOf(document, sequence);
  if (!gravity) return gravity.error();
  const auto estimates = ReadEstimates(run);
  if (!estimates) return estimates.error();
  std::vector<PosedObject> mapped, annotated;
  for (const EstimatedObject& estimate : *estimates) {
    mapped.push_back({estimate.category, estimate.world_from_object});
    names.push_back(estimate.model + " " + estimate.id);
  }
  for (const AnnotatedInstance& instance : document.instances) {
    annotated.push_back({instance.category, instance.scan_from_object});
  }
  return AlignByObjects(mapped, annotated, *gravity);
}

std::optional<Eigen::Vector2d> SeenAt(const Sequence& sequence, int frame,
                                      const std::optional<Eigen::Isometry3d>& scan_from_world,
                                      const Eigen::Vector3d& in_scan) {
  if (frame < 0 || frame >= sequence.num_frames()) return std::nullopt;
  const auto world_from_cam = sequence.world_from_cam(frame);
  if (!world_from_cam) return std::nullopt;
  const Eigen::Vector3d in_cam =
      (scan_from_world.value_or(Eigen::Isometry3d::Identity()) * *world_from_cam).inverse() *
      in_scan;
  if (in_cam.z() < 0.02) return std::nullopt;
  return sequence.camera().Project(in_cam);
}

}  // namespace plumbline
