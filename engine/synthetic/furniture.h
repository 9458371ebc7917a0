// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/geometry/mesh.h"
#include "engine/models/model_database.h"
#include "engine/synthetic/material.h"
#include "engine/synthetic/painted_mesh.h"

namespace plumbline {

/// A mesh together with the materials that its paints index.
struct PaintedBody {
  PaintedMesh mesh;
  std::vector<Material> materials;

  /// Adds a material and returns its paint.
  int Paint(const Material& material) {
    materials.push_back(material);
    return static_cast<int>(materials.size()) - 1;
  }
};

/// A shape of the synthetic database in the canonical frame: +z up, origin at the centre of the
/// footprint, +x front.
struct FurnitureModel {
  std::string name;
  std::string category;  ///< COCO name; `cabinet`, `lamp`, `desk` and `shelf` are our own.
  int symmetry_order = 1;
  Support support = Support::kFloor;
  bool back = false;  ///< As of CadModel.
  std::string note;
  PaintedBody body;
  double scale = 1;  ///< Of `body`, in sizes of the model that is written.
};

/// Colours that belong together.
struct FurniturePalette {
  Material wood, dark_wood, fabric, second_fabric, metal, plastic, lacquer, lampshade;
};
FurniturePalette PaletteOfSeed(std::uint64_t seed);

// Chairs: `chair_slat` and `chair_slat_arms` share all but the arm rests.
FurnitureModel SlatChair(const FurniturePalette& palette, bool arm_rests);
FurnitureModel ShellChair(const FurniturePalette& palette);
FurnitureModel OfficeChair(const FurniturePalette& palette, bool arm_rests);
FurnitureModel RoundStool(const FurniturePalette& palette);
// Tables.
FurnitureModel RectangularTable(const FurniturePalette& palette);
FurnitureModel RoundTable(const FurniturePalette& palette);
FurnitureModel CoffeeTable(const FurniturePalette& palette);
// Seats for several.
FurnitureModel WideSofa(const FurniturePalette& palette);
FurnitureModel SmallSofa(const FurniturePalette& palette);
// Screens, storage, lamps.
FurnitureModel DeskMonitor(const FurniturePalette& palette);
FurnitureModel WideTv(const FurniturePalette& palette);
FurnitureModel DoorCabinet(const FurniturePalette& palette);
FurnitureModel Sideboard(const FurniturePalette& palette);
FurnitureModel Bookshelf(const FurniturePalette& palette);
FurnitureModel FloorLamp(const FurniturePalette& palette);
FurnitureModel TableLamp(const FurniturePalette& palette);

// Of an office.
FurnitureModel StraightDesk(const FurniturePalette& palette);
FurnitureModel SideDesk(const FurniturePalette& palette);
FurnitureModel VisitorChair(const FurniturePalette& palette);
FurnitureModel BinderShelf(const FurniturePalette& palette);
FurnitureModel CubeShelf(const FurniturePalette& palette);
FurnitureModel DrawerPedestal(const FurniturePalette& palette);
FurnitureModel TallPlant();
FurnitureModel SmallPlant();

// Each in a fixed order.
/// Of a living room.
std::vector<FurnitureModel> FurnitureCatalogue(const FurniturePalette& palette);
/// The living room's and `chair_office_plain`: two kinds of chairs with and without arm rests.
std::vector<FurnitureModel> TwinCatalogue(const FurniturePalette& palette);
std::vector<FurnitureModel> OfficeCatalogue(const FurniturePalette& palette);

/// The mesh as the model database stores it: vertex colours are the mean colours of the materials.
TriangleMesh DatabaseMesh(const PaintedBody& body);

}  // namespace plumbline
