// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// Whether somebody is writing a sequence into this folder (`plumbline record`): color.csv is
/// locked, which the system undoes however the writer ends.
bool IsBeingRecorded(const std::filesystem::path& folder);

/// Opens a folder in Plumbline's own layout that is being recorded, and follows it
/// (GrowingRecordingOf): rows that are appended to color.csv and imu.csv become frames and readings
/// as soon as their line has ended. What does not rise in time is left out, what is no row is left
/// out with a warning in the log. It has no poses, edges, boxes or depth. Once the writer has ended
/// it stays as it is.
/// Waits for the first two images and the first reading of an IMU, and tells `work` so. Errors:
/// as of OpenSequence; kNotFound where the recording ends before these came; kCancelled.
Result<std::shared_ptr<const Sequence>> FollowRecording(const std::filesystem::path& folder,
                                                        const WorkContext& work);

}  // namespace plumbline
