// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/random.h"
#include "engine/synthetic/furniture.h"

namespace plumbline {

/// Measures of a passenger car or a small van [m], seen from its right side; lengths along it count
/// from the front. What no street has (a roof that ends before it begins) `CarBody` refuses.
struct CarShape {
  float length = 4.3f, width = 1.8f, height = 1.5f;
  float wheelbase = 2.6f, front_overhang = 0.85f, wheel_radius = 0.31f;
  float clearance = 0.2f;     ///< Below the sills.
  float nose_height = 0.7f;   ///< Of the front edge of the bonnet,
  float cowl_height = 1.0f;   ///< and of its rear edge, where the windscreen begins,
  float cowl = 1.1f;          ///< so far from the front.
  float windscreen = 0.75f;   ///< From there to the front of the roof.
  float roof_end = 3.6f;      ///< Rear edge of the roof, from the front,
  float roof_drop = 0.04f;    ///< so much lower than its highest point.
  float rear_window = 0.45f;  ///< From there to the deck or the tail.
  float deck_height = 0.95f;  ///< Of what the rear window ends at; of a pick-up, of its bed.
  float belt_height = 0.95f;  ///< Where windows begin.
};

/// Kinds of cars with the measures of the usual one, each the nearest generic shape of many.
struct CarKind {
  std::string_view name;  ///< Of the generic model.
  std::string_view note;
  CarShape shape;
  double share;  ///< Of those that park in a street; all together 1.
};
std::span<const CarKind> CarKinds();

/// One of a continuous family: a kind by its share, each of its measures varied by some per cent.
CarShape DrawCar(Random& random);

/// The mean difference between the outlines of two cars [m]: of heights over the road along the
/// side, the middles of both cars together (rms at every 5 cm of the longer one), and of half the
/// widths.
double OutlineDifference(const CarShape& a, const CarShape& b);
/// Index in CarKinds() of the generic shape with the smallest OutlineDifference.
std::size_t NearestKind(const CarShape& shape);

/// The car in its paint, with windows, wheels, lamps and plates, in the frame of models: +x front.
PaintedBody CarBody(const CarShape& shape, const Material& paint);
/// A shape of the database, in the grey that paints of cars are on average.
FurnitureModel CarModel(const std::string& name, const std::string& note, const CarShape& shape);
/// All kinds.
std::vector<FurnitureModel> GenericCars();
/// A colour as cars have them: most are white, grey or black.
Material CarPaint(Random& random);

}  // namespace plumbline
