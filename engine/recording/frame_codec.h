// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bytes of a frame as the run file holds them, bit for bit: little-endian, compressed with zlib.
// The layout is written down in docs/run_file.md; change both and the format version together.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/mapping/map_report.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// What the table `frames` holds beside its columns: pose, proposals, timings, the mapper's state.
std::string EncodeFrame(const FrameReport& report);
/// Fills what EncodeFrame stored. Errors: kCorrupt.
Status DecodeFrame(std::string_view bytes, FrameReport& report);

/// What the table `objects` holds beside its columns; without the particles.
std::string EncodeObject(const ObjectReport& object);
Status DecodeObject(std::string_view bytes, ObjectReport& object);

/// Column by column, bytes of equal significance together, which compresses to about 3/4.
std::string EncodeParticles(const std::vector<Particle>& particles);
Result<std::vector<Particle>> DecodeParticles(std::string_view bytes);

/// Whether a number from a file is an ObjectState.
bool IsState(std::int64_t number);
/// Whether all labels are indices of the run's models: everybody who reads a run may rely on it.
bool NamesModels(const ObjectReport& object, int num_models);
bool NameModels(const std::vector<Particle>& particles, int num_models);

/// What the table `own_poses` holds of one frame.
std::string EncodeOwnPose(const OwnPoseReport& report);
Status DecodeOwnPose(std::string_view bytes, OwnPoseReport& report);
/// What the table `own_pose_moves` holds of one correction beside its columns.
std::string EncodeMoves(const PastCorrection& correction);
Status DecodeMoves(std::string_view bytes, PastCorrection& correction);

}  // namespace plumbline
