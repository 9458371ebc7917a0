// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/random.h"
#include "engine/synthetic/furniture.h"

namespace plumbline {

// Things without a model that fill a room. All stand on z = 0 with +x towards the room, unless said
// otherwise.

/// Books side by side along y.
PaintedBody BookRow(float length_m, Random& random);
/// Books lying on one another.
PaintedBody BookStack(int books, Random& random);
PaintedBody PottedPlant(float height_m, Random& random);
PaintedBody Vase(Random& random);
PaintedBody Bowl(Random& random);
PaintedBody Mug(Random& random);
PaintedBody CardboardBox(const Eigen::Vector3f& size_m, Random& random);
PaintedBody Basket(Random& random);
PaintedBody Laptop();
/// Leaning on something behind it (+x up its face).
PaintedBody Pillow(Random& random);
/// Hangs on the wall x = 0, its centre at the origin.
PaintedBody FramedPicture(float width_m, float height_m, Random& random);
/// A board on the wall x = 0 with books and pots; its top is at z = 0.
PaintedBody WallShelf(float length_m, Random& random);
/// Lies on the floor, long side along y.
PaintedBody Rug(float depth_m, float width_m, const Eigen::Vector3f& color,
                const Eigen::Vector3f& accent, std::uint32_t seed);
/// Hangs before the wall x = 0 from `height_m` down to the floor, centred on y = 0.
PaintedBody Curtain(float width_m, float height_m, const Eigen::Vector3f& color,
                    std::uint32_t seed);
/// A closed door in the wall x = 0, centred on y = 0.
PaintedBody Door(const Material& paint);

}  // namespace plumbline
