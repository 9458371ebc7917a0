// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/base/random.h"
#include "engine/synthetic/room.h"

namespace plumbline {

/// Colours and light of the empty room.
struct RoomStyle {
  Material floor, walls, accent_wall, ceiling, trim, frame;
  Eigen::Vector3f curtain{0.8f, 0.78f, 0.72f};
  int window_wall = 1;  ///< 0: x = +, 1: y = +, 2: x = -, 3: y = -
  int accent_wall_index = 0;
  float sun_height_deg = 32, sun_side_deg = 25;
  float sun_strength = 9, sky_strength = 7, lamp_strength = 1.6f;
  std::vector<Eigen::Vector2f> lamps{{0, 0}};  ///< Places on the ceiling [m].
};
RoomStyle RandomStyle(const FurniturePalette& palette, Random& random);

/// A wall's frame: x into the room, y along the wall (to the right for one who looks at it), z up;
/// origin in the middle of the wall on the floor.
Eigen::Isometry3d RoomFromWall(const Room& room, int wall);
double WallLength(const Room& room, int wall);

/// Floor, walls, ceiling, window with the view behind it, curtains, lights and sun. Needs
/// `room.size`.
void BuildShell(const RoomStyle& style, Room& room);

/// An inner wall from floor to ceiling: it hides what is behind it and has no model. A thick one is
/// a block that nobody enters.
struct Partition {
  Eigen::Vector2d from{0, 0}, to{0, 0};  ///< Ends of its middle line [m].
  double thickness_m = 0.12;
  double bottom_m = 0;  ///< Over 0: the wall above a doorway, under which one walks.
};
void BuildPartition(const RoomStyle& style, const Partition& partition, Room& room);

/// Raises the room from x = `from_x_m` on; nobody walks there. Returns its index of obstacles.
int BuildPlatform(const RoomStyle& style, double from_x_m, double height_m, Room& room);

/// Adds something that has no model.
void AddDecor(const PaintedBody& body, const Eigen::Isometry3d& room_from_body,
              float light_spacing_m, Room& room);

}  // namespace plumbline
