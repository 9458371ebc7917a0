// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/map_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <vtkCamera.h>
#include <vtkCellPicker.h>
#include <vtkNew.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>

#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/sequence_view.h"
#include "ui/scene/scene_actors.h"
#include "ui/scene/turntable_camera.h"
#include "ui/scene/vtk_view.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

/// The first view is from behind the cameras, a little to their side and from above.
constexpr double kOutgrown = 1.3;
constexpr double kResetAside = 0.35, kResetElevation = 0.65;

class MapScene : public SceneSurface {
 public:
  explicit MapScene(bool software_gl)
      : view_(software_gl), actors_(view_.ground(), view_.front(), software_gl) {}

  void SetContent(const SceneContent& content) override {
    const bool new_sequence = content.sequence != content_.sequence;
    // Of the same one, its truth may have moved: nobody's view of it jumps.
    const bool another =
        new_sequence && (content.sequence == nullptr || content_.sequence == nullptr ||
                         content.sequence->name != content_.sequence->name ||
                         content.sequence->path != content_.sequence->path);
    const bool changed =
        new_sequence || content.snapshot_version != content_.snapshot_version ||
        content.selected != content_.selected || content.layers != content_.layers ||
        content.selected_particle != content_.selected_particle ||
        content.follow != content_.follow || content.look_through != content_.look_through ||
        content.parallel != content_.parallel || content.light != content_.light ||
        content.objects != content_.objects || content.particle_color != content_.particle_color ||
        content.clip != content_.clip;
    if (!changed) return;
    const bool new_follow = content.follow && !content_.follow;
    content_ = content;
    dirty_ = true;
    if (content.sequence == nullptr) return;
    if (new_sequence) actors_.SetSequence(*content.sequence);
    // Poses of a live run grow: the view grows along until somebody moves it.
    if (new_sequence && !another && Framed() && Radius() > kOutgrown * framed_radius_m_) Reset();
    if (another) {
      camera_ = TurntableCamera(content.sequence->up_in_world);
      Reset();
    }
    camera_.SetParallel(content.parallel);
    view_.SetBackground(content.light);
    actors_.SetSnapshot(content);
    if (content.follow) Follow(new_follow);
  }

  ImTextureID Texture(int width, int height, bool interacting) override {
    const bool coarse = interacting && full_render_ms_ > kSlowRenderMs;
    dirty_ = view_.Resize(width, height) || dirty_;
    if (coarse != coarse_) {
      coarse_ = coarse;
      actors_.SetCoarse(coarse);
      dirty_ = true;
    }
    if (dirty_) Render();
    return view_.texture();
  }

  void Orbit(double dx_px, double dy_px) override {
    camera_.Orbit(-kOrbitPerPixel * dx_px, kOrbitPerPixel * dy_px);
    dirty_ = true;
  }
  void Pan(double dx_px, double dy_px) override {
    camera_.Pan(-dx_px / view_.height(), dy_px / view_.height());
    dirty_ = true;
  }
  void Zoom(double notches) override {
    camera_.Zoom(std::pow(kZoomPerNotch, notches));
    dirty_ = true;
  }

  void FocusAt(double x_px, double y_px) override {
    if (const auto point = WorldAt(x_px, y_px)) {
      const double away_m =
          camera_.parallel() ? camera_.distance_m() : (camera_.eye_in_world() - *point).norm();
      camera_.LookAt(*point, 0.8 * away_m);
      dirty_ = true;
    }
  }

  std::optional<Vector3d> PointAt(double x_px, double y_px) override {
    if (content_.sequence == nullptr) return std::nullopt;
    if (const auto point = WorldAt(x_px, y_px)) return point;
    return FloorAt(x_px, y_px);
  }

