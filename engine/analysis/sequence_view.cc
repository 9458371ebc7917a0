// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/sequence_view.h"

#include <algorithm>

#include "engine/analysis/aligned_pose_error.h"
#include "engine/analysis/trajectory_alignment.h"
#include "engine/base/log.h"
#include "engine/geometry/vertex_clustering.h"
#include "engine/models/mesh_file.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/recording/landmark_history.h"

namespace plumbline {
namespace {

constexpr std::size_t kScanVertices = 400'000, kCoarseScanVertices = 60'000;

std::string NameOf(const std::filesystem::path& path) {
  if (path.empty()) return "a sequence without a name";
  const std::filesystem::path clean = std::filesystem::absolute(path).lexically_normal();
  return clean.has_filename() ? clean.filename().string() : clean.parent_path().filename().string();
}

void AddTruth(const std::filesystem::path& file, SequenceView& view) {
  const Result<GroundTruth> truth = ReadGroundTruth(file);
  if (!truth.ok()) return log::warn("the truth is not shown: {}", truth.error().message);
  for (const GroundTruthInstance& instance : truth->instances)
    view.truth.push_back(ViewOfTruth(instance));
}

void AddScan(const std::filesystem::path& file, const Eigen::Isometry3d& world_from_scan,
             SequenceView& view) {
  Result<TriangleMesh> scan = ReadMesh(file);
  if (!scan.ok()) return log::warn("the scan is not shown: {}", scan.error().message);
  for (Eigen::Vector3f& vertex : scan->vertices) vertex = world_from_scan.cast<float>() * vertex;
  auto fine = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan, kScanVertices));
  view.scan_coarse =
      std::make_shared<const TriangleMesh>(ClusterToAbout(*fine, kCoarseScanVertices));
  view.scan = std::move(fine);
}

/// Of the frames by which the trajectories were aligned.
std::vector<std::optional<ToldPose>> ToldPoses(const SequenceView& view,
                                               const LandmarkLoops* corrected) {
  std::vector<std::optional<ToldPose>> told(view.given_world_from_cam.size());
  for (std::size_t i = 0; i < told.size(); ++i) {
    const auto frame = static_cast<int>(i);
    const auto known = view.own_poses->LastKnown(frame);
    if (!known || !view.given_world_from_cam[i]) continue;
    told[i] = ToldPose{known->translation(), view.own_poses->frames[i].cam_covariance};
    if (const auto moved = corrected != nullptr ? corrected->Known(PoseId{frame}) : std::nullopt)
      told[i] = ToldPose{moved->world_from_cam.translation(), moved->uncertainty.drift};
  }
  return told;
}

/// Brings the poses that the sequence was given into the world of its own poses. False where
/// nothing says how they lie to them.
bool AlignGiven(const Sequence& sequence, const LandmarkLoops* corrected, SequenceView& view) {
  const Sequence& given = GivenSequence(sequence);
  const auto alignment = AlignTrajectories(sequence, given, corrected);
  if (!alignment.ok()) return false;
  view.world_from_given = alignment->reference_from_mapped.inverse();
  view.given_world_from_cam.assign(static_cast<std::size_t>(sequence.num_frames()), std::nullopt);
  for (int i = 0; i < sequence.num_frames(); ++i) {
    if (const auto pose = given.world_from_cam(i))
      view.given_world_from_cam[static_cast<std::size_t>(i)] = view.world_from_given * *pose;
  }
  view.aligned_pose_covariance = ErrorsAfterAlignment(ToldPoses(view, corrected), view.up_in_world);
  return true;
}

/// Where the poses are the filter's, brings the poses that the sequence was given into its world,
/// and says where the rest of what was given lies there.
void AddOwnPoses(const Sequence& sequence, SequenceView& view) {
  view.own_poses = OwnPosesOf(sequence);
  if (view.own_poses == nullptr) return;
  // Without poses to compare with, what is given lies nobody knows where.
  if (!AlignGiven(sequence, nullptr, view)) view.truth.clear();
}

std::shared_ptr<const TriangleMesh> MovedMesh(const std::shared_ptr<const TriangleMesh>& mesh,
                                              const Eigen::Isometry3d& move) {
  if (mesh == nullptr) return nullptr;
  auto moved = std::make_shared<TriangleMesh>(*mesh);
  for (Eigen::Vector3f& vertex : moved->vertices) vertex = move.cast<float>() * vertex;
  return moved;
}

