// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/sensor/camera.h"

namespace plumbline {

class MappingPipeline;

/// A model as a run names it; its index in the header is the shape label.
struct RunModel {
  std::string name;
  std::string category;  ///< COCO name.
  bool operator==(const RunModel&) const = default;
};

/// What a run was made from, and with what: the first thing in a run file.
struct RunHeader {
  nlohmann::json options = nlohmann::json::object();  ///< Every option of the mapper.
  std::uint64_t seed = 0;
  std::string program_version;
  std::string sequence_path, sequence_hash;  ///< Hash: SequenceFingerprint.
  std::string models_path, models_hash;      ///< Hash: ModelDatabase::content_hash.
  std::string detector, edges;               ///< Their Description(): kind, file, content hash.
  std::string poses = "dataset";  ///< Or "trajectory HASH", the content hash of `poses_path`.
  std::string poses_path;         ///< The trajectory that took the place of the data set's poses.
  std::vector<RunModel> models;   ///< Index = ModelId.
  Eigen::Vector3d gravity_in_world{0, 0, -1};
  std::optional<Eigen::Vector4d> floor_in_world;
  PinholeCamera camera;
  double rate_hz = 30;
  int first_frame = 0, end_frame = 0,
      frame_step = 1;  ///< The frames asked for: first, first + step ... < end.
  /// Up to this frame the run is the past of another one; options and seed count after it.
  std::optional<int> forked_after;
  std::string started;  ///< Wall-clock time in words; says nothing about the result.
};

/// What a run file says of a run of `pipeline`; the caller adds program version and time.
RunHeader HeaderOf(const MappingPipeline& pipeline);

nlohmann::json HeaderToJson(const RunHeader& header);
/// Errors: kCorrupt, with what is wrong but no file name.
Result<RunHeader> HeaderFromJson(const nlohmann::json& json);

/// Whether a run with header `now` continues a run that began with `stored` as if it had never
/// stopped: same options, seed, inputs and program; paths, dates and the last frame may differ.
/// Errors: kInvalidInput, naming what differs.
Status CheckContinues(const RunHeader& stored, const RunHeader& now);

/// Content hash of what a mapper uses of a sequence besides the images: camera, stamps, poses,
/// gravity, floor.
std::string SequenceFingerprint(const Sequence& sequence);

}  // namespace plumbline
