// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/geometry/gravity.h"
#include "engine/models/model_database.h"

namespace plumbline {

struct ObjectReport;

/// Covariance of (x, y, z of the centre in world [m], azimuth [rad]) of everything that is believed
/// of an object, where its report has that of the heaviest mode alone: over all of its particles,
/// about their mean. Without particles, over its modes: the heaviest one's covariance, what is
/// known of the others', and how far apart their origins are. With one mode, that mode's.
///
/// Azimuths are told apart modulo the symmetry of the heaviest mode's shape; a round shape has
/// none.
/// @param models  Null: symmetries are not known, and no shape has any.
Eigen::Matrix4d MixtureCovariance(const ObjectReport& object, const UprightFrame& upright,
                                  const ModelDatabase* models);

}  // namespace plumbline
