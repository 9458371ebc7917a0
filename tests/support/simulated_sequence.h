// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/dataset/sequence.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {

/// A sequence whose images show a little patch of its own at each simulated point, without poses,
/// gravity or floor. The recording may be changed (no IMU, no place of the camera on the body).
std::shared_ptr<const Sequence> SimulatedSequence(SimulatedRecording recording);

}  // namespace plumbline
