// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/sequence_view.h"

#include <algorithm>

#include "engine/base/log.h"
#include "engine/geometry/vertex_clustering.h"
#include "engine/models/mesh_file.h"

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

void AddScan(const std::filesystem::path& file, SequenceView& view) {
  Result<TriangleMesh> scan = ReadMesh(file);
  if (!scan.ok()) return log::warn("the scan is not shown: {}", scan.error().message);
  auto fine = std::make_shared<const TriangleMesh>(ClusterToAbout(*scan, kScanVertices));
  view.scan_coarse =
      std::make_shared<const TriangleMesh>(ClusterToAbout(*fine, kCoarseScanVertices));
  view.scan = std::move(fine);
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
                           model.symmetry.order == 0, std::max(1, model.symmetry.order)});
  }
  return view;
}

}  // namespace

SequenceView::Truth ViewOfTruth(const GroundTruthInstance& instance) {
  const TruthDeviation deviation = DeviationOf(instance);
  return {instance.id, instance.model, instance.world_from_object, deviation.position_m,
          deviation.azimuth_rad};
}

SequenceView MakeViewWithoutScan(const Sequence& sequence, const ModelDatabase& database) {
  SequenceView view = ViewOf(sequence.camera(), sequence.rate_hz(), database);
  view.name = NameOf(sequence.path());
  view.path = sequence.path().string();
  view.num_frames = sequence.num_frames();
  if (const auto gravity = sequence.gravity_in_world()) view.up_in_world = -gravity->normalized();
  if (const auto floor = sequence.floor_in_world()) view.floor_height_m = -(*floor)[3];
  for (int i = 0; i < view.num_frames; ++i) {
    if (const auto pose = sequence.world_from_cam(i)) view.world_from_cam.push_back(*pose);
  }
  if (const auto file = sequence.ground_truth_file()) AddTruth(*file, view);
  return view;
}

SequenceView MakeSequenceView(const Sequence& sequence, const ModelDatabase& database,
                              const WorkContext& work) {
  SequenceView view = MakeViewWithoutScan(sequence, database);
  if (const auto file = sequence.scene_file()) {
    work.report({"Reading the scan"});
    AddScan(*file, view);
  }
  return view;
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
