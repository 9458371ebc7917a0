// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/mapping/likelihood.h"
#include "engine/mapping/occlusion.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// A table that is made when somebody first asks for it, from whatever thread.
class LazyTable {
 public:
  LazyTable(EdgeMap edges, const OrientedTableOptions& options)
      : edges_(std::move(edges)), options_(options) {}
  const OrientedTable& Get() const;

 private:
  EdgeMap edges_;
  OrientedTableOptions options_;
  mutable std::once_flag once_;
  mutable std::unique_ptr<const OrientedTable> table_;
};

/// What the mapper sees of one frame.
struct MapperInput {
  int frame = 0;
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  PoseId pose_id;      ///< Of `world_from_cam`.
  int pose_epoch = 0;  ///< Of the corrections that `world_from_cam` contains.
  PoseUncertainty pose_uncertainty;
  cv::Mat image;  ///< BGR; empty: its crops are not looked at. Key frames keep none.
  EdgeMap edges;
  std::shared_ptr<const OrientedTable> table;     ///< SearchTable() of the edges.
  std::shared_ptr<const LazyTable> narrow_table;  ///< The same, to place what is afar.
  std::shared_ptr<const FrameDetections> detections;
};

/// How edges are searched for in images of that focal length, so that the search reaches equally
/// far in angle; `reach` times as far as the options say.
OrientedTableOptions SearchOptions(const MapperOptions& options, double focal_px, double reach = 1);
/// The table of `edges` that hypotheses are scored with.
std::shared_ptr<const OrientedTable> SearchTable(const EdgeMap& edges, const MapperOptions& options,
                                                 double focal_px, double reach = 1);

/// Whether a confirmed object is placed by a narrow search in that image: what errs by millimetres,
/// as models do, is right to the pixel there. Not what is large (LengthScale): its models err by
/// more.
bool IsAfar(const MapFrame& map, const PoseHypothesis& mean,
            const Eigen::Isometry3d& cam_from_world, const MapperOptions& options);
OrientedTableOptions NarrowSearchOptions(const MapperOptions& options, double focal_px);
/// Makes both tables of the input's edges.
void MakeTables(const MapperOptions& options, double focal_px, MapperInput& input);

/// A past frame in which hypotheses can be scored again.
struct KeyFrame {
  MapperInput input;
  std::vector<PlacedModel> occluders;  ///< The mean states that `maps` shows.
  bool moved = false;                  ///< Since `maps` was drawn.
  OcclusionMaps maps;
};

/// A bounded memory of past frames, spread over viewpoints. It makes the filter's search robust:
/// hypotheses that are tried late (other azimuth, other place) are judged by all that was seen, not
/// by the last frame alone.
class KeyFrameMemory {
 public:
  KeyFrameMemory(const PinholeCamera& camera, const MapperOptions& options)
      : camera_(camera), options_(options) {}

  /// Kept frames are searched as the new options say, as if they had been kept under them.
  void SetOptions(const MapperOptions& options);
  /// Keeps the frame if it shows something new: the camera is further from all kept ones than the
  /// options say. When full, forgets one of the two that are closest to each other, the older;
  /// frames of `needed` only where they would leave little room for others.
  struct Offered {
    bool kept = false;
    std::vector<int> forgotten;  ///< Frame numbers.
  };
  Offered Offer(const MapperInput& input, const std::set<int>& needed = {});
  /// How much there is new to see between two views: 1 where the camera has just moved or turned
  /// far enough for a key frame.
  double Distance(const Eigen::Isometry3d& world_from_cam_a,
                  const Eigen::Isometry3d& world_from_cam_b) const;
  /// Null if it is not kept.
  const KeyFrame* Find(int frame) const;
  /// Moves the kept frame of that pose, if its epoch is higher.
  void Correct(const PoseEstimate& pose);
  /// Draws `objects` again into the key frames where they stand elsewhere than when last drawn.
  void UpdateOcclusion(OcclusionRenderer& renderer, const std::vector<PlacedModel>& objects);
  const std::vector<KeyFrame>& frames() const { return frames_; }

  /// Bytes to restore the same memory from: frame numbers and the occluders drawn.
  std::string Save() const;
  /// Errors: kCorrupt, and what `load` returns.
  Status Restore(std::string_view bytes, const std::function<Result<MapperInput>(int frame)>& load,
                 OcclusionRenderer& renderer);

 private:
  PinholeCamera camera_;
  MapperOptions options_;
  std::vector<KeyFrame> frames_;
};

}  // namespace plumbline
