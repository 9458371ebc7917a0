// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/synthetic/furnisher.h"

namespace plumbline {

// Places other than the living room, each furnished and with its walk planned.

/// `wall`: a chair stands in the half of a room that an inner wall hides from the other half, where
/// the walker goes round for more than a minute with the camera towards the chair.
void FurnishDividedRoom(Furnisher& furnisher);

/// `rows`: three rows of four equal chairs.
void FurnishSeminarRoom(Furnisher& furnisher);

/// `revisit`: two rooms at the ends of two corridors; the walk goes from one through both corridors
/// and the other back to the first.
void FurnishRoundCorridor(Furnisher& furnisher);

/// `office`: two desks face to face and what goes with them.
void FurnishOffice(Furnisher& furnisher);
/// A table with chairs before a platform with seats, a shelf and a cabinet.
void FurnishPlatformRoom(Furnisher& furnisher);

}  // namespace plumbline
