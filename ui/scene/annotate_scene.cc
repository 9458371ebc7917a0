// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/annotate_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellPicker.h>
#include <vtkOpenGLState.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include "engine/geometry/vertex_clustering.h"
#include "ui/framework/theme.h"
#include "ui/scene/annotate_actors.h"
#include "ui/scene/scan_picker.h"
#include "ui/scene/turntable_camera.h"
#include "ui/scene/vtk_helpers.h"
#include "ui/scene/vtk_view.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kScanResetAzimuth = -0.9, kScanResetElevation = 0.75;
constexpr double kCloudCone_px = 5;

/// Of two poses that may be missing.
template <typename T>
bool Same(const std::optional<T>& a, const std::optional<T>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || a->scan_from_object.matrix() == b->scan_from_object.matrix();
}

class AnnotateScene : public AnnotateSurface {
 public:
  explicit AnnotateScene(bool software_gl)
      : view_(software_gl), actors_(view_.ground(), view_.front(), software_gl) {}

  void SetContent(const AnnotateContent& content) override {
    if (content.version == content_.version && Same(content.pending, content_.pending) &&
        Same(content.ghost, content_.ghost) && content.candidate == content_.candidate &&
        content.scan == content_.scan && content.models == content_.models &&
        content.grid == content_.grid && content.cameras == content_.cameras &&
        content.light == content_.light && content.agreed_row == content_.agreed_row &&
        content.scan_look == content_.scan_look &&
        content.also_selected == content_.also_selected) {
      return;
    }
    content_ = content;
    dirty_ = true;
    view_.SetBackground(content.light);
    if (content.snapshot == nullptr) return;
    const bool first = actors_.SetScan(*content.snapshot);
    if (first) {
      picker_.reset();
      Reset();
    }
    actors_.SetScanLook(content.scan_look);
    actors_.Update(content);
  }

  ImTextureID Texture(int width, int height, bool interacting) override {
    const bool coarse = interacting && full_render_ms_ > kSlowRenderMs;
    dirty_ = view_.Resize(width, height) || dirty_;
    if (coarse != coarse_) {
      coarse_ = coarse;
      actors_.SetCoarse(coarse);
      dirty_ = true;
    }
    if (dirty_) {
      view_.SetCamera(camera_, std::max(0.01, 0.01 * camera_.distance_m()),
                      camera_.distance_m() + 2 * std::max(3.0, actors_.size_m()));
      render_ms_ = view_.Render();
      if (!coarse_) full_render_ms_ = render_ms_;
      ++renders_;
      dirty_ = false;
    }
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
    const auto point = PickScan(x_px, y_px);
    if (!point) return;
    camera_.LookAt(*point, 0.8 * (camera_.eye_in_world() - *point).norm());
    dirty_ = true;
  }
  void SetCamera(const SceneCamera& camera) override {
    camera_.LookAt(camera.focus_in_world, camera.distance_m);
    camera_.SetDirection(camera.azimuth_rad, camera.elevation_rad);
    dirty_ = true;
  }
  void FocusOn(const std::string& instance) override {
    const AnnotationSnapshot* snapshot = content_.snapshot.get();
    const AnnotatedInstance* found = snapshot != nullptr ? snapshot->Find(instance) : nullptr;
    const AnnotationModel* model = found != nullptr ? snapshot->ModelOf(*found) : nullptr;
    if (model == nullptr) return;
    const Vector3d center = snapshot->level_from_scan * found->scan_from_object *
                            Vector3d(found->scale * model->bounds.center().cast<double>());
    camera_.LookAt(center, 2.6 * static_cast<double>(model->bounds.diagonal().norm()));
    dirty_ = true;
  }
  void LookAtFrom(const std::string& instance, const Vector3d& eye_in_level) override {
    FocusOn(instance);
    const Vector3d back = eye_in_level - camera_.focus_in_world();
    camera_.LookAt(camera_.focus_in_world(), back.norm());
    camera_.SetDirection(std::atan2(back.y(), back.x()),
                         std::atan2(back.z(), back.head<2>().norm()));
    dirty_ = true;
  }
  void Reset() override {
    const Eigen::AlignedBox3d& box = actors_.bounds();
    const double radius = box.isEmpty() ? 2.0 : std::max(0.3, 0.5 * box.diagonal().norm());
    camera_.LookAt(box.isEmpty() ? Vector3d(0, 0, 0) : Vector3d(box.center()),
                   0.8 * radius / std::tan(0.5 * TurntableCamera::kViewAngle));
    camera_.SetDirection(kScanResetAzimuth, kScanResetElevation);
    dirty_ = true;
  }
  void SetDirection(double azimuth_rad, double elevation_rad) override {
    camera_.SetDirection(azimuth_rad, elevation_rad);
    dirty_ = true;
  }

