// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/furnisher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"
#include "engine/synthetic/decor.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;
/// Of a furnished living room.
constexpr std::size_t kMaxInstances = 8;

bool Overlap(const Footprint& a, const Footprint& b, double margin) {
  const std::array<Vector2d, 2> axes_a = {
      Vector2d(std::cos(a.azimuth_rad), std::sin(a.azimuth_rad)),
      Vector2d(-std::sin(a.azimuth_rad), std::cos(a.azimuth_rad))};
  const std::array<Vector2d, 2> axes_b = {
      Vector2d(std::cos(b.azimuth_rad), std::sin(b.azimuth_rad)),
      Vector2d(-std::sin(b.azimuth_rad), std::cos(b.azimuth_rad))};
  for (const auto& axes : {axes_a, axes_b}) {
    for (const Vector2d& axis : axes) {
      double reach = margin;
      for (int i = 0; i < 2; ++i) {
        reach += a.half_size[i] * std::abs(axes_a[i].dot(axis)) +
                 b.half_size[i] * std::abs(axes_b[i].dot(axis));
      }
      if (std::abs(axis.dot(a.center - b.center)) > reach) return false;
    }
  }
  return true;
}

}  // namespace

Eigen::Isometry3d Upright(double x, double y, double z, double azimuth) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(azimuth, Vector3d::UnitZ());
}

Footprint FootprintOf(const PaintedMesh& mesh, const Isometry3d& pose) {
  Eigen::AlignedBox3f box;
  for (const Vector3f& vertex : mesh.vertices) box.extend(vertex);
  Footprint footprint;
  footprint.azimuth_rad = std::atan2(pose(1, 0), pose(0, 0));
  footprint.center = (pose * box.center().cast<double>()).head<2>();
  footprint.half_size = 0.5 * box.sizes().head<2>().cast<double>();
  return footprint;
}

Furnisher::Furnisher(const SyntheticOptions& options, int attempt)
    : options_(options),
      random_({.seed = options.seed,
               .frame = static_cast<std::uint32_t>(attempt),
               .object = 0x524f4f4d + static_cast<std::uint32_t>(options.scene)}),
      palette_(PaletteOfSeed(options.seed)) {
  room_.catalogue = FurnitureCatalogue(palette_);
  style_ = RandomStyle(palette_, random_);
}

const FurnitureModel& Furnisher::Model(const std::string& name) const {
  for (const FurnitureModel& model : room_.catalogue) {
    if (model.name == name) return model;
  }
  PLB_CHECK(false) << "no furniture named " << name;
  return room_.catalogue.front();
}

Vector3d Furnisher::Size(const std::string& name) const {
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : Model(name).body.mesh.vertices) bounds.extend(vertex);
  return bounds.sizes().cast<double>();
}

/// What is built in the room; in the scene `variant` it differs from the model.
PaintedBody Furnisher::RenderedBody(const FurnitureModel& model) const {
  if (options_.scene == SyntheticScene::kVariant && model.name == "chair_office")
    return OfficeChair(palette_, false).body;
  return model.body;
}

bool Furnisher::Reserve(const Footprint& footprint) {
  for (const Footprint& other : room_.obstacles) {
    if (Overlap(footprint, other, 0.03)) return false;
  }
  room_.obstacles.push_back(footprint);
  return true;
}

bool Furnisher::DecorateFloor(const PaintedBody& body, const Isometry3d& pose,
                              float light_spacing_m) {
  const bool free = Reserve(FootprintOf(body.mesh, pose));
  if (free) Decorate(body, pose, light_spacing_m);
  return free;
}

int Furnisher::Place(const std::string& name, const Isometry3d& pose, int partner) {
  const FurnitureModel& model = Model(name);
  const Footprint footprint = FootprintOf(model.body.mesh, pose);
  for (std::size_t i = 0; i < room_.obstacles.size(); ++i) {
    if (static_cast<int>(i) != partner && Overlap(footprint, room_.obstacles[i], 0.03))
      failed_ = true;
  }
  room_.obstacles.push_back(footprint);
  PlaceOnTop(name, pose);
  return static_cast<int>(room_.obstacles.size()) - 1;
}

