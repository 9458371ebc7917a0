// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

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

  WorkspaceId id() const override { return WorkspaceId::kAnnotate; }
  /// For what is opened from now on.
  void UseModels(const std::string& folder) { defaults_.models = folder; }
  /// What was opened last, as it was named; "": nothing.
  const std::string& source() const { return source_; }
  bool Takes(const std::string& path) const override;
  void Open(const std::string& path, FrameContext& context) override;
  void ReadSlots(FrameContext& context) override;
  void Draw(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) override;
  void PostShortcuts(const FrameContext& context, CommandSink& sink) override;
  bool Handle(const Command& command) override;
  void AddState(const FrameContext& context, nlohmann::json& state) const override;
  nlohmann::json SaveSettings() const override;
  void LoadSettings(const nlohmann::json& json) override;

 private:
  /// Has the images follow a pose that is on its way.
  void Preview();
  /// What is to be decided now, else the selected object.
  Panel& TaskPanel(const FrameContext& context);

  AnnotationChoice defaults_;
  std::string source_;
  bool software_gl_;
  std::function<void()> wake_;
  AnnotateView view_;
  std::optional<PendingPose> previewed_;
  std::unique_ptr<AnnotateSurface> scene_;
  std::unique_ptr<Panel> scene_panel_, models_, instances_, floor_, candidates_, refinement_,
      images_, instance_, sequence_, frame_, crop_;
  double left_ = 0.19, right_ = 0.77, models_share_ = 0.55, images_share_ = 0.76;  ///< Of the room.
  std::unique_ptr<AnnotationProcess> process_;  ///< Last: its thread wakes the window.
};

}  // namespace plumbline
