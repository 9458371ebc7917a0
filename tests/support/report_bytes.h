// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/recording/frame_codec.h"

namespace plumbline {

/// All of a report but its timings, as bytes: two reports are equal, bit for bit, if these are.
inline std::string BytesOf(FrameReport report) {
  report.timings.clear();
  std::string bytes = std::to_string(report.frame) + "|" + std::to_string(report.stamp_ns) + "|" +
                      report.skipped + "|" + EncodeFrame(report);
  for (const ObjectReport& object : report.objects) {
    bytes += std::to_string(object.id.value) + EncodeObject(object);
    if (object.particles != nullptr) bytes += EncodeParticles(*object.particles);
  }
  return bytes;
}

}  // namespace plumbline
