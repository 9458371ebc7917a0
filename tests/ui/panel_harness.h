// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/runtime/frame_analyst.h"
#include "engine/runtime/snapshot_source.h"
#include "engine/snapshot/commands.h"
#include "ui/framework/panel.h"
#include "ui/framework/scene_surface.h"

namespace plumbline {

/// Remembers what was asked for.
class RecordingSink : public CommandSink {
 public:
  std::vector<Command> commands;
  /// The last command of that kind; null if there was none.
  template <typename C>
  const C* Last() const {
    for (auto it = commands.rbegin(); it != commands.rend(); ++it) {
      if (const C* found = Find<C>(*it)) return found;
    }
    return nullptr;
  }

 private:
  template <typename C>
  static const C* Find(const Command& command) {
    const auto* group = std::get_if<typename GroupOf<C>::type>(&command);
    return group == nullptr ? nullptr : std::get_if<C>(group);
  }
  void Send(Command command) override { commands.push_back(std::move(command)); }
};

/// Runs `make` as a real store would, and checks what it gives.
class CheckingTextures : public TextureStore {
 public:
  ImTextureID Get(std::string_view name, std::uint64_t version,
                  const std::function<cv::Mat()>& make) override;
  int pictures_made = 0;

 private:
  std::map<std::string, std::uint64_t, std::less<>> versions_;
};

/// A 3-D view that only counts what it is asked to do.
class CountingScene : public SceneSurface {
 public:
  void SetContent(const SceneContent& new_content) override { content = new_content; }
  ImTextureID Texture(int, int, bool moves) override {
    interacting = moves;
    return nullptr;
  }
  void Orbit(double dx_px, double dy_px) override { orbit_x += dx_px, orbit_y += dy_px; }
  void Pan(double dx_px, double dy_px) override { pan_x += dx_px, pan_y += dy_px; }
  void Zoom(double notches) override { zoomed += notches; }
  void FocusAt(double, double) override { ++focused; }
  void FocusObject(ObjectId) override {}
  void FocusPlace(const Eigen::Vector3d&, double) override {}
  /// Metres for pixels.
  std::optional<Eigen::Vector3d> PointAt(double x_px, double y_px) override {
    points_asked.emplace_back(x_px, y_px, 0);
    return points_asked.back();
  }
  void Reset() override {}
  void SetDirection(double, double) override {}
  void SetCamera(const SceneCamera& camera) override { view = camera; }
  std::optional<ObjectId> Pick(double, double) override { return ObjectId{2}; }
  Eigen::AlignedBox3d bounds_in_world() const override {
    return {Eigen::Vector3d(-2, -2, 0), Eigen::Vector3d(2, 2, 2)};
  }
  SceneCamera camera() const override { return view; }
  double last_render_ms() const override { return 0; }
  int renders() const override { return 0; }
  double grid_step_m() const override { return 0.5; }

  SceneContent content;
  SceneCamera view;
  double orbit_x = 0, orbit_y = 0, pan_x = 0, pan_y = 0, zoomed = 0;
  int focused = 0;
  std::vector<Eigen::Vector3d> points_asked;
  bool interacting = false;
};

/// Draws one panel without a display: ImGui builds its lists and nobody paints them.
class PanelHarness {
 public:
  PanelHarness();
  ~PanelHarness();
  PanelHarness(const PanelHarness&) = delete;
  PanelHarness& operator=(const PanelHarness&) = delete;

  /// Fills the context with this frame of the made-up room.
  void ShowFrame(int frame);
  /// What a process would have worked out of that frame for the selected object.
  void Analyse(const MapperOptions& options = {}, WatchCommand also = {});
  void Draw(Panel& panel, int frames = 1);
  /// Moves the mouse to a share of a named widget, without a button.
  void Point(Panel& panel, const std::string& widget, float x = 0.5f, float y = 0.5f);
  void Click(Panel& panel, const std::string& widget, float x = 0.5f, float y = 0.5f);
  void Drag(Panel& panel, const std::string& widget, ImVec2 from, ImVec2 to, int button);
  /// The mouse jumps there and is pressed in the same frame, moves by so many pixels, and is let
  /// go.
  void JumpAndClick(Panel& panel, const std::string& widget, ImVec2 share, ImVec2 tremor_px,
                    int button = 0);
  void Wheel(Panel& panel, const std::string& widget, float notches);

  FrameContext context;
  RecordingSink sink;
  CheckingTextures textures;
  CountingScene scene;
  WidgetLog widgets;
  ImageViewport viewport;
  ImVec2 size{600, 420};
  /// Vertices that the last frame drew: nothing is drawn where it is 0.
  int vertices = 0;

 private:
  ImVec2 At(const std::string& widget, float x, float y) const;
  std::unique_ptr<SnapshotSource> source_;
};

}  // namespace plumbline
