// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/mapping/key_frames.h"
#include "engine/mapping/map_report.h"
#include "engine/mapping/mapper_options.h"
#include "engine/mapping/particle_set.h"
#include "engine/vision/crop_comparer.h"

namespace plumbline {

struct MapperSetup {
  PinholeCamera camera;
  Eigen::Vector3d gravity_in_world{0, 0, -1};
  std::optional<Eigen::Vector4d> floor_in_world;
  double floor_std_m = 0;                     ///< Of the floor's height; 0: given.
  std::vector<FloorLevel> floor_levels = {};  ///< Beside the floor.
  std::shared_ptr<const ModelDatabase> database;
  std::shared_ptr<const HypothesisScorer> scorer;
  std::shared_ptr<CropComparer> crops = {};  ///< None: crops are not looked at.
  MapperOptions options;
  std::uint64_t seed = 0;
};

/// Without objects and points.
MapFrame MapFrameOf(const MapperSetup& setup);

/// The semantic filter (Alg. 1 of the paper; docs/algorithms/semantic_filter.md): from frames with
/// camera poses, edges and detections to posed shapes. Causal and deterministic: the first n
/// reports of a long run equal those of a run of n frames, bit for bit. Use it in one thread.
class Mapper {
 public:
  /// Errors: kUnsupported (no GL), kInvalidInput (a database without models).
  static Result<std::unique_ptr<Mapper>> Create(const MapperSetup& setup);
  ~Mapper();

  /// One frame. Frames come in time order; a frame that cannot be used is simply left out.
  FrameReport Step(const MapperInput& input);

  /// Continues after the frame of `report`, exactly as if it had never stopped. `load` gives again
  /// the inputs of past frames (edges and detections are recomputed). Errors: kCorrupt; what `load`
  /// returns.
  Status Restore(const FrameReport& report,
                 const std::function<Result<MapperInput>(int frame)>& load);

  /// The floor as it is known from the next frame on.
  /// @param floor_in_world  (a, b, c, d) with (a, b, c) = up.
  /// @param std_m  Of its height, common to all objects; 0: given.
  void SetFloor(const Eigen::Vector4d& floor_in_world, double std_m);

  /// More points of the surfaces in sight: they limit how far new objects may be, and hide what is
  /// behind them where no model explains them. A restored mapper has none.
  void AddPoints(const PoseEstimate& seen_from, std::span<const Eigen::Vector3f> points_in_world);

  /// A pose that was given before is known better: the view from it, the objects that refer to it
  /// and the points seen from it move with it. One that is not held, or of an epoch that is known,
  /// changes nothing.
  void Correct(const PoseEstimate& pose);

  /// Gives the filter a candidate in the next frame, with particles within a few centimetres and
  /// degrees of a pose: what would have become of an object that was found there? It has to gather
  /// evidence like any other.
  /// @param scale  Times as large as its model.
  void Plant(ModelId label, const Eigen::Isometry3d& world_from_object, double scale,
             const std::string& why);

  /// Takes effect with the next frame.
  void SetOptions(const MapperOptions& options);

  /// Z-buffer and ids of all mean states after the last frame, half the image's size.
  const RenderedMaps& mean_maps() const;
  /// The same for any report of this map.
  RenderedMaps RenderMeans(const FrameReport& report);

 private:
  struct Impl;
  explicit Mapper(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
