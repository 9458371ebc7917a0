// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is image_02/timestamps.txt or image_00/timestamps.txt.
Likeness ProbeKittiRaw(const std::filesystem::path& path);

/// Opens a drive of KITTI's raw data, DATE/DATE_drive_NNNN_sync (or _extract): the left colour
/// camera (image_02) or, without it, the left grey one (image_00), rectified, by the P_rect and
/// S_rect of calib_cam_to_cam.txt, and their stamps. The calibration files lie in the folder above
/// or in the drive itself.
///
/// `body` is the OXTS unit, x forward, y left, z up; its packets are the IMU (10 Hz in _sync, 100
/// Hz in _extract) and the poses, in a world with x east, y north, z up and the origin at the first
/// packet. Packets belong to images by number where there are as many of both, as in _sync, else by
/// stamp. Images without calib_velo_to_cam.txt and calib_imu_to_velo.txt have no poses. Errors:
/// kNotFound, kCorrupt, kInvalidInput, kUnsupported (images that are not rectified).
Result<std::shared_ptr<const Sequence>> OpenKittiRaw(const std::filesystem::path& folder,
                                                     const SequenceOptions& options = {});

/// tracklet_labels.xml of a drive as ground truth: what stands still, as boxes (`size_m`). Boxes
/// are told in the velodyne's frame, x forward, y left, z up, frame by frame: length along x,
/// turned about z alone, the origin in the middle of their underside. An object is taken to stand
/// still if it keeps within 1 m over all its frames; its pose is the mean, made upright. The
/// others, and those without a pose of the camera, are left out with a warning. `model` is the type
/// (car, van
/// ..), `category` COCO's name for it.
Result<std::optional<GroundTruth>> TruthOfKittiRaw(const Sequence& sequence, const ModelFrames&,
                                                   std::vector<std::string>& warnings);

}  // namespace plumbline
