// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "engine/models/model_database.h"
#include "engine/snapshot/object_look.h"

namespace plumbline {

struct MapSnapshot;

inline const cv::Size kDemoPictureSize{1440, 750};

/// One frame of the demo where there is no window: the image with boxes and mean outlines, the list
/// of objects, and in a column the edge map, the Z-buffer and the masks shaded by depth (darker is
/// closer). BGR.
cv::Mat DemoPicture(const MapSnapshot& snapshot, const ModelDatabase& database,
                    const ObjectLooks& looks);

}  // namespace plumbline
