// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core.hpp>

#include "engine/mapping/map_report.h"
#include "engine/recording/run_header.h"

namespace plumbline {

/// A header with every field set.
RunHeader RandomHeader(std::uint64_t seed);

/// A frame with every field set, floats of every kind among them (NaN, infinities, negative zero,
/// denormals).
FrameReport RandomFrame(std::uint64_t seed, int frame, int num_objects, int num_particles);

/// 960x500, with something in it.
cv::Mat RandomImage(std::uint64_t seed);

/// Every bit of a report as text, to be compared.
std::string Fingerprint(const FrameReport& report);

}  // namespace plumbline
