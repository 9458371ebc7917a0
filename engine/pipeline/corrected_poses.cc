// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/corrected_poses.h"

#include "engine/mapping/mapper.h"

namespace plumbline {
namespace {

/// What an object that was seen again says of the two cameras.
LandmarkEdge EdgeOf(const LandmarkSighting& sighting, const PoseEstimate& from,
                    const Eigen::Isometry3d& world_from_present_cam) {
  const double turn = sighting.azimuth_rad - sighting.azimuth_now_rad;
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();  // that takes the object to where it was
  move.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  move.translation() = sighting.center_in_world - move.linear() * sighting.center_in_world_now;
  const Eigen::Isometry3d present = move * world_from_present_cam;
  const Eigen::Vector3d arm = present.translation() - sighting.center_in_world;
  Eigen::Matrix4d to_camera = Eigen::Matrix4d::Identity();
  to_camera.col(3).head<3>() << -arm.y(), arm.x(), 0;
  LandmarkEdge edge;
  edge.object = sighting.object;
  edge.from = sighting.reference_pose;
  edge.to = sighting.present_pose;
  edge.from_cam_from_to_cam = from.world_from_cam.inverse() * present;
  edge.covariance = to_camera * sighting.covariance * to_camera.transpose();
  edge.moved_m = (sighting.center_in_world_now - sighting.center_in_world).norm();
  return edge;
}

}  // namespace

void CorrectedPoses::TellAll(Mapper& mapper) const {
  for (const PoseEstimate& pose : loops_->Known()) mapper.Correct(pose);
}

void CorrectedPoses::Take(const PoseNews& news, Mapper& mapper) {
  bool replaced = false, late = false;
  for (const auto& one : news) {
    if (const auto* points = std::get_if<PointEstimates>(&one)) {
      const PoseEstimate seen_from =
          loops_ ? loops_->AtItsTime(points->seen_from) : points->seen_from;
      const Eigen::Isometry3f move(seen_from.world_from_cam *
                                   points->seen_from.world_from_cam.inverse());
      std::vector<Eigen::Vector3f> moved = points->points_in_world;
      if (!move.matrix().isIdentity(0))
        for (Eigen::Vector3f& point : moved) point = move * point;
      mapper.AddPoints(seen_from, moved);
      const auto known = loops_ ? loops_->Known(seen_from.id) : std::nullopt;
      late = late || (known && known->epoch > seen_from.epoch);  // a resumed run is told again
      continue;
    }
    const PoseEstimate& pose = std::get<PoseEstimate>(one);
    if (loops_) loops_->See(pose);
    if (loops_ && !loops_->empty()) {
      replaced = true;
    } else {
      mapper.Correct(pose);
    }
  }
  if (replaced) loops_->Refresh();
  if (replaced || late) TellAll(mapper);
}

void CorrectedPoses::See(const std::optional<PoseEstimate>& told, MapperInput* input) {
  if (!loops_) return;
  if (told) loops_->See(*told);
  if (input == nullptr) return;
  const PoseEstimate pose =
      loops_->AtItsTime({input->pose_id, input->stamp_ns, input->world_from_cam,
                         input->pose_uncertainty, input->pose_epoch});
  input->world_from_cam = pose.world_from_cam;
  input->pose_uncertainty = pose.uncertainty;
  input->pose_epoch = pose.epoch;
}

void CorrectedPoses::CloseLoops(FrameReport& report, Mapper& mapper) {
  if (!loops_) return;
  std::vector<LandmarkEdge> edges;
  for (const LandmarkSighting& sighting : report.landmarks) {
    if (const auto known = loops_->Known(sighting.reference_pose))
      edges.push_back(EdgeOf(sighting, *known, *report.world_from_cam));
  }
  if (!loops_->Add(edges)) return;
  report.events.push_back({EventKind::kPosesCorrected,
                           edges.front().object,
                           {},
                           DescribeLandmarkEdges(edges),
                           {},
                           LandmarkEdgesToText(edges)});
  TellAll(mapper);
}

void CorrectedPoses::Add(std::span<const LandmarkEdge> edges, Mapper& mapper) {
  if (!loops_) return;
  loops_->Add(edges);
  TellAll(mapper);
}

}  // namespace plumbline