  void FocusObject(ObjectId object) override {
    if (content_.snapshot == nullptr || content_.sequence == nullptr) return;
    for (const ObjectReport& report : content_.snapshot->report.objects) {
      const auto label = static_cast<std::size_t>(report.label.value);
      if (report.id != object || label >= content_.sequence->models.size()) continue;
      const ModelView& model = content_.sequence->models[label];
      const Eigen::AlignedBox3d box =
          model.mesh != nullptr
              ? Scaled(BoundingBox(*model.mesh), report.scale)
              : Eigen::AlignedBox3d(Vector3d::Constant(-0.3), Vector3d::Constant(0.3));
      std::array<Vector3d, 8> corners;
      for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] =
            report.world_from_object * box.corner(Eigen::AlignedBox3d::CornerType(i));
      camera_.Frame(corners, static_cast<double>(view_.width()) / std::max(1, view_.height()));
      dirty_ = true;
    }
  }

  void FocusPlace(const Vector3d& in_world, double size_m) override {
    camera_.LookAt(in_world, 2.2 * size_m);
    dirty_ = true;
  }

  void Reset() override {
    if (content_.sequence == nullptr) return;
    const auto& bounds = actors_.focus_bounds();
    camera_.LookAt(bounds.isEmpty() ? Vector3d(0, 0, 0) : Vector3d(bounds.center()),
                   0.70 * Radius() / std::tan(0.5 * TurntableCamera::kViewAngle));
    camera_.SetDirection(actors_.ViewAzimuth(*content_.sequence) + kResetAside, kResetElevation);
    framed_radius_m_ = bounds.isEmpty() ? 0 : Radius();
    framed_from_ = camera_.eye_in_world();
    dirty_ = true;
  }

  void SetDirection(double azimuth_rad, double elevation_rad) override {
    camera_.SetDirection(azimuth_rad, elevation_rad);
    dirty_ = true;
  }

  void SetCamera(const SceneCamera& camera) override {
    camera_.LookAt(camera.focus_in_world, camera.distance_m);
    camera_.SetDirection(camera.azimuth_rad, camera.elevation_rad);
    dirty_ = true;
  }

  std::optional<ObjectId> Pick(double x_px, double y_px) override {
    view_.window()->GetState()->Reset();
    vtkNew<vtkCellPicker> picker;
    picker->SetTolerance(0.002);
    picker->PickFromListOn();
    const auto pickable = actors_.pickable();
    for (const auto& [actor, id] : pickable) picker->AddPickList(actor);
    if (picker->Pick(x_px, view_.height() - 1 - y_px, 0, view_.front()) == 0) return std::nullopt;
    for (const auto& [actor, id] : pickable) {
      if (picker->GetActor() == actor) return id;
    }
    return std::nullopt;
  }

  Eigen::AlignedBox3d bounds_in_world() const override { return actors_.bounds(); }
  SceneCamera camera() const override {
    return {camera_.focus_in_world(), camera_.azimuth_rad(),     camera_.elevation_rad(),
            camera_.distance_m(),     camera_.view_from_world(), TurntableCamera::kViewAngle,
            camera_.parallel()};
  }
  double last_render_ms() const override { return render_ms_; }
  int renders() const override { return renders_; }
  double grid_step_m() const override { return actors_.grid_step_m(); }

 private:
  /// Puts VTK's camera where that of the sequence is, so that its image fits into the view.
  void LookThrough(vtkCamera& camera) const {
    const SequenceView& sequence = *content_.sequence;
    const Eigen::Isometry3d& pose = *content_.snapshot->report.world_from_cam;
    const Vector3d eye = pose.translation(), ahead = eye + pose.linear().col(2);
    const Vector3d up = -pose.linear().col(1);
    camera.SetPosition(eye.x(), eye.y(), eye.z());
    camera.SetFocalPoint(ahead.x(), ahead.y(), ahead.z());
    camera.SetViewUp(up.x(), up.y(), up.z());
    camera.ParallelProjectionOff();
    const double image_aspect = static_cast<double>(sequence.image_width) / sequence.image_height;
    const double view_aspect = static_cast<double>(view_.width()) / view_.height();
    const double half_height =
        0.5 * sequence.image_height / sequence.fy * std::max(1.0, image_aspect / view_aspect);
    camera.SetViewAngle(2 * std::atan(half_height) * 180 / std::numbers::pi);
    camera.SetWindowCenter(
        (0.5 * (sequence.image_width - 1) - sequence.cx) / sequence.fx / half_height / view_aspect,
        (sequence.cy - 0.5 * (sequence.image_height - 1)) / sequence.fy / half_height);
  }

  /// Stays behind the camera of the sequence, turning with it.
  void Follow(bool first) {
    if (content_.snapshot == nullptr || !content_.snapshot->report.world_from_cam) return;
    const Eigen::Isometry3d& world_from_cam = *content_.snapshot->report.world_from_cam;
    const UprightFrame upright(-content_.sequence->up_in_world);
    const Vector3d forward = world_from_cam.linear().col(2);
    const double behind = WrapAngle(std::atan2(forward.dot(upright.upright_rotation().col(1)),
                                               forward.dot(upright.upright_rotation().col(0))) +
                                    std::numbers::pi);
    if (first) {
      camera_.LookAt(camera_.focus_in_world(), 4.0);
      camera_.SetDirection(behind, 0.5);
    } else {
      camera_.Orbit(WrapAngle(behind - followed_azimuth_rad_), 0);
    }
    followed_azimuth_rad_ = behind;
    camera_.MoveFocus(world_from_cam * Vector3d(0, 0, 1.0));
  }

  double Radius() const {
    const auto& bounds = actors_.focus_bounds();
    return bounds.isEmpty() ? 1.5 : std::max(0.4, 0.5 * bounds.diagonal().norm());
  }
  /// Whether the camera stands where Reset put it.
  bool Framed() const { return camera_.eye_in_world() == framed_from_; }

  std::optional<Vector3d> WorldAt(double x_px, double y_px) {
    view_.window()->GetState()->Reset();
    const int x = static_cast<int>(x_px), y = view_.height() - 1 - static_cast<int>(y_px);
    const double z = view_.front()->GetZ(x, y);  // of the upper layer only
    if (z >= 1.0) return ScanAt(x, y);
    view_.front()->SetDisplayPoint(x, y, z);
    view_.front()->DisplayToWorld();
    double point[4];
    view_.front()->GetWorldPoint(point);
    if (point[3] == 0) return std::nullopt;
    return Vector3d(point[0] / point[3], point[1] / point[3], point[2] / point[3]);
  }

  /// Where the line of sight of a pixel meets the floor.
  std::optional<Vector3d> FloorAt(double x_px, double y_px) {
    if (!content_.sequence->floor_height_m) return std::nullopt;
    const auto at = [&](double depth) {
      double point[4];
      view_.front()->SetDisplayPoint(x_px, view_.height() - 1 - y_px, depth);
      view_.front()->DisplayToWorld();
      view_.front()->GetWorldPoint(point);
      return Vector3d(Vector3d(point[0], point[1], point[2]) / point[3]);
    };
    const Vector3d near = at(0), ray = at(1) - near;
    const Vector3d& up = content_.sequence->up_in_world;
    const double fall = ray.dot(up);
    if (std::abs(fall) < 1e-9) return std::nullopt;
    const double share = (*content_.sequence->floor_height_m - near.dot(up)) / fall;
    if (share < 0 || share > 1) return std::nullopt;
    return Vector3d(near + share * ray);
  }

  std::optional<Vector3d> ScanAt(int x, int y) {
    if (actors_.scan() == nullptr) return std::nullopt;
    vtkNew<vtkCellPicker> picker;
    picker->SetTolerance(0.002);
    picker->PickFromListOn();
    picker->AddPickList(actors_.scan());
    if (picker->Pick(x, y, 0, view_.ground()) == 0) return std::nullopt;
    return Vector3d(picker->GetPickPosition());
  }

  void Render() {
    const bool through = content_.look_through && content_.snapshot != nullptr &&
                         content_.snapshot->report.world_from_cam && content_.sequence->fx > 0;
    // The grid does not count as bounds, but must not be cut off.
    const double far =
        camera_.distance_m() +
        2.0 * std::max(2.0, actors_.bounds().isEmpty() ? 0.0 : actors_.bounds().diagonal().norm());
    view_.SetCamera(camera_, std::max(0.01, 0.01 * camera_.distance_m()), far);
    if (through) {
      vtkCamera& camera = *view_.front()->GetActiveCamera();
      LookThrough(camera);
      camera.SetClippingRange(0.05, std::max(far, 1.1 * SceneActors::kBackdrop_m));
    }
    render_ms_ = view_.Render();
    if (!coarse_) full_render_ms_ = render_ms_;
    ++renders_;
    dirty_ = false;
  }

  VtkView view_;
  SceneActors actors_;
  TurntableCamera camera_;
  SceneContent content_;
  bool dirty_ = true, coarse_ = false;
  double render_ms_ = 0, full_render_ms_ = 0;
  double followed_azimuth_rad_ = 0;
  double framed_radius_m_ = 0;  ///< Of what Reset showed; 0: of nothing.
  Vector3d framed_from_{0, 0, 0};
  int renders_ = 0;
};

}  // namespace

std::unique_ptr<SceneSurface> CreateMapScene(bool software_gl) {
  return std::make_unique<MapScene>(software_gl);
}

}  // namespace plumbline
