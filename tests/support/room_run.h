// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/dataset/ground_truth.h"
#include "engine/mapping/map_report.h"
#include "engine/models/model_database.h"
#include "engine/synthetic/synthetic_options.h"

namespace plumbline {

/// Frames first .. last, both included.
struct FrameRun {
  int first = 0, last = 0;
};

/// What is true of an object of a synthetic room.
struct RunInstance {
  GroundTruthInstance truth;
  int shown_frames = 0;  ///< Frames that show at least 2000 of its pixels.
  std::vector<FrameRun> hidden, truncated;
};

/// A synthetic room, filmed and mapped.
struct RoomRun {
  std::shared_ptr<const ModelDatabase> database;
  Eigen::Vector3d gravity_in_world{0, 0, -1};
  std::vector<RunInstance> instances;
  std::string main_instance;  ///< Of scenes about one object.
  std::vector<FrameRun> shaken;
  std::vector<FrameReport> reports;

  const RunInstance& Instance(const std::string& id) const;
  /// The confirmed object of the instance's category nearest to it, within half a metre.
  const ObjectReport* Find(const FrameReport& report, const RunInstance& instance) const;
};

/// A room whose light is good enough for a test, in a third of the time.
SyntheticOptions QuicklyLit(SyntheticScene scene, std::uint64_t seed);

/// Films the room into the test cache (once) and maps it with `edges` (dataset or gradient).
RoomRun MapRoom(const SyntheticOptions& options, const std::string& edges);

/// How the last map compares with the truth, over instances shown in at least 60 frames.
struct RoomFigures {
  int instances = 0, right = 0;  ///< Right: found, with the right model.
  double sum_m = 0, sum_deg = 0;
  int found = 0;
  int spurious = 0;
  std::string text;  ///< What went wrong, one line for each.
};
RoomFigures Judge(const RoomRun& run);

}  // namespace plumbline