SequenceView ViewOf(const PinholeCamera& camera, double rate_hz, const ModelDatabase& database) {
  SequenceView view;
  view.rate_hz = rate_hz;
  view.image_width = camera.width;
  view.image_height = camera.height;
  view.fx = camera.fx;
  view.fy = camera.fy;
  view.cx = camera.cx;
  view.cy = camera.cy;
  for (const CadModel& model : database.models()) {
    view.models.push_back({model.name, model.category,
                           std::make_shared<const TriangleMesh>(model.mesh), model.center(),
                           model.symmetry.order == 0, std::max(1, model.symmetry.order),
                           model.bounds});
  }
  return view;
}

}  // namespace

SequenceView::Truth ViewOfTruth(const GroundTruthInstance& instance) {
  const TruthDeviation deviation = DeviationOf(instance);
  return {instance.id,          instance.model,        instance.world_from_object,
          deviation.position_m, deviation.azimuth_rad, instance.scale};
}

SequenceView MakeViewWithoutScan(const Sequence& sequence, const ModelDatabase& database) {
  SequenceView view = ViewOf(sequence.camera(), sequence.rate_hz(), database);
  view.name = NameOf(sequence.path());
  view.path = sequence.path().string();
  view.num_frames = sequence.num_frames();
  view.has_edges = sequence.has_edges();
  view.has_proposals = sequence.has_proposals();
  if (const auto gravity = sequence.gravity_in_world()) view.up_in_world = -gravity->normalized();
  if (const auto floor = sequence.floor_in_world()) view.floor_height_m = -(*floor)[3];
  for (int i = 0; i < view.num_frames; ++i) {
    if (const auto pose = sequence.world_from_cam(i)) view.world_from_cam.push_back(*pose);
  }
  if (const auto file = sequence.ground_truth_file()) AddTruth(*file, view);
  AddOwnPoses(sequence, view);
  for (SequenceView::Truth& truth : view.truth)
    truth.world_from_object = view.world_from_given * truth.world_from_object;
  return view;
}

SequenceView MakeSequenceView(const Sequence& sequence, const ModelDatabase& database,
                              const WorkContext& work) {
  SequenceView view = MakeViewWithoutScan(sequence, database);
  const bool placed = view.own_poses == nullptr || !view.given_world_from_cam.empty();
  if (const auto file = sequence.scene_file(); file && placed) {
    work.report({"Reading the scan"});
    AddScan(*file, view.world_from_given, view);
  }
  return view;
}

void MoveWithCorrections(const Sequence& sequence, const LandmarkLoops& corrected,
                         SequenceView& view) {
  if (corrected.empty()) return;
  view.world_from_cam.clear();
  for (int i = 0; i < view.num_frames; ++i) {
    const auto known = corrected.Known(PoseId{i});
    if (const auto pose = known ? known->world_from_cam : sequence.world_from_cam(i))
      view.world_from_cam.push_back(*pose);
  }
  const Eigen::Isometry3d given_from_world = view.world_from_given.inverse();
  if (!AlignGiven(sequence, &corrected, view)) return;
  const Eigen::Isometry3d move = view.world_from_given * given_from_world;
  for (SequenceView::Truth& truth : view.truth)
    truth.world_from_object = move * truth.world_from_object;
  view.scan = MovedMesh(view.scan, move);
  view.scan_coarse = MovedMesh(view.scan_coarse, move);
}

Status MoveWithCorrections(const std::shared_ptr<const Sequence>& sequence, RunReader& reader,
                           SequenceView& view) {
  if (view.own_poses == nullptr) return {};
  const Result<LandmarkHistory> landmarks = ReadLandmarks(reader);
  if (!landmarks.ok()) return landmarks.error();
  if (landmarks->empty()) return {};
  MoveWithCorrections(
      *sequence,
      ReplayLandmarks(sequence, reader.header().recipe, sequence->num_frames() - 1, *landmarks),
      view);
  return {};
}

SequenceView ViewWithoutSequence(const RunHeader& header, const ModelDatabase& database) {
  SequenceView view = ViewOf(header.camera, header.rate_hz, database);
  view.name = NameOf(header.recipe.sequence);
  view.path = header.recipe.sequence;
  view.num_frames = header.end_frame;
  view.up_in_world = -header.gravity_in_world.normalized();
  if (header.floor_in_world) view.floor_height_m = -(*header.floor_in_world)[3];
  return view;
}

}  // namespace plumbline
