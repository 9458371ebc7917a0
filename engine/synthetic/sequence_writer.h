// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/synthetic/synthetic_options.h"

namespace plumbline {

struct SyntheticSummary {
  int frames = 0;
  int instances = 0;
  double light_seconds = 0;
  double frame_seconds = 0;  ///< All frames together.
};

/// Furnishes a room, walks through it and writes a sequence in the project's own layout into
/// `folder`: images, poses, gravity, edges, proposals, depth, masks, scene.ply, models and ground
/// truth (docs/algorithms/synthetic.md); with an IMU imu.csv, imu.json and groundtruth.csv too.
/// Tracks alone come without all that needs light: no images, models or objects. An earlier
/// synthetic sequence there is replaced; any other content is left alone and is an error. Errors:
/// kInvalidInput (options, folder in use), kIo, kCancelled (the frames written so far stay).
Result<SyntheticSummary> WriteSyntheticSequence(const SyntheticOptions& options,
                                                const std::filesystem::path& folder,
                                                const WorkContext& context);

/// The camera of the sequence: off-centre, without distortion.
Camera SyntheticCamera(const SyntheticOptions& options);

}  // namespace plumbline