void Furnisher::PlaceOnTop(const std::string& name, const Isometry3d& pose) {
  const FurnitureModel& model = Model(name);
  RoomInstance instance;
  std::string stem = model.category;
  std::replace(stem.begin(), stem.end(), ' ', '_');
  instance.id = stem + "_" + std::to_string(++counts_[stem]);
  instance.model = model.name;
  instance.category = model.category;
  instance.room_from_object = pose;
  room_.instances.push_back(instance);
  if (options_.scene == SyntheticScene::kVariant && name == "chair_office") {
    room_.main_instance = static_cast<int>(room_.instances.size());
  }
  AddDecor(RenderedBody(model), pose, 0.025f, room_);
  room_.parts.back().instance = static_cast<int>(room_.instances.size());
}

void Furnisher::ArrangeDining(const Vector2d& center) {
  const bool twins = options_.scene == SyntheticScene::kTwins;
  const bool round = !demo() && !twins && Chance(0.35);
  const double azimuth =
      (demo() ? std::numbers::pi / 2 : (Chance(0.5) ? 0 : std::numbers::pi / 2)) +
      Draw(-0.15, 0.15);
  const Isometry3d table = Upright(center.x(), center.y(), 0, azimuth);
  const Vector3f tone = palette_.fabric.color;
  const PaintedBody rug = Rug(2.1f, 2.9f, tone * 0.7f, ColorFromHex(0xe3d6bd) * 0.9f, 21);
  const bool carpet = options_.scene != SyntheticScene::kLowContrast && Chance(0.75);
  const double lift = carpet ? 0.012 : 0.0;
  const Isometry3d raised = Eigen::Translation3d(0, 0, lift) * table;
  if (carpet) Decorate(rug, table, 0.024f);
  const int table_index = Place(round ? "table_round" : "table_rectangular", raised);
  struct Slot {
    double x, y, facing;
  };
  std::vector<Slot> slots;
  if (round) {
    const double first = Draw(0, std::numbers::pi);
    for (int i = 0; i < 4; ++i) {
      const double angle = first + i * std::numbers::pi / 2 + Draw(-0.15, 0.15);
      slots.push_back({0.53 * std::cos(angle), 0.53 * std::sin(angle), angle + std::numbers::pi});
    }
  } else {
    slots = {{0.43, 0.36, std::numbers::pi},
             {0.43, -0.36, std::numbers::pi},
             {-0.43, 0.36, 0},
             {-0.43, -0.36, 0},
             {0, 0.74, -std::numbers::pi / 2},
             {0, -0.74, std::numbers::pi / 2}};
  }
  // Of the twins, the wooden pairs sit along the table, the others at its ends.
  const std::size_t shuffled = twins ? 4 : slots.size();
  for (std::size_t i = shuffled - 1; i > 0; --i)
    std::swap(slots[i], slots[random_.Index(static_cast<std::uint32_t>(i + 1))]);
  std::vector<std::string> chairs = {"chair_slat", "chair_slat_arms", "chair_shell"};
  if (options_.scene == SyntheticScene::kVariant) {
    chairs = {"chair_office", "chair_slat"};
  } else if (twins) {
    chairs = {"chair_slat",      "chair_slat_arms", "chair_slat",
              "chair_slat_arms", "chair_office",    "chair_office_plain"};
  } else if (!demo()) {
    if (Chance(0.4)) chairs[2] = "chair_office";
    if (Chance(0.3)) chairs[0] = "chair_slat_arms";
    if (Chance(0.3)) chairs.push_back("stool_round");
  }
  for (std::size_t i = 0; i < chairs.size(); ++i) {
    const bool armed = chairs[i] == "chair_slat_arms" || chairs[i] == "chair_office";
    // How far the chair stands behind the edge; arm rests do not fit under the table top.
    const double pull = Size(chairs[i]).x() / 2 + (armed ? Draw(0.13, 0.24) : Draw(-0.11, 0.1));
    const Slot& slot = slots[i];
    const Vector2d back(-std::cos(slot.facing), -std::sin(slot.facing));
    Place(chairs[i],
          raised * Upright(slot.x + pull * back.x(), slot.y + pull * back.y(), 0,
                           slot.facing + Draw(-0.28, 0.28)),
          table_index);
  }
  SetTable(raised, Size(round ? "table_round" : "table_rectangular").z(), 0.25, round ? 0.25 : 0.5);
}

