// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/workspace.h"
#include "engine/runtime/annotation_process.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// Places models in a scan.
class AnnotateWorkspace : public Workspace {
 public:
  /// @param wake  Called from other threads when there is something new to draw.
  AnnotateWorkspace(AnnotationChoice defaults, bool software_gl, std::function<void()> wake);
  ~AnnotateWorkspace() override;

  WorkspaceTab tab() const override;
  const std::string& source() const override { return source_; }
  bool Takes(const std::string& path) const override;
  void UseModels(const std::string& folder) override { defaults_.models = folder; }
  void Open(const std::string& path, std::optional<int> frame, FrameContext& context) override;
  void ReadSlots(FrameContext& context) override;
  bool IsOpen(const FrameContext& context) const override;
  void Draw(FrameContext& context, const LayoutRect& rect, CommandSink& sink) override;
  void DrawBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) override;
  StatusLine status_line(const FrameContext& context) const override;
  const std::vector<ActionGroup>& actions() const override { return actions_; }
  void AddPaletteEntries(const FrameContext& context,
                         std::vector<PaletteEntry>& entries) const override;
  std::string WouldBeLost(const FrameContext& context) const override;
  void WatchKeys(const FrameContext& context, CommandSink& sink) override;
  void Handle(const ViewCommand& command, FrameContext& context) override;
  void Handle(const AnnotationCommand& command);
  void AddState(const FrameContext& context, nlohmann::json& state) const override;
  void SaveSettings(const FrameContext& context, nlohmann::json& settings) const override;
  void LoadSettings(const nlohmann::json& settings, FrameContext& context) override;

 private:
  /// Remembers the views of what is open.
  void KeepViews();
  /// Has the images follow a pose that is on its way.
  void Preview(const FrameContext& context);
  /// Tells that somebody is at work, so that the time is counted.
  void NoteActivity();
  /// What is to be decided now, else the selected object.
  Panel& TaskPanel(const FrameContext& context);

  AnnotationChoice defaults_;
  std::string source_;
  bool software_gl_;
  std::function<void()> wake_;
  AnnotateView view_;
  nlohmann::json kept_views_ = nlohmann::json::object();  ///< By what was opened.
  std::optional<PendingPose> previewed_;
  double activity_s_ = 0;  ///< When it was told last, by ImGui's clock.
  bool told_placing_ = false;
  std::unique_ptr<AnnotateSurface> scene_;
  std::vector<ActionGroup> actions_;
  std::unique_ptr<Panel> scene_panel_, models_, instances_, floor_, candidates_, refinement_,
      images_, instance_, sequence_, frame_, masks_, crop_;
  double left_ = 0.19, right_ = 0.77, models_share_ = 0.55, images_share_ = 0.76;  ///< Of the room.
  std::unique_ptr<AnnotationProcess> process_;  ///< Last: its thread wakes the window.
};

}  // namespace plumbline
