// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"

namespace plumbline {

/// An object that was followed, as tracklet_labels.xml of KITTI's raw data tells it.
struct KittiTracklet {
  std::string type;                 ///< As Car.
  Eigen::Vector3d size_m{0, 0, 0};  ///< Length, width, height.
  int first_frame = 0;
  struct Place {
    Eigen::Vector3d position_in_velo{0, 0, 0};  ///< Of the middle of the underside.
    double yaw_rad = 0;                         ///< About z.
  };
  std::vector<Place> places;  ///< One a frame.
};

/// Reads the XML that boost::serialization wrote (layout as of KITTI's parseTrackletXML.py: items
/// with objectType, h, w, l, first_frame and poses). Errors: kNotFound, kCorrupt, naming the file.
Result<std::vector<KittiTracklet>> ReadKittiTracklets(const std::filesystem::path& file);

}  // namespace plumbline
