// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/layout.h"

namespace plumbline {

/// A part of the window with a purpose of its own: its panels and the process that feeds them.
/// Inspect, the first one, is the Application's own; others implement this. Main thread only.
class Workspace {
 public:
  virtual ~Workspace() = default;
  virtual WorkspaceId id() const = 0;
  /// Whether a path that the user named is for it.
  virtual bool Takes(const std::string& path) const = 0;
  /// Opens it instead of what is open.
  virtual void Open(const std::string& path, FrameContext& context) = 0;
  /// Takes what its process has published since.
  virtual void ReadSlots(FrameContext& context) = 0;
  /// All between the top bar and the status bar.
  virtual void Draw(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) = 0;
  /// Keys of this workspace that went down in this ImGui frame.
  virtual void PostShortcuts(const FrameContext& context, CommandSink& sink) = 0;
  /// True if it took the command; asked only while it shows, but for commands to its process.
  virtual bool Handle(const Command& command) = 0;
  /// For scripts and tests.
  virtual void AddState(const FrameContext& context, nlohmann::json& state) const = 0;
  virtual nlohmann::json SaveSettings() const = 0;
  /// Ignores what it does not know.
  virtual void LoadSettings(const nlohmann::json& json) = 0;
};

}  // namespace plumbline
