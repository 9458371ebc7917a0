// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// Textures in the window's GL context; use and destroy while it is current.
class GlTextureStore : public TextureStore {
 public:
  ~GlTextureStore() override;
  ImTextureID Get(std::string_view name, std::uint64_t version,
                  const std::function<cv::Mat()>& make) override;

 private:
  struct Entry {
    unsigned int texture = 0;
    std::uint64_t version = 0;
    int width = 0, height = 0;
  };
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace plumbline
