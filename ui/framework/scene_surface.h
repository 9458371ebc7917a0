// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <imgui.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "ui/files/clip_box_json.h"
#include "ui/files/saved_view.h"

namespace plumbline {

/// Of a scene's distance, by one notch of the wheel.
inline constexpr double kZoomPerNotch = 0.88;

struct MapSnapshot;
struct SequenceView;

/// What the 3-D view shows.
struct SceneLayers {
  bool models = true;
  bool truth = false;
  bool smoothed = true;  ///< What a second pass found, where there was one.
  bool scan = true;
  bool trajectory = true;
  bool frustum = true;
  bool particles = true;
  bool grid = true;
  bool own_colors = false;   ///< Models that have colours show them.
  bool truth_solid = false;  ///< The truth as grey surfaces instead of green edges.
  bool operator==(const SceneLayers&) const = default;
};

/// How an object of the frame is drawn.
struct SceneObject {
  ObjectId id;
  ImU32 color = 0;
  float opacity = 1;
  bool operator==(const SceneObject&) const = default;
};

struct SceneContent {
  std::shared_ptr<const SequenceView> sequence;
  std::shared_ptr<const MapSnapshot> snapshot;
  std::uint64_t snapshot_version = 0;
  ObjectId selected;
  int selected_particle = -1;
  SceneLayers layers;
  bool follow = false;
  bool look_through = false;  ///< From the camera of the sequence, its image behind everything.
  bool parallel = false;      ///< Without perspective; not where it looks through the camera.
  bool light = false;         ///< Theme
  std::vector<SceneObject> objects;  ///< Those of the frame that are drawn.
  ImU32 particle_color = 0;
  std::optional<ClipBox> clip;
};

/// The 3-D view as the panels know it; ui/scene implements it. Pixels count from the top left of
/// the view.
class SceneSurface {
 public:
  virtual ~SceneSurface() = default;
  virtual void SetContent(const SceneContent& content) = 0;
  /// Renders if anything has changed; `interacting`: coarser, for as long as the mouse moves.
  virtual ImTextureID Texture(int width, int height, bool interacting) = 0;
  virtual void Orbit(double dx_px, double dy_px) = 0;
  virtual void Pan(double dx_px, double dy_px) = 0;
  virtual void Zoom(double notches) = 0;
  /// Turns about what is seen at a pixel.
  virtual void FocusAt(double x_px, double y_px) = 0;
  virtual void FocusObject(ObjectId object) = 0;
  /// Looks at a place of the world, so that what is `size_m` large there fits.
  virtual void FocusPlace(const Eigen::Vector3d& in_world, double size_m) = 0;
  /// What is seen at a pixel, in world: a model, the scan, else the floor.
  virtual std::optional<Eigen::Vector3d> PointAt(double x_px, double y_px) = 0;
  virtual void Reset() = 0;
  /// Azimuth and elevation of the eye as seen from the focus.
  virtual void SetDirection(double azimuth_rad, double elevation_rad) = 0;
  /// Focus, direction and distance.
  virtual void SetCamera(const SceneCamera& camera) = 0;
  virtual std::optional<ObjectId> Pick(double x_px, double y_px) = 0;
  /// Of scan, path and truth; empty before a sequence is there.
  virtual Eigen::AlignedBox3d bounds_in_world() const = 0;
  virtual SceneCamera camera() const = 0;
  virtual double last_render_ms() const = 0;
  virtual int renders() const = 0;
  /// Between neighbouring lines of the floor grid.
  virtual double grid_step_m() const = 0;
};

}  // namespace plumbline
