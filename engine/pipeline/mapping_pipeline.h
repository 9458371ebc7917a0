// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/mapping/mapper.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

/// Frames A:B:S of a sequence: from A, before B, every S-th.
struct FrameRange {
  int begin = 0;
  std::optional<int> end;
  int step = 1;
};

/// Parses "A:B" or "A:B:S" (parts may be left out). Errors: kInvalidInput.
Result<FrameRange> ParseFrameRange(std::string_view text);

/// The poses that the sequence itself has.
inline constexpr const char* kDatasetPoses = "dataset";

struct PipelineChoice {
  std::filesystem::path sequence;
  std::filesystem::path models;      ///< Empty: the sequence's own.
  std::string detector = "dataset";  ///< As CreateDetector takes it.
  std::string edges;  ///< As CreateEdgeDetector takes it; empty: dataset where there are any, else
                      ///< gradient.
  std::string poses = kDatasetPoses;  ///< Those, or a TUM trajectory (SequenceOptions::poses).
  FrameRange frames;
  std::uint64_t seed = 0;
  MapperOptions options;
};

/// Everything a run needs, from files to reports: decodes, finds edges and detects ahead on a
/// thread of its own, maps in the caller's. Use it in one thread.
class MappingPipeline {
 public:
  /// Errors: one sentence that names the file. Building viewpoint models for the first time takes
  /// seconds; `work` is told.
  static Result<std::unique_ptr<MappingPipeline>> Open(const PipelineChoice& choice,
                                                       const WorkContext& work);
  ~MappingPipeline();

  const Sequence& sequence() const;
  std::shared_ptr<const Sequence> shared_sequence() const;
  std::shared_ptr<const ModelDatabase> database() const;
  const PipelineChoice& choice() const;
  /// What the detectors say of themselves: kind, file, content hash.
  std::string detector_description() const;
  std::string edges_description() const;
  /// Likewise of the poses: "dataset" or "trajectory HASH".
  const std::string& poses_description() const;
  /// One past the last frame that the range selects.
  int end_frame() const;
  /// Frames that the range selects.
  int num_selected() const;
  /// Of those, the ones that are mapped (or skipped), the resumed ones included.
  int num_done() const;

  /// Maps the next selected frame; nothing after the last one. A frame that cannot be used gives a
  /// report with `skipped` set.
  std::optional<std::shared_ptr<const MapSnapshot>> Next();
  /// Continues after `report` bit for bit. Call before the first Next.
  /// @param options  Those of that frame; nothing: as the pipeline was opened with.
  Status Resume(const FrameReport& report, const std::optional<MapperOptions>& options = {});
  /// What a frame's snapshot shows besides the report: image, edges, Z-buffer and outlines,
  /// computed again.
  Result<std::shared_ptr<const MapSnapshot>> Recompute(const FrameReport& report);
  /// Takes effect with the next frame, whose report tells of it by a kOptionsChanged event.
  void SetOptions(const MapperOptions& options);

 private:
  struct Impl;
  explicit MappingPipeline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
