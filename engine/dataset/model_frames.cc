// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/model_frames.h"

#include <algorithm>

namespace plumbline {

const Eigen::Isometry3d* FindModelFrame(const ModelFrames& frames, const std::string& model,
                                        std::vector<std::string>& warnings) {
  if (frames.empty()) return nullptr;
  if (const auto found = frames.find(model); found != frames.end()) return &found->second;
  const std::string warning = "no model '" + model +
                              "' was built of a mesh file; its instances stand as if it had its "
                              "origin below its middle";
  if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end())
    warnings.push_back(warning);
  return nullptr;
}

}  // namespace plumbline
