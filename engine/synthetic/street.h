// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/synthetic/furnisher.h"

namespace plumbline {

/// A straight street along x: a road with a lane to each side, parked cars along both kerbs,
/// pavements with trees and lamp posts, houses, the sun and the sky; some cars drive on it. What is
/// parked are cars of a continuous family; the catalogue has the generic shapes alone, and each
/// instance is told as the nearest of them. The camera drives along it (kStreet) or is carried
/// along its pavement (kPavement); its height over the road is known, the road's plane is not told.
void FurnishStreet(Furnisher& furnisher);

}  // namespace plumbline
