// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/registration/sequence_alignment.h"

// What the ways to place a sequence in a scan share.

namespace plumbline {

/// Errors: kInvalidInput (no unit vector).
Status CheckGravity(const GravityPair& gravity);

/// The world upright in the scan, turned by nothing yet.
Eigen::Matrix3d UprightTurn(const GravityPair& gravity);

/// That, turned about up [rad] and moved [m].
Eigen::Isometry3d UprightPlace(const GravityPair& gravity, double azimuth_rad,
                               const Eigen::Vector3d& translation);

}  // namespace plumbline
