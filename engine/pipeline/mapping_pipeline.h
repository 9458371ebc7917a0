// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <Eigen/Geometry>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/sources/live_report.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {

class ModelDatabase;
struct FrameReport;
struct MapperInput;
struct MapperSetup;
struct MapSnapshot;
struct OwnPoses;
struct OwnPoseGrowth;
struct PipelineParts;

/// A candidate that no box gave birth to.
struct PlantedObject {
  std::string model;  ///< Name in the model database.
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< Times as large as its model.
  std::string why;   ///< Told by its kSpawned event.
};

/// Everything a run needs, from files to reports: decodes, finds edges and detects ahead on threads
/// of their own, maps in the caller's. Use it in one thread.
class MappingPipeline {
 public:
  /// Errors: one sentence that names the file. Building viewpoint models for the first time takes
  /// seconds; `work` is told.
  /// @param own_poses  With poses = vio: those that a run file keeps; null, or where they end
  ///        early: they are estimated first, about 10 ms an image; while it plays, in a live run.
  static Result<std::unique_ptr<MappingPipeline>> Open(
      const RunRecipe& recipe, const WorkContext& work,
      std::shared_ptr<const OwnPoses> own_poses = {});
  /// The same with parts that are there already (pipeline_parts.h). Errors: also kUnsupported for a
  /// given sequence with poses = vio.
  static Result<std::unique_ptr<MappingPipeline>> OpenWith(PipelineParts parts,
                                                           const RunRecipe& recipe,
                                                           const WorkContext& work);
  ~MappingPipeline();

  const Sequence& sequence() const;
  std::shared_ptr<const Sequence> shared_sequence() const;
  std::shared_ptr<const ModelDatabase> database() const;
  /// Of a live run those that are known by now; null unless poses = vio.
  std::shared_ptr<const OwnPoses> own_poses() const;
  /// What has become known since they were taken last, to be kept with the run: of a live run about
  /// once a second, and after its last frame. Null otherwise.
  /// @param rest  At any time: the run ends here.
  std::shared_ptr<const OwnPoseGrowth> TakeGrownPoses(bool rest = false);
  /// What objects seen again have corrected so far; null unless poses = vio.
  const LandmarkLoops* landmarks() const;
  /// What it was opened with, complete: absolute paths, the edges chosen, the hashes of files.
  const RunRecipe& recipe() const;
  /// Whether the sequence is a recording that is followed while it is made.
  bool grows() const;
  /// One past the last frame that the range selects; of a recording that grows, so far.
  int end_frame() const;
  /// Frames that the range selects; of a recording that grows those that have come, and one more
  /// until Next has found that none comes any more.
  int num_selected() const;
  /// Of those, the ones that are mapped, skipped or passed over, the resumed ones included.
  int num_done() const;
  /// How a run that is played by the clock fares; nothing for one that maps every frame.
  std::optional<LiveReport> live() const;

  /// Maps the next selected frame, of a live run the newest; nothing after the last one, and
  /// nothing any more once `stop` is requested while it waits. A frame that cannot be used gives a
  /// report with `skipped` set. Outlines are left to those who show them (OutlinesOf).
  std::optional<std::shared_ptr<MapSnapshot>> Next(const std::stop_token& stop = {});
  /// Continues after `report` bit for bit. Call before the first Next.
  /// @param options  Those of that frame; nothing: as the pipeline was opened with.
  /// @param landmarks  What corrected poses up to that frame.
  Status Resume(const FrameReport& report, const std::optional<MapperOptions>& options = {},
                const LandmarkHistory& landmarks = {});
  /// From here on InputAgain() has the poses that a run ended with, not those that each frame was
  /// mapped with. @param landmarks  All that corrected poses.
  void LookBack(const LandmarkHistory& landmarks);
  /// After LookBack(); nothing where poses are not corrected on the way.
  std::optional<Eigen::Isometry3d> PoseInTheEnd(int frame) const;
  /// What the mapper is given of any frame of the sequence, computed again (networks are asked only
  /// for what the cache has not). Errors: why the frame cannot be used.
  Result<MapperInput> InputAgain(int frame);
  /// What the mapper is made from; with the options of the next frame.
  MapperSetup setup() const;
  /// Gives the mapper a candidate in the next frame that is used (Mapper::Plant).
  /// Errors: kNotFound (the model); kUnsupported (the filter of the paper).
  Status Plant(const PlantedObject& object);
  /// Takes effect with the next frame, whose report tells of it by a kOptionsChanged event.
  void SetOptions(const MapperOptions& options);

 private:
  struct Impl;
  explicit MappingPipeline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
