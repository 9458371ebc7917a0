// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Where the images of a sequence go, and how.
struct ImagePlaces {
  std::filesystem::path image_folder;
  std::filesystem::path depth_folder;  ///< Empty: no depth is written.
  double depth_units_per_metre = 1000;
  bool by_stamp = false;   ///< Named by the stamp in seconds, else by the frame's number.
  bool undistort = false;  ///< Even where there is no depth.
};

/// Writes images (PNG, or JPEG as the options say) and depth. Images are as recorded; they are
/// undistorted where there is depth, which belongs to the undistorted image, or `places` says so.
/// Frames that cannot be read are skipped with a warning.
/// @param written  Gets the index of each frame with its image and depth, which is empty where
/// there
///                 is none.
/// Errors: kIo, kCancelled, kInvalidInput where the sequence has no images.
Result<WrittenSequence> WriteImages(const Sequence& sequence, const ImagePlaces& places,
                                    const WriteOptions& options, const WorkContext& context,
                                    const std::function<void(int index, const std::string& image,
                                                             const std::string& depth)>& written);

/// Makes the folder, which must be new or empty, and folders in it.
Status MakeFolderFor(const std::filesystem::path& folder, const std::vector<std::string>& inside);

/// Seconds with nine digits behind the point.
std::string StampText(std::int64_t stamp_ns);

/// Whether WriteImages undistorts.
bool IsUndistortedOnWriting(const Sequence& sequence, const ImagePlaces& places);

/// Writes Plumbline's own layout: images, depth, poses, gravity, IMU, ground truth, and the scan
/// and the models where they are in its own form. Errors: kIo, kCancelled, kInvalidInput.
Result<WrittenSequence> WritePlumblineSequence(const Sequence& sequence,
                                               const std::filesystem::path& folder,
                                               const WriteOptions& options,
                                               const WorkContext& context);

}  // namespace plumbline
