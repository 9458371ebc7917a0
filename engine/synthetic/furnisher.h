// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "engine/base/random.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/room_shell.h"

namespace plumbline {

Eigen::Isometry3d Upright(double x, double y, double z, double azimuth_rad);

/// The rectangle that a body covers on the floor.
Footprint FootprintOf(const PaintedMesh& mesh, const Eigen::Isometry3d& room_from_body);

/// Puts things into a room: single ones, and the groups that many rooms share. All lots of a room
/// are drawn here, in the order of the calls; `failed()` afterwards means that this drawing of lots
/// did not work out.
class Furnisher {
 public:
  /// Draws colours and light; the room has no size and nothing in it yet.
  Furnisher(const SyntheticOptions& options, int attempt);

  const SyntheticOptions& options() const { return options_; }
  const FurniturePalette& palette() const { return palette_; }
  Random& random() { return random_; }
  RoomStyle& style() { return style_; }
  Room& room() { return room_; }
  bool failed() const { return failed_; }
  /// The built-in demo: what matters for its looks is chosen, not drawn.
  bool demo() const { return options_.scene == SyntheticScene::kRoom && options_.seed == 1; }

  double Draw(double low, double high) { return random_.Uniform(low, high); }
  bool Chance(double probability) { return random_.Uniform() < probability; }
  /// Of the model's bounding box.
  Eigen::Vector3d Size(const std::string& model) const;

  /// Adds an instance; it must not overlap what stands there, apart from `partner` (an index of
  /// obstacles). Returns its own index of obstacles.
  int Place(const std::string& model, const Eigen::Isometry3d& room_from_object, int partner = -1);
  /// Of a thing that stands on another.
  void PlaceOnTop(const std::string& model, const Eigen::Isometry3d& room_from_object);
  void Decorate(const PaintedBody& body, const Eigen::Isometry3d& room_from_body,
                float light_spacing_m = 0.025f) {
    AddDecor(body, room_from_body, light_spacing_m, room_);
  }
  /// Keeps a place on the floor for decoration; false if it is taken.
  bool Reserve(const Footprint& footprint);
  /// Decoration standing on the floor; false (and nothing) if the place is taken.
  bool DecorateFloor(const PaintedBody& body, const Eigen::Isometry3d& room_from_body,
                     float light_spacing_m = 0.025f);

  /// A laid table with chairs round it, often on a rug.
  void ArrangeDining(const Eigen::Vector2d& center);
  /// From `from_m` to `to_m` along a wall (see RoomFromWall).
  void HangPictures(const Eigen::Isometry3d& room_from_wall, double from_m, double to_m,
                    double height_m);
  void SofaWall(int wall);
  void SideboardWall(int wall);
  void DoorWall(int wall);
  void WindowWall(int wall);

 private:
  const FurnitureModel& Model(const std::string& name) const;
  PaintedBody RenderedBody(const FurnitureModel& model) const;
  void SetTable(const Eigen::Isometry3d& room_from_table, double height, double reach_x,
                double reach_y);

  const SyntheticOptions& options_;
  Random random_;
  FurniturePalette palette_;
  RoomStyle style_;
  Room room_;
  std::map<std::string, int> counts_;
  bool failed_ = false;
};

}  // namespace plumbline
