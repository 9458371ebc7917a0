// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace plumbline {

/// How one tells where the front of a thing is.
enum class FrontHabit {
  kNone,    ///< It has none, or none that can be seen.
  kSeat,    ///< What is high (back rest, head board, cistern) stands at the back.
  kDoors,   ///< Doors, drawers and handles are in front; the back is plain.
  kScreen,  ///< A screen: the front is flat, what holds it is at the back.
};

/// What is usual for a kind of thing that stands or lies in a room.
struct Thing {
  std::string_view name;
  bool in_coco;
  double height_m, width_m, depth_m;  ///< As it stands and as one faces it.
  double spread;                      ///< Of each, the deviation of its natural logarithm.
  bool on_floor;
  FrontHabit front;
};

/// nullptr for other names.
const Thing* FindThing(std::string_view name);

/// The thing that a file or a model is named after: whole words, synonyms, in English the last one
/// that names a thing ("TVCabinet" is a cabinet, "mug_white" a cup). nullptr: none that is known.
const Thing* ThingInName(std::string_view name);

}  // namespace plumbline
