// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/floor_level.h"
#include "engine/synthetic/furniture.h"
#include "engine/synthetic/synthetic_options.h"

namespace plumbline {

/// Something in the room, its mesh in the room's frame.
struct RoomPart {
  PaintedBody body;
  int instance = 0;  ///< Number in masks, from 1; 0 for what has no model (walls, clutter).
  float light_spacing_m = 0.02f;  ///< Of the points at which light is computed.
  bool in_scan = true;  ///< Goes into scene.ply (the ceiling does not, so that one can look in).
  bool lets_light_in =
      false;  ///< The view behind a window: it is an area light and casts no shadow.
  /// Moves evenly, without turning; the mesh is where it is at time 0. Such parts come last.
  Eigen::Vector3d velocity_m_s{0, 0, 0};
};

/// A rectangle that shines towards the side from which corner, u, v turn counter-clockwise.
struct AreaLight {
  Eigen::Vector3f corner, u, v;  ///< [m]
  Eigen::Vector3f radiance;
};

struct SunLight {
  Eigen::Vector3f to_sun;      ///< unit
  Eigen::Vector3f irradiance;  ///< On a surface facing it, divided by pi.
  float radius = 0.02f;  ///< Tangent of half the angle under which it shows (hazy: larger than the
                         ///< real one's).
};

/// The sky above a street, bluer and darker upwards, with clouds; below the horizon the ground as
/// it looks from afar.
struct SkyLight {
  Eigen::Vector3f zenith{0.32f, 0.5f, 0.85f}, horizon{0.75f, 0.82f, 0.88f};  ///< Radiance.
  Eigen::Vector3f ground{0.25f, 0.25f, 0.24f};
  std::uint32_t seed = 0;

  /// @param direction  Unit vector.
  Eigen::Vector3f Radiance(const Eigen::Vector3f& direction) const;
};

/// A modelled object standing in the room.
struct RoomInstance {
  std::string id;  ///< Such as "chair_2".
  std::string model;
  std::string category;
  Eigen::Isometry3d room_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< Times as large as its model in the written database.
  /// Of a thing that is only like its model: which model of `Room::right_catalogue` it is exactly,
  /// and its own length, width and height.
  std::string right_model;
  std::optional<Eigen::Vector3d> size_m;
  Eigen::Vector3d velocity_m_s{0, 0, 0};  ///< As of its part: of what moves.

  bool moves() const { return !velocity_m_s.isZero(); }
  Eigen::Isometry3d RoomFromObjectAt(double t_s) const {
    return Eigen::Translation3d(t_s * velocity_m_s) * room_from_object;
  }
};

/// An upright block that a walker must not enter: an oriented rectangle on the floor.
struct Footprint {
  Eigen::Vector2d center{0, 0};
  Eigen::Vector2d half_size{0, 0};  ///< [m], along its own axes
  double azimuth_rad = 0;
};

/// A place on the way of a walk and what is looked at from there [m].
struct RoutePoint {
  Eigen::Vector2d stand{0, 0}, look_at{0, 0};
};

/// What the walk through the room shall do.
struct WalkPlan {
  /// Where given, the walk goes round and round along these points, which a smooth curve follows
  /// without quite reaching them; otherwise it goes round the focus.
  std::vector<RoutePoint> route;
  bool once = false;            ///< From the first point of the route to the last, and ends there.
  double start_m = 0;           ///< Of such a route: where on it the walk begins.
  double sway = 1;              ///< Times that of a walker's steps and hands.
  Eigen::Vector2d focus{0, 0};  ///< The walker goes round this point [m] ...
  double radius_m = 1.85;       ///< ... at about this distance,
  double start_angle_rad = 0;   ///< from this direction (of the walker seen from the focus)
  double sweep_rad = 3.5;       ///< turning by at most so much (signed) before going back.
  double eye_height_m = 1.45;
  double speed_m_s = 0.55;
  double focus_height_m = 0.55;  ///< Height of what is looked at.
  double gaze_offset_rad = 0;    ///< The gaze passes so far to the left of the focus.
  double exposure_s = 0.007;
  std::vector<std::pair<int, int>>
      shaken_frames;  ///< [first, last) with strong motion and a long exposure.
};

/// A furnished room: z up, floor at 0, x and y from -size/2 to size/2.
struct Room {
  Eigen::Vector3d size{0, 0, 0};  ///< [m]
  std::vector<FurnitureModel> catalogue;
  /// Where the catalogue has only the likes of what stands there: the very shapes.
  std::vector<FurnitureModel> right_catalogue;
  std::vector<RoomInstance> instances;
  std::vector<RoomPart> parts;
  std::vector<AreaLight> lights;
  std::optional<SunLight> sun;
  std::optional<SkyLight> sky;
  std::vector<Footprint> obstacles;
  std::vector<FloorLevel> levels;  ///< Beside the floor; their outlines in the room's frame.
  WalkPlan walk;
  int main_instance = 0;  ///< Number in masks of the object that the scene is about; 0 for none.
  float scan_spacing_m = 0.04f;  ///< Of scene.ply.
  /// Where the floor is not told but follows from the path: the camera's height over it [m].
  std::optional<double> camera_height_m;
};

/// All parts but those that move.
std::span<const RoomPart> StillParts(const Room& room);

/// Furnishes a room. Layouts in which a walk cannot pass are drawn again. Errors: kDegenerate if
/// none of many tries worked (a bug rather than bad luck).
Result<Room> FurnishRoom(const SyntheticOptions& options);

}  // namespace plumbline
