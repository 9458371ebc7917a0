// SPDX-License-Identifier: Apache-2.0
#include "tests/support/recorded_room.h"

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/mapping/map_report.h"
#include "engine/models/mesh_file.h"
#include "engine/recording/run_file.h"
#include "engine/recording/smoothed_record.h"
#include "tests/support/furniture_models.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using ParticlesPointer = std::shared_ptr<const std::vector<Particle>>;

void Check(const Status& status) { PLB_CHECK(status.ok()) << status.error().message; }

void WriteModels(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  Check(WritePly(folder / "chair.ply", MakeChair(true)));
  TriangleMesh table = MakeTable();
  table.colors.assign(table.vertices.size(), {120, 80, 40});
  Check(WritePly(folder / "table.ply", table));
  WriteText(folder / "models.json", R"({"units": "m", "models": [  // two shapes
      {"name": "chair", "file": "chair.ply", "category": "chair", "support": "floor"},
      {"name": "table", "file": "table.ply", "category": "dining table", "support": "floor",
       "symmetry": {"axis": [0, 0, 1], "order": 2}}]})");
}

Eigen::Isometry3d At(double x, double y, double z, double azimuth_rad) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitZ());
}

/// Around (x, 0, 1) / z of the camera, a quarter of them somewhere else and turned.
ParticlesPointer Particles(int label, std::uint32_t draw) {
  std::vector<Particle> particles(40);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    Random random({.seed = 7, .frame = draw, .particle = static_cast<std::uint32_t>(i)});
    Particle& p = particles[i];
    const bool elsewhere = i % 4 == 0;
    p.x_c = static_cast<float>(0.02 * random.Gaussian() + (elsewhere ? 0.3 : 0));
    p.y_c = static_cast<float>(0.02 * random.Gaussian());
    p.rho = static_cast<float>(std::log(2.5) + 0.02 * random.Gaussian());
    p.azimuth = static_cast<float>(0.1 * random.Gaussian() +
                                   (elsewhere ? 1.0 : (i % 2) * std::numbers::pi));
    p.log_weight = std::log(1.0f / 40);
    p.phi_edge = static_cast<float>(random.Uniform());
    p.label = static_cast<std::uint16_t>(label);
    p.ancestor = static_cast<std::uint16_t>((i + 3) % 40);
  }
  return std::make_shared<const std::vector<Particle>>(std::move(particles));
}

ObjectReport Object(int id, int label, const Eigen::Isometry3d& pose,
                    const ParticlesPointer& particles) {
  ObjectReport object;
  object.id = {id};
  object.category = label == 0 ? "chair" : "dining table";
  object.label = {label};
  object.label_probability = {{{label}, 0.9}, {{1 - label}, 0.1}};
  object.reference_frame = 0;
  object.world_from_reference_cam.translation() = Eigen::Vector3d(0, 0, 1);
  object.world_from_object = pose;
  object.covariance.diagonal() = Eigen::Vector4d(1e-4, 2e-4, 3e-4, 4e-4);
  object.covariance(0, 3) = object.covariance(3, 0) = 1e-5;
  object.modes = {{{label}, 1, pose, std::sqrt(6e-4), 0.02}};
  object.first_frame = 0;
  object.last_frame = 3;
  object.log_evidence = 2;
  object.effective_sample_size = 30;
  object.visible_fraction = 0.5;
  object.updated = true;
  object.phi_cnn = 0.25f;
  object.phi_edge = 0.75f;
  object.whole_box = {1, 2, 30, 40};
  object.visible_box = {1, 2, 20, 30};
  object.particles = particles;
  object.filter_state = "opaque";
  if (id == 5) return object;
  object.state = ObjectState::kConfirmed;
  object.confirmed_frame = 1;
  return object;
}

FrameReport ReportOf(int number, const ParticlesPointer& of_chair) {
  FrameReport report;
  report.frame = number;
  report.stamp_ns = number * 100'000'000;
  report.world_from_cam = At(number, 0, 1, 0);
  report.timings = {{"score", 2.0 + number}};
  report.next_object_id = 6;
  if (number == 2) {
    report.skipped = "color/000002.jpg is truncated";
    return report;
  }
  report.proposals = {{{1, 2, 30, 40}, "chair", 0.5f, ProposalFate::kExplained, {1}},
                      {{5, 6, 7, 8}, "laptop", 0.25f, ProposalFate::kUnknownCategory, {-1}}};
  report.objects = {Object(1, 0, At(0, 0, 3, 0.5), of_chair)};
  if (number == 0) {
    report.events = {{EventKind::kSpawned, {1}, {}, "an unexplained chair box"}};
    return report;
  }
  ObjectReport table = Object(4, 1, At(0.1, 0.1, 3.2, 0), Particles(1, 4));
  table.modes[0].weight = 0.75;
  table.modes.push_back({{1}, 0.25, At(0.9, 0.1, 3.2, 1.0), 0.05, 0.1});
  report.objects.push_back(table);
  report.objects.push_back(Object(5, 0, At(-0.4, 0, 3.4, 1), Particles(0, 5)));
  return report;
}

void WriteParticles(const std::filesystem::path& file, const std::vector<Particle>& particles) {
  nlohmann::json json;
  for (const Particle& p : particles) {
    json["x_c"].push_back(p.x_c);
    json["y_c"].push_back(p.y_c);
    json["rho"].push_back(p.rho);
    json["azimuth"].push_back(p.azimuth);
    json["log_weight"].push_back(p.log_weight);
    json["phi_cnn"].push_back(p.phi_cnn);
    json["phi_edge"].push_back(p.phi_edge);
    json["label"].push_back(p.label);
    json["ancestor"].push_back(p.ancestor);
    json["log_scale"].push_back(p.log_scale);
  }
  Check(WriteJson(file, json));
}

}  // namespace

void WriteRecordedRoom(const std::filesystem::path& folder) {
  WriteTinySequence(folder / "walk", {.frames = 4});
  WriteModels(folder / "models");
  RunHeader header;
  header.recipe.sequence = folder / "walk";
  header.recipe.models = folder / "models";
  header.models = {{"chair", "chair"}, {"table", "dining table"}};
  header.floor_in_world = Eigen::Vector4d(0, 0, 1, 0);
  header.camera = {64, 48, 60, 60, 31.5, 23.5};
  header.rate_hz = 10;
  header.end_frame = 4;
  const auto database = ModelDatabase::Load(folder / "models");
  PLB_CHECK(database.ok()) << database.error().message;
  header.models_hash = (*database)->content_hash();
  auto writer = RunWriter::Create(folder / "room.plb", header);
  PLB_CHECK(writer.ok()) << writer.error().message;
  const ParticlesPointer of_chair = Particles(0, 1);
  const cv::Mat image(48, 64, CV_8UC3, cv::Scalar(20, 40, 60));
  for (int i = 0; i < 4; ++i)
    Check((*writer)->Write(ReportOf(i, of_chair), i == 2 ? cv::Mat() : image));
  Check((*writer)->Close());
  const FrameReport last = ReportOf(3, of_chair);
  WriteParticles(folder / "particles.json", *last.objects[1].particles);
  SmoothedMap smoothed;
  smoothed.last_frame = 3;
  smoothed.looks = 5;
  smoothed.objects = {{last.objects[1], 1, 4, 1, 3, true, 0.8, 0.01}};
  smoothed.objects[0].belief.particles.reset();
  smoothed.objects[0].belief.world_from_object.translation().x() = 0.125;
  Check(WriteSmoothed(folder / "room.plb", smoothed));
}

}  // namespace plumbline
