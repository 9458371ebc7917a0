// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The dialog "what if": all options of the mapper as a form. Either for a fork, with its seed and
/// its file and, while it is mapped, how far it is; or for the run that is being mapped, which then
/// goes on with other options. Lies over the window.
class ForkSheet {
 public:
  /// Begins anew with the options of the run that is open.
  void Open(const FrameContext& context, bool show);
  /// The same form for the run that is being mapped.
  void OpenOptions(const FrameContext& context, bool show);
  bool is_open() const { return open_; }
  void Draw(const FrameContext& context, CommandSink& sink);

 private:
  void DrawBody(const FrameContext& context, CommandSink& sink);
  void DrawExplanation(const FrameContext& context) const;
  void DrawPlace(const FrameContext& context);
  void DrawFilter(const FrameContext& context);
  void DrawOptions(const FrameContext& context);
  void DrawProgress(const FrameContext& context, CommandSink& sink);
  void DrawButtons(const FrameContext& context, CommandSink& sink);

  bool open_ = false;
  bool forks_ = true;    ///< Else it changes the run that is being mapped.
  std::string why_not_;  ///< Why there is no form; "": there is one.
  bool waits_ = false;   ///< Closes by itself once the fork is done.
  int frame_ = 0;
  MapperOptions before_, options_;
  int before_seed_ = 0;
  int seed_ = 0;
  char filter_[64] = "";
  char out_[1024] = "";
};

}  // namespace plumbline
