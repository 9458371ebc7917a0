// SPDX-License-Identifier: Apache-2.0
#pragma once

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
};
RoomStyle RandomStyle(const FurniturePalette& palette, Random& random);

/// A wall's frame: x into the room, y along the wall (to the right for one who looks at it), z up;
/// origin in the middle of the wall on the floor.
Eigen::Isometry3d RoomFromWall(const Room& room, int wall);
double WallLength(const Room& room, int wall);

/// Floor, walls, ceiling, window with the view behind it, curtains, lights and sun. Needs
/// `room.size`.
void BuildShell(const RoomStyle& style, Room& room);

/// Adds something that has no model.
void AddDecor(const PaintedBody& body, const Eigen::Isometry3d& room_from_body,
              float light_spacing_m, Room& room);

}  // namespace plumbline
