// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "engine/annotation/image_check.h"

namespace plumbline {

/// An edge pixel that an object explains.
struct EdgeClaim {
  int pixel = 0;       ///< y * width + x
  float strength = 0;  ///< (0, 1]: how well, from EdgeHit.
};

/// The pixels of the edges that an object's visible outline has met, each once.
std::vector<EdgeClaim> ClaimsOf(const ImageCheck& check, cv::Size image);

/// The edges as they are left for one object: each pixel's probability times the share that the
/// object has in explaining it, own / (own + all others). What nobody claims stays as it is.
EdgeMap ShareOf(const EdgeMap& edges, std::span<const EdgeClaim> own,
                std::span<const std::vector<EdgeClaim>* const> others);

}  // namespace plumbline
