// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tests/ui/panel_harness.h"
#include "ui/annotate/annotate_actions.h"
#include "ui/framework/actions.h"
#include "ui/framework/annotate_view.h"

namespace plumbline {

/// A 3-D view that looks straight down on the floor, 100 pixels a metre, and remembers what it was
/// asked to do. Every pixel shows the scan at the floor, and the object `under_mouse`.
class FlatAnnotateSurface : public AnnotateSurface {
 public:
  static constexpr double kPixelsPerMetre = 100;

  void SetContent(const AnnotateContent& new_content) override { content = new_content; }
  ImTextureID Texture(int, int, bool) override { return nullptr; }
  void Orbit(double dx_px, double) override { orbited += dx_px; }
  void Pan(double, double) override {}
  void Zoom(double notches) override { zoomed += notches; }
  void FocusAt(double, double) override {}
  void FocusOn(const std::string& instance) override { focused = instance; }
  void LookAtFrom(const std::string& instance, const Eigen::Vector3d& eye_in_level) override {
    focused = instance;
    looked_from = eye_in_level;
  }
  void Reset() override { ++resets; }
  void SetDirection(double, double) override {}
  std::string PickInstance(double, double) override { return under_mouse; }
  std::optional<Eigen::Vector3d> PickScan(double x_px, double y_px) override {
    if (empty) return std::nullopt;
    return Eigen::Vector3d(x_px / kPixelsPerMetre, -y_px / kPixelsPerMetre, 0);
  }
  SightLine Sight(double x_px, double y_px) const override {
    return {{x_px / kPixelsPerMetre, -y_px / kPixelsPerMetre, 10}, {0, 0, -1}};
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& in_level) const override {
    return Eigen::Vector2d(kPixelsPerMetre * in_level.x(), -kPixelsPerMetre * in_level.y());
  }
  void SetCamera(const SceneCamera& camera) override { view = camera; }
  SceneCamera camera() const override { return view; }
  double last_render_ms() const override { return 0; }
  int renders() const override { return 0; }
  double grid_step_m() const override { return 0.5; }

  AnnotateContent content;
  SceneCamera view;
  std::string under_mouse, focused;
  bool empty = false;  ///< No scan under any pixel.
  double orbited = 0, zoomed = 0;
  int resets = 0;
  std::optional<Eigen::Vector3d> looked_from;
};

/// Draws one panel of the Annotate workspace without a display, on a made-up project: an armchair
/// and a table stand on a known floor; the armchair is selected; there is a sequence.
class AnnotateHarness : public PanelHarness {
 public:
  AnnotateHarness();

  /// What the panel sees from the next frame on; may be changed.
  AnnotationSnapshot& snapshot() { return *snapshot_; }
  /// Everything that the panel writes as text in one frame, its title included.
  std::string Text(Panel& panel);
  /// Clicks into a field, which selects what is in it where it does so, types and leaves it.
  void Type(Panel& panel, const std::string& widget, const std::string& text,
            int leave_by = keys::kEnter);
  /// Presses a key and lets it go, as the workspace hears it.
  void Press(int key, bool control = false, bool shift = false, bool alt = false);

  AnnotateView view;
  FlatAnnotateSurface surface;

 private:
  std::vector<ActionGroup> actions_ = AnnotateActions();
  std::shared_ptr<AnnotationSnapshot> snapshot_ = std::make_shared<AnnotationSnapshot>();
};

/// Two candidates of a placement of the first model.
PlacementView MadeUpPlacement();

// Proposals that could be there.
RefinementView MadeUpRefinement();
FloorProposal MadeUpFloor();
ImageChecksView MadeUpChecks();
SequenceAlignmentView MadeUpAlignment();
CropView MadeUpCrop();

}  // namespace plumbline
