// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/key_frames.h"

#include <algorithm>
#include <cmath>

#include "engine/geometry/angles.h"
#include "engine/mapping/bytes.h"

namespace plumbline {
namespace {

constexpr double kReferenceFocal_px = 500;  ///< Of a camera that the options in pixels are for.
constexpr double kLeastScale = 0.6, kMostScale = 3;
constexpr double kMovedDistance_m = 0.02;
constexpr double kMovedAngle_rad = 2.0 * kRadPerDeg;
constexpr double kGrown = 0.01;

double Angle(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

bool SamePlaces(const std::vector<PlacedModel>& a, const std::vector<PlacedModel>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].object != b[i].object || a[i].label != b[i].label ||
        (a[i].world_from_object.translation() - b[i].world_from_object.translation()).norm() >
            kMovedDistance_m ||
        Angle(a[i].world_from_object, b[i].world_from_object) > kMovedAngle_rad ||
        std::abs(a[i].scale - b[i].scale) > kGrown) {
      return false;
    }
  }
  return true;
}

bool Same(const PlacedModel& a, const PlacedModel& b) {
  return a.object == b.object && a.label == b.label && a.scale == b.scale &&
         a.world_from_object.matrix() == b.world_from_object.matrix();
}

}  // namespace

OrientedTableOptions SearchOptions(const MapperOptions& options, double focal_px, double reach) {
  // Edges are not localised better than this, however small the image.
  const double scale = reach * std::clamp(focal_px / kReferenceFocal_px, kLeastScale, kMostScale);
  OrientedTableOptions table;
  table.radius_px = scale * options.search_radius_px;
  table.sigma_px = scale * options.search_sigma_px;
  table.power = options.edge_power;
  return table;
}

std::shared_ptr<const OrientedTable> SearchTable(const EdgeMap& edges, const MapperOptions& options,
                                                 double focal_px, double reach) {
  return std::make_shared<const OrientedTable>(edges, SearchOptions(options, focal_px, reach));
}

bool IsAfar(const MapFrame& map, const PoseHypothesis& mean,
            const Eigen::Isometry3d& cam_from_world, const MapperOptions& options) {
  return (cam_from_world * mean.center_in_world).z() >= options.far_m &&
         map.LengthScale(mean.label) <= 1;
}

OrientedTableOptions NarrowSearchOptions(const MapperOptions& options, double focal_px) {
  OrientedTableOptions narrow = SearchOptions(options, focal_px);
  narrow.sigma_px *= options.far_search_sigma_px / options.search_sigma_px;
  return narrow;
}

void MakeTables(const MapperOptions& options, double focal_px, MapperInput& input) {
  input.table = SearchTable(input.edges, options, focal_px);
  input.narrow_table =
      std::make_shared<const LazyTable>(input.edges, NarrowSearchOptions(options, focal_px));
}

const OrientedTable& LazyTable::Get() const {
  std::call_once(once_, [&] { table_ = std::make_unique<const OrientedTable>(edges_, options_); });
  return *table_;
}

void KeyFrameMemory::SetOptions(const MapperOptions& options) {
  options_ = options;
  for (KeyFrame& key : frames_) MakeTables(options, camera_.fx, key.input);
}

double KeyFrameMemory::Distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  return std::max((a.translation() - b.translation()).norm() / options_.key_frame_distance_m,
                  Angle(a, b) / (options_.key_frame_angle_deg * kRadPerDeg));
}

const KeyFrame* KeyFrameMemory::Find(int frame) const {
  for (const KeyFrame& key : frames_) {
    if (key.input.frame == frame) return &key;
  }
  return nullptr;
}

KeyFrameMemory::Offered KeyFrameMemory::Offer(const MapperInput& input,
                                              const std::set<int>& needed) {
  Offered offered;
  for (const KeyFrame& key : frames_) {
    if (Distance(key.input.world_from_cam, input.world_from_cam) < 1.0) return offered;
  }
  offered.kept = true;
  frames_.push_back({input, {}, {}});
  frames_.back().input.image.release();
  while (static_cast<int>(frames_.size()) > options_.key_frames) {
    std::size_t drop = 0;
    double closest = std::numeric_limits<double>::infinity();
    const auto free = [&](std::size_t i) { return !needed.contains(frames_[i].input.frame); };
    std::size_t count_free = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) count_free += free(i);
    const bool spare = static_cast<int>(count_free) > options_.key_frames / 4;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (spare && !free(i)) continue;
      for (std::size_t j = spare ? 0 : i + 1; j < frames_.size(); ++j) {
        if (j == i) continue;
        const double d = Distance(frames_[i].input.world_from_cam, frames_[j].input.world_from_cam);
        if (d < closest) {
          closest = d;
          drop = i;
        }
      }
    }
    offered.forgotten.push_back(frames_[drop].input.frame);
    frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(drop));
  }
  return offered;
}

