// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The dialog "fork from here": all options as a form, the seed and the new file; while a fork
/// runs, how far it is. Lies over the window.
class ForkSheet {
 public:
  /// Begins anew with the options of the run that is open.
  void Open(const FrameContext& context, bool show);
  bool is_open() const { return open_; }
  void Draw(const FrameContext& context, CommandSink& sink);

 private:
  void DrawForm(const FrameContext& context, const ForkOffer& offer, CommandSink& sink);
  void DrawOptions(const FrameContext& context, const ForkOffer& offer);
  void DrawProgress(const FrameContext& context, CommandSink& sink);
  void DrawButtons(const FrameContext& context, CommandSink& sink);

  bool open_ = false;
  bool waits_ = false;  ///< Closes by itself once the fork is done.
  int frame_ = 0;
  MapperOptions options_;
  int seed_ = 0;
  char filter_[64] = "";
  char out_[1024] = "";
};

}  // namespace plumbline
