// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/snapshot/batch_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Many runs: a figure by recipe or over what was swept, with intervals, and the worst runs, which
/// it opens. Lies over the window.
class BatchSheet {
 public:
  void Open(bool show) { open_ = show; }
  bool is_open() const { return open_; }
  /// @param batch  Null while it is being read.
  void Draw(const FrameContext& context, const ShownBatch* batch, CommandSink& sink);

 private:
  void DrawBatch(const FrameContext& context, const ShownBatch& batch, CommandSink& sink);
  void DrawFigureChoice(const FrameContext& context, const BatchTable& table);
  void DrawWorst(const FrameContext& context, const ShownBatch& batch, CommandSink& sink);

  bool open_ = false;
  int figure_ = 1;  ///< Column of the table; "found" at first.
};

}  // namespace plumbline
