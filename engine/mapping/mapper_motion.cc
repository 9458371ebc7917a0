// SPDX-License-Identifier: Apache-2.0
// Whether what moves by itself stands still (docs/algorithms/outdoors.md).
#include <algorithm>
#include <cmath>

#include "engine/mapping/mapper_impl.h"

namespace plumbline {
namespace {

/// Boxes of a detector err by some per cent of their size; what they tell of a place errs by so
/// much of the distance along the ray, and of their width across it (what hides a part errs, too).
constexpr double kBoxDepthError = 0.08, kBoxSideError = 0.1;
/// What is lowest of a thing that is hidden in part is not what was expected to be: of its
/// horizontal diagonal.
constexpr double kSeenEndError = 0.1, kSeenSideError = 0.05;
constexpr float kImageBorder_px = 2;
constexpr float kSameThingIou = 0.5f;
/// Without a box for so long, another may be another thing's.
constexpr std::int64_t kLongestGap_ns = 1'000'000'000;

bool CutBy(const Box2& box, const PinholeCamera& camera) {
  return box.x0 < kImageBorder_px || box.y0 < kImageBorder_px ||
         box.x1 > static_cast<float>(camera.width) - 1 - kImageBorder_px ||
         box.y1 > static_cast<float>(camera.height) - 1 - kImageBorder_px;
}

/// Along the ray through the middle of the lower side of a box, per unit of depth.
Eigen::Vector3d RayBelow(const Box2& box, const PinholeCamera& camera,
                         const Eigen::Isometry3d& world_from_cam) {
  const Eigen::Vector2d below = camera.Bearing({box.center_x(), box.y1});
  return world_from_cam.linear() * Eigen::Vector3d(below.x(), below.y(), 1);
}

}  // namespace

std::optional<Mapper::Impl::PlaceOnGround> Mapper::Impl::PlaceBy(const Box2& box,
                                                                 const Box2& expected,
                                                                 const MapObject& object,
                                                                 const MapperInput& from) const {
  // Where the rest of a box is that the border cuts, it does not tell.
  if (expected.empty() || CutBy(box, setup.camera)) return std::nullopt;
  const Eigen::Matrix3d level_from_world = map.upright.upright_rotation().transpose();
  const Eigen::Vector3d camera_in_world = from.world_from_cam.translation();
  const CadModel& model = setup.database->model(object.mean().label);
  const double height_m = object.mean().scale * model.bounds.sizes().z();
  const auto place_of = [&](const Box2& seen) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector3d ray = RayBelow(seen, setup.camera, from.world_from_cam);
    double depth = setup.camera.fy * height_m / std::max(1.0f, seen.height());
    if (map.floor_in_world) {
      const Eigen::Vector3d up = map.floor_in_world->head<3>();
      if (up.dot(ray) >= 0) return std::nullopt;  // over the horizon
      depth = (up.dot(camera_in_world) + (*map.floor_in_world)[3]) / -up.dot(ray);
    }
    return Eigen::Vector2d((level_from_world * (camera_in_world + depth * ray)).head<2>());
  };
  const auto seen = place_of(box), foreseen = place_of(expected);
  if (!seen || !foreseen) return std::nullopt;
  const Eigen::Vector3d center =
      level_from_world * ToHypothesis(object.mean(), map).center_in_world;
  PlaceOnGround result;
  result.place_m = center.head<2>() + *seen - *foreseen;
  const Eigen::Vector2d camera = (level_from_world * camera_in_world).head<2>();
  const double distance = std::max(1e-3, (*seen - camera).norm());
  const Eigen::Vector2d along = (*seen - camera) / distance;
  const Eigen::Vector2d across(-along.y(), along.x());
  const double size = object.mean().scale * model.bounds.sizes().head<2>().norm();
  const double along_std = std::hypot(kBoxDepthError * distance, kSeenEndError * size);
  const double across_std =
      std::hypot(kBoxSideError * box.width() / setup.camera.fx * distance, kSeenSideError * size);
  result.information = along * along.transpose() / (along_std * along_std) +
                       across * across.transpose() / (across_std * across_std);
  return result;
}

MotionTest Mapper::Impl::MotionBefore(const MapObject& object, const Box2& now,
                                      std::int64_t stamp_ns) const {
  struct Seen {
    std::int64_t stamp_ns;
    Box2 box;
    PlaceOnGround place;
  };
  std::vector<Seen> seen;
  Box2 last = now;
  std::int64_t last_ns = stamp_ns;
  const std::vector<KeyFrame>& frames = memory.frames();
  for (auto key = frames.rbegin(); key != frames.rend(); ++key) {
    if (last_ns - key->input.stamp_ns > kLongestGap_ns) break;
    if (!key->input.detections) continue;
    const Box2 expected =
        AtMean(object, ViewOf(object, key->input, key->maps), nullptr).visible_box;
    const Detection* found = nullptr;
    float best = kSameThingIou;
    for (const Box2& like : {expected, last}) {
      for (const Detection& detection : key->input.detections->proposals()) {
        const float iou = Iou(detection.box, like);
        if (detection.category != object.category || iou <= best) continue;
        best = iou;
        found = &detection;
      }
      if (found != nullptr) break;  // where it stands, if it does, comes first
    }
    if (found == nullptr) continue;
    last = found->box;
    last_ns = key->input.stamp_ns;
    if (const auto place = PlaceBy(found->box, expected, object, key->input))
      seen.push_back({key->input.stamp_ns, found->box, *place});
  }
  MotionTest motion;
  for (auto sight = seen.rbegin(); sight != seen.rend(); ++sight)
    motion.Add(sight->stamp_ns, sight->box, sight->place.place_m, sight->place.information);
  return motion;
}

void Mapper::Impl::Follow(MapObject& object, const Detection* matched,
                          const MapperInput& input) const {
  const Box2 now = matched != nullptr ? matched->box : object.visible_box;
  if (object.state == ObjectState::kTentative) {
    const MotionTest before = MotionBefore(object, now, input.stamp_ns);
    // A camera that rests keeps no frames.
    if (before.boxes() >= std::min(MotionTest::kLeastBoxes, object.motion.boxes()))
      object.motion = before;
  }
  if (matched == nullptr) return;
  // A box of the thing beside it tells nothing of this one.
  if (Iou(now, object.visible_box) < kSameThingIou &&
      Iou(now, object.motion.last_box()) < kSameThingIou)
    object.motion = {};
  if (const auto place = PlaceBy(now, object.visible_box, object, input))
    object.motion.Add(input.stamp_ns, now, place->place_m, place->information);
}

}  // namespace plumbline