/// Things on a table top.
void Furnisher::SetTable(const Isometry3d& room_from_table, double height, double reach_x,
                         double reach_y) {
  const bool full = options_.scene == SyntheticScene::kClutter;
  std::vector<Footprint> taken;
  const auto put = [&](const PaintedBody& body) {
    for (int attempt = 0; attempt < 12; ++attempt) {
      const double azimuth = Draw(-std::numbers::pi, std::numbers::pi), y = Draw(-reach_y, reach_y),
                   x = Draw(-reach_x, reach_x);
      const Isometry3d at = Upright(x, y, height, azimuth);
      const Footprint footprint = FootprintOf(body.mesh, at);
      if (std::any_of(taken.begin(), taken.end(),
                      [&](const Footprint& other) { return Overlap(footprint, other, 0.01); }))
        continue;
      taken.push_back(footprint);
      Decorate(body, room_from_table * at, 0.015f);
      return;
    }
  };
  put(Vase(random_));
  put(Bowl(random_));
  put(Mug(random_));
  if (Chance(0.7) || full) put(BookStack(3, random_));
  if (Chance(0.4) || full) put(Laptop());
  for (int i = 0; full && i < 7; ++i) {
    put(i % 3 == 0   ? CardboardBox({0.18f, 0.24f, 0.14f}, random_)
        : i % 3 == 1 ? BookStack(5, random_)
                     : Mug(random_));
  }
}

void Furnisher::HangPictures(const Isometry3d& frame, double from, double to, double height) {
  double y = from;
  while (true) {
    const double width = Draw(0.35, 0.75), high = width * Draw(0.7, 1.35);
    if (y + width > to) return;
    const Isometry3d at = frame * Upright(0, y + width / 2, height + Draw(-0.06, 0.06), 0);
    Decorate(FramedPicture(static_cast<float>(width), static_cast<float>(high), random_), at,
             0.03f);
    y += width + Draw(0.12, 0.3);
  }
}

void Furnisher::SofaWall(int wall) {
  const Isometry3d frame = RoomFromWall(room_, wall);
  const double half = WallLength(room_, wall) / 2;
  const bool wide = demo() || Chance(0.6);
  const double shift = Draw(-0.3, 0.3);
  const Isometry3d sofa = frame * Upright(wide ? 0.50 : 0.46, shift, 0, Draw(-0.03, 0.03));
  Place(wide ? "sofa_wide" : "sofa_small", sofa);
  Decorate(Pillow(random_), sofa * Upright(-0.03, wide ? 0.62 : 0.42, 0.455, -0.15), 0.02f);
  if (Chance(0.6))
    Decorate(Pillow(random_), sofa * Upright(-0.03, wide ? -0.55 : -0.4, 0.455, 0.2), 0.02f);
  HangPictures(frame, shift - 0.8, shift + 0.9, 1.55);
  const double side = Chance(0.5) ? 1 : -1;
  const double edge = (wide ? 1.04 : 0.76);
  // A full table leaves no room for the lamp among the eight.
  if (room_.instances.size() <= kMaxInstances - 3) {
    Place("lamp_floor", frame * Upright(0.36, shift + side * (edge + 0.38), 0,
                                        Draw(-std::numbers::pi, std::numbers::pi)));
  }
  const Isometry3d corner =
      frame * Upright(0.42, std::clamp(-side * (half - 0.45), -half, half), 0, 0);
  const PaintedBody plant = PottedPlant(static_cast<float>(Draw(1.0, 1.35)), random_);
  Footprint pot = FootprintOf(plant.mesh, corner);
  pot.half_size = {0.25, 0.25};
  if (Reserve(pot)) Decorate(plant, corner, 0.06f);
}