void KeyFrameMemory::Correct(const PoseEstimate& pose) {
  for (KeyFrame& key : frames_) {
    if (key.input.pose_id != pose.id || key.input.pose_epoch >= pose.epoch) continue;
    key.input.world_from_cam = pose.world_from_cam;
    key.input.pose_uncertainty = pose.uncertainty;
    key.input.pose_epoch = pose.epoch;
    key.moved = true;
  }
}

void KeyFrameMemory::UpdateOcclusion(OcclusionRenderer& renderer,
                                     const std::vector<PlacedModel>& objects) {
  for (KeyFrame& key : frames_) {
    if (!key.moved && SamePlaces(key.occluders, objects)) continue;
    const Eigen::Isometry3d cam_from_world = key.input.world_from_cam.inverse();
    // Of a long walk, most key frames show nothing of what has moved.
    const bool same_picture =
        !key.moved && key.maps.rendered().depth.empty() == objects.empty() &&
        std::ranges::equal(renderer.InView(camera_, cam_from_world, key.occluders),
                           renderer.InView(camera_, cam_from_world, objects), Same);
    key.occluders = objects;
    key.moved = false;
    if (same_picture) continue;
    key.maps = renderer.RenderOccluders(camera_, cam_from_world, objects);
  }
}

std::string KeyFrameMemory::Save() const {
  ByteWriter out;
  out.Put(static_cast<std::int32_t>(frames_.size()));
  for (const KeyFrame& key : frames_) {
    out.Put(static_cast<std::int32_t>(key.input.frame));
    out.Put(key.input.world_from_cam);
    out.Put(static_cast<std::int32_t>(key.input.pose_epoch));
    out.Put(key.moved);
    out.Put(static_cast<std::int32_t>(key.occluders.size()));
    for (const PlacedModel& placed : key.occluders) {
      out.Put(placed.object.value);
      out.Put(placed.label.value);
      out.Put(placed.world_from_object);
    }
  }
  // Scales come last and only where there are any: so it was before models could grow.
  const bool scaled = std::any_of(frames_.begin(), frames_.end(), [](const KeyFrame& key) {
    return std::any_of(key.occluders.begin(), key.occluders.end(),
                       [](const PlacedModel& placed) { return placed.scale != 1; });
  });
  for (const KeyFrame& key : frames_) {
    if (!scaled) break;
    for (const PlacedModel& placed : key.occluders) out.Put(placed.scale);
  }
  return out.Take();
}

Status KeyFrameMemory::Restore(std::string_view bytes,
                               const std::function<Result<MapperInput>(int)>& load,
                               OcclusionRenderer& renderer) {
  frames_.clear();
  ByteReader in(bytes);
  const int count = in.Get<std::int32_t>();
  for (int i = 0; i < count && in.ok(); ++i) {
    KeyFrame key;
    Result<MapperInput> input = load(in.Get<std::int32_t>());
    if (!input.ok()) return input.error();
    key.input = std::move(input).value();
    key.input.world_from_cam = in.GetPose();
    key.input.pose_epoch = in.Get<std::int32_t>();
    key.moved = in.Get<bool>();
    const int objects = in.Get<std::int32_t>();
    for (int k = 0; k < objects && in.ok(); ++k) {
      PlacedModel placed;
      placed.object.value = in.Get<std::int32_t>();
      placed.label.value = in.Get<std::int32_t>();
      placed.world_from_object = in.GetPose();
      key.occluders.push_back(placed);
    }
    if (!in.ok()) break;
    frames_.push_back(std::move(key));
  }
  const bool scaled = !in.rest().empty();
  for (KeyFrame& key : frames_) {
    for (PlacedModel& placed : key.occluders) {
      if (scaled) placed.scale = in.Get<double>();
    }
    key.maps = renderer.RenderOccluders(camera_, key.input.world_from_cam.inverse(), key.occluders);
  }
  if (!in.ok())
    return Error{ErrorCode::kCorrupt,
                 "the run's key frames are damaged, or of another version of Plumbline; start the "
                 "run again"};
  return {};
}

}  // namespace plumbline
