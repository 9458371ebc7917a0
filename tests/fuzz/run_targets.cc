// SPDX-License-Identifier: Apache-2.0
// Run files: the database as a whole, its header, and the bytes of a frame without compression,
// which no mutation would get through.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/mapping/map_object.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/option_history.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_header.h"
#include "engine/recording/run_summary.h"
#include "engine/recording/smoothed_record.h"
#include "engine/vio/landmark_loops.h"
#include "engine/vio/own_pose_report.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Header(std::string_view input) {
  const auto json = ReadJson(FileOf("header.json", input));
  if (!json.ok()) return json.error();
  const auto header = HeaderFromJson(*json);
  if (!header.ok()) return header.error();
  return StatusOf(HeaderFromJson(HeaderToJson(*header)));  // what is written is read again
}

Status Recipe(std::string_view input) {
  const auto json = ReadJson(FileOf("recipe.json", input));
  if (!json.ok()) return json.error();
  const auto recipe = RecipeFromJson(*json);
  if (!recipe.ok()) return recipe.error();
  return StatusOf(RecipeFromJson(RecipeToJson(*recipe)));
}

/// As the codec stores them: the length, then zlib's stream.
std::string Compressed(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  const auto length = static_cast<std::uint32_t>(bytes.size());
  std::string stored(sizeof(length) + size, '\0');
  std::memcpy(stored.data(), &length, sizeof(length));
  compress2(reinterpret_cast<Bytef*>(stored.data() + sizeof(length)), &size,
            reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()), 1);
  stored.resize(sizeof(length) + size);
  return stored;
}

/// What objects seen again say of poses, over a walk of ten images.
Status Landmarks(std::string_view input) {
  const auto edges = LandmarkEdgesFromText(input);
  if (!edges.ok()) return edges.error();
  (void)DescribeLandmarkEdges(*edges);
  LandmarkLoops loops{LoopOptions()};
  for (int i = 0; i < 10; ++i) {
    PoseEstimate pose;
    pose.id = PoseId{i};
    pose.stamp_ns = i * 500'000'000LL;
    pose.world_from_cam.translation().x() = i;
    pose.uncertainty.drift.diagonal().setConstant(1e-4 * (i + 1));
    loops.See(pose);
  }
  (void)loops.Add(*edges);
  (void)loops.Known();
  return StatusOf(LandmarkEdgesFromText(LandmarkEdgesToText(*edges)));
}

Status FrameBytes(std::string_view input) {
  FrameReport report;
  if (const Status read = DecodeFrame(Compressed(input), report); !read.ok()) return read;
  (void)EncodeFrame(report);
  return {};
}

Status ObjectBytes(std::string_view input) {
  ObjectReport object;
  if (const Status read = DecodeObject(Compressed(input), object); !read.ok()) return read;
  (void)EncodeObject(object);
  static const auto kModels = ModelDatabase::FromModels(std::vector<CadModel>(8));
  (void)FromReport(object, *kModels);  // as a run is resumed
  return {};
}

Status ParticleBytes(std::string_view input) {
  return StatusOf(DecodeParticles(Compressed(input)));
}

Status CorrectionBytes(std::string_view input) {
  PastCorrection correction;
  if (const Status read = DecodeMoves(Compressed(input), correction); !read.ok()) return read;
  correction.image = 1;
  if (!correction.past.empty()) (void)CorrectedBy(correction, {}, {});
  return {};
}

Status OwnPoseBytes(std::string_view input) {
  OwnPoseReport report;
  if (const Status read = DecodeOwnPose(Compressed(input), report); !read.ok()) return read;
  (void)EncodeOwnPose(report);
  return {};
}

/// What is asked of the filter's poses once they are read.
void Ask(const OwnPoses& poses) {
  for (int i = 0; i < std::min(static_cast<int>(poses.frames.size()), 10); ++i) {
    (void)poses.LastKnown(i);
    (void)poses.EpochAt(i);
  }
  (void)poses.last_floor();
  (void)poses.loops.believed();
}

/// All that is asked of a run file.
Status RunFile(std::string_view input) {
  const auto file = FileOf("run.plb", input);
  const auto opened = RunReader::Open(file);
  if (!opened.ok()) return opened.error();
  RunReader& reader = **opened;
  const auto frames = reader.NumFrames();
  if (!frames.ok()) return frames.error();
  Status status = StatusOf(reader.Finished());
  const auto note = [&status](const auto& result) {
    if (status.ok()) status = StatusOf(result);
  };
  for (int i = 0; i < std::min(*frames, 10); ++i) {
    note(reader.ReadFrame(i));
    note(reader.ReadFrameBrief(i));
    note(reader.ReadThumbnail(i));
  }
  note(reader.FindFrame(3));
  note(reader.Frames());
  note(reader.Events());
  note(reader.Timings());
  note(reader.ObjectTracks());
  const auto own_poses = reader.ReadOwnPoses();
  note(own_poses);
  if (own_poses.ok() && *own_poses != nullptr) Ask(**own_poses);
  note(OptionHistory::Read(reader));
  note(ReadWithdrawn(reader));
  note(ReadEstimates(file));
  note(ReadSmoothed(file));
  note(ReadSmoothedEstimates(file));
  return status;
}

/// What `export --format json` wrote, as `evaluate` takes it.
Status Exported(std::string_view input) {
  const auto file = FileOf("map.json", input);
  (void)ReadSmoothedEstimates(file);
  return StatusOf(ReadEstimates(file));
}

constexpr std::array kRunTargets = {Target{"run_header", Header},
                                    Target{"run_recipe", Recipe},
                                    Target{"run_frame", FrameBytes},
                                    Target{"run_object", ObjectBytes},
                                    Target{"run_particles", ParticleBytes},
                                    Target{"run_correction", CorrectionBytes},
                                    Target{"run_landmarks", Landmarks},
                                    Target{"run_own_pose", OwnPoseBytes},
                                    Target{"run_file", RunFile},
                                    Target{"exported_map", Exported}};

}  // namespace

std::span<const Target> RunTargets() { return kRunTargets; }

}  // namespace plumbline::fuzz
