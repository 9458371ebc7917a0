// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Which networks find edges and boxes, and others to map the sequence again with. Lies over the
/// window.
class NetworksSheet {
 public:
  void Open(bool show) { open_ = show; }
  /// With the name of a file that was asked about.
  void OpenWith(const std::string& file);
  bool is_open() const { return open_; }
  void Draw(const FrameContext& context, CommandSink& sink);

 private:
  void DrawEdges(const FrameContext& context, CommandSink& sink) const;
  void DrawDetectors(const FrameContext& context, CommandSink& sink) const;
  void DrawOwn(const FrameContext& context, CommandSink& sink);

  bool open_ = false;
  char file_[1024] = "";
};

/// "kitchen/yolox_nano.onnx" is "yolox_nano"; "?" where it is not known.
std::string NetworkName(const std::string& choice);

}  // namespace plumbline