void Furnisher::SideboardWall(int wall) {
  const Isometry3d frame = RoomFromWall(room_, wall);
  const double half = WallLength(room_, wall) / 2;
  const double shift = Draw(-0.5, 0.5);
  const Isometry3d board = frame * Upright(0.27, shift, 0, 0);
  Place("sideboard", board);
  const double top = Size("sideboard").z();
  const bool tv = demo() || Chance(0.5);
  const double screen_azimuth = Draw(-0.08, 0.08), screen_y = Draw(-0.08, 0.08);
  PlaceOnTop(tv ? "tv_wide" : "monitor_desk",
             board * Upright(-0.02, screen_y, top, screen_azimuth));
  const double side = Chance(0.5) ? 1 : -1;
  const Isometry3d books = board * Upright(0.02, side * 0.62, top, Draw(-0.5, 0.5));
  Decorate(BookStack(4, random_), books, 0.015f);
  const Isometry3d pot = board * Upright(-0.02, -side * 0.62, top, Draw(-3, 3));
  Decorate(PottedPlant(0.34f, random_), pot, 0.02f);
  const PaintedBody basket = Basket(random_);
  const Isometry3d beside = frame * Upright(0.36, shift + side * 1.15, 0, Draw(-3, 3));
  DecorateFloor(basket, beside);
  HangPictures(frame, -half + 0.3, shift - 0.85, 1.5);
  HangPictures(frame, shift + 0.85, half - 0.3, 1.5);
}

void Furnisher::DoorWall(int wall) {
  const Isometry3d frame = RoomFromWall(room_, wall);
  const double half = WallLength(room_, wall) / 2;
  const double side = Chance(0.5) ? 1 : -1;
  Decorate(Door(style_.trim), frame * Upright(0, side * (half - 0.85), 0, 0), 0.04f);
  const double x = -side * (half - 1.0);
  if (room_.instances.size() < kMaxInstances && Chance(0.7)) {
    const bool books = Chance(0.6);
    const Isometry3d shelf = frame * Upright(books ? 0.17 : 0.25, x, 0, 0);
    Place(books ? "bookshelf" : "cabinet_doors", shelf);
    for (int i = 0; books && i < 5; ++i) {
      const double length = Draw(0.35, 0.7);
      const Isometry3d row =
          shelf * Upright(-0.02, Draw(-1, 1) * (0.76 - length) / 2, 0.081 + 0.333 * i, 0);
      Decorate(BookRow(static_cast<float>(length), random_), row, 0.03f);
    }
  } else {
    Decorate(WallShelf(1.1f, random_), frame * Upright(0, x, 1.35, 0), 0.02f);
    const PaintedBody box = CardboardBox({0.34f, 0.45f, 0.3f}, random_);
    const Isometry3d at = frame * Upright(0.3, x, 0, Draw(-0.3, 0.3));
    DecorateFloor(box, at);
  }
  HangPictures(frame, -0.45, 0.5, 1.5);
}

void Furnisher::WindowWall(int wall) {
  const Isometry3d frame = RoomFromWall(room_, wall);
  const double half = WallLength(room_, wall) / 2;
  for (const double side : {-1.0, 1.0}) {
    if (!Chance(0.7)) continue;
    const PaintedBody plant = PottedPlant(static_cast<float>(Draw(0.7, 1.2)), random_);
    const Isometry3d at = frame * Upright(0.42, side * (half - 0.5), 0, Draw(-3, 3));
    Footprint pot = FootprintOf(plant.mesh, at);
    pot.half_size = {0.22, 0.22};
    if (Reserve(pot)) Decorate(plant, at, 0.06f);
  }
  HangPictures(frame, -half + 0.2, -1.75, 1.5);
  HangPictures(frame, 1.75, half - 0.2, 1.5);
}

}  // namespace plumbline
