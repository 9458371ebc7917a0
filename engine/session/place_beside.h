// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "engine/annotation/annotation_document.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// Where a copy of an object stands beside it, as it is turned and as high: by its own width to the
/// left, the right, behind or ahead, the first side on which no other object is; further away where
/// all are taken. Without its model, half a metre to the left.
/// @param models  May be null.
/// @return scan_from_object of the copy.
Eigen::Isometry3d PlaceBeside(const AnnotatedInstance& original, const AnnotationDocument& document,
                              const ModelDatabase* models);

}  // namespace plumbline