  std::string PickInstance(double x_px, double y_px) override {
    view_.window()->GetState()->Reset();
    vtkNew<vtkCellPicker> picker;
    picker->SetTolerance(0.002);
    picker->PickFromListOn();
    const auto pickable = actors_.pickable();
    for (const auto& [actor, id] : pickable) picker->AddPickList(actor);
    if (picker->Pick(x_px, view_.height() - 1 - y_px, 0, view_.ground()) == 0) return "";
    for (const auto& [actor, id] : pickable) {
      if (picker->GetActor() == actor) return id;
    }
    return "";
  }

  std::optional<Vector3d> PickScan(double x_px, double y_px) override {
    if (content_.snapshot == nullptr || actors_.shown_scan() == nullptr) return std::nullopt;
    if (picker_ == nullptr) {
      picker_ = std::make_unique<ScanPicker>(actors_.shown_scan(), actors_.scan_side());
    }
    const SightLine sight = Sight(x_px, y_px);
    const Isometry3d& level_from_scan = content_.snapshot->level_from_scan;
    const Isometry3d scan_from_level = level_from_scan.inverse();
    const auto point =
        picker_->Pick(scan_from_level * sight.eye, scan_from_level.linear() * sight.direction,
                      kCloudCone_px * RadiansPerPixel());
    if (!point) return std::nullopt;
    return Vector3d(level_from_scan * *point);
  }

  SightLine Sight(double x_px, double y_px) const override {
    const Eigen::Matrix3d view = camera_.view_from_world();
    const double scale = 2 * std::tan(0.5 * TurntableCamera::kViewAngle) / view_.height();
    const Vector3d in_view((x_px + 0.5 - 0.5 * view_.width()) * scale,
                           (0.5 * view_.height() - y_px - 0.5) * scale, -1);
    return {camera_.eye_in_world(), (view.transpose() * in_view).normalized()};
  }

  std::optional<Eigen::Vector2d> Project(const Vector3d& in_level) const override {
    const Vector3d in_view = camera_.view_from_world() * (in_level - camera_.eye_in_world());
    if (in_view.z() > -1e-3) return std::nullopt;
    const double scale = 0.5 * view_.height() / std::tan(0.5 * TurntableCamera::kViewAngle);
    return Eigen::Vector2d(0.5 * view_.width() - 0.5 + scale * in_view.x() / -in_view.z(),
                           0.5 * view_.height() - 0.5 - scale * in_view.y() / -in_view.z());
  }

  SceneCamera camera() const override {
    return {camera_.focus_in_world(), camera_.azimuth_rad(), camera_.elevation_rad(),
            camera_.distance_m(), camera_.view_from_world()};
  }
  double last_render_ms() const override { return render_ms_; }
  int renders() const override { return renders_; }
  double grid_step_m() const override { return AnnotateActors::kGridStep_m; }

 private:
  double RadiansPerPixel() const {
    return TurntableCamera::kViewAngle / std::max(1, view_.height());
  }

  VtkView view_;
  AnnotateActors actors_;
  TurntableCamera camera_{Vector3d::UnitZ()};
  std::unique_ptr<ScanPicker> picker_;
  AnnotateContent content_;
  bool dirty_ = true, coarse_ = false;
  double render_ms_ = 0, full_render_ms_ = 0;
  int renders_ = 0;
};

}  // namespace

std::unique_ptr<AnnotateSurface> CreateAnnotateScene(bool software_gl) {
  return std::make_unique<AnnotateScene>(software_gl);
}

}  // namespace plumbline
