// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/runtime/box_run.h"

#include <fstream>

#include <opencv2/imgcodecs.hpp>

#include "tests/engine/recording/random_run.h"

namespace plumbline {

void WriteBoxModels(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "box.obj")
      << "v 0 0 0\nv 0.5 0 0\nv 0.5 0.5 0\nv 0 0.5 0\nv 0 0 0.8\nv 0.5 0 0.8\nv 0.5 0.5 0.8\nv 0 "
         "0.5 0.8\n"
         "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\n"
         "f 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream(folder / "models.json")
      << R"({"units": "m", "models": [{"name": "box", "file": "box.obj", "category": "chair"}]})";
}

void WriteBoxSequence(const std::filesystem::path& folder, int frames) {
  std::filesystem::create_directories(folder / "color");
  std::ofstream(folder / "camera.json")
      << R"({"width": 960, "height": 500, "model": "pinhole", "fx": 600, "fy": 600, "cx": 480,)"
         R"( "cy": 250, "rate_hz": 30})";
  std::ofstream(folder / "gravity.json") << R"({"gravity": [0, 0, -1]})";
  std::ofstream trajectory(folder / "trajectory.txt");
  char name[32];
  for (int i = 0; i < frames; ++i) {
    trajectory << i / 30.0 << " 0 0 1.2 -0.5 0.5 -0.5 0.5\n";
    std::snprintf(name, sizeof(name), "%06d.jpg", i);
    if (i < 8) {
      cv::imwrite((folder / "color" / name).string(), RandomImage(static_cast<std::uint64_t>(i)));
      continue;
    }
    char original[32];
    std::snprintf(original, sizeof(original), "%06d.jpg", i % 8);
    std::filesystem::create_hard_link(folder / "color" / original, folder / "color" / name);
  }
}

RunHeader HeaderOfBoxRun(const std::filesystem::path& sequence,
                         const std::filesystem::path& models) {
  RunHeader header = RandomHeader(1);
  header.recipe.sequence = sequence;
  header.recipe.models = models;
  header.models = {{"box", "chair"}};
  header.recipe.edges = EdgeChoice{EdgeSource::kGradient, {}, {}};
  header.camera = {960, 500, 600, 600, 480, 250};
  return header;
}

FrameReport FrameOfBoxRun(int frame) {
  FrameReport report = RandomFrame(5, frame, 3, 60);
  report.skipped.clear();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0, 0, 1.2);
  report.world_from_cam = pose;
  for (ObjectReport& object : report.objects) {
    object.label = {0};
    object.label_probability = {{{0}, 1.0}};
    for (auto& mode : object.modes) mode.label = {0};
    if (object.particles != nullptr) {
      auto particles = *object.particles;
      for (Particle& particle : particles) particle.label = 0;
      object.particles = std::make_shared<decltype(particles)>(std::move(particles));
    }
    object.state = ObjectState::kConfirmed;
    object.world_from_object = Eigen::Isometry3d::Identity();
    object.world_from_object.translation() = Eigen::Vector3d(2, object.id.value - 2.0, 0);
  }
  return report;
}

}  // namespace plumbline
