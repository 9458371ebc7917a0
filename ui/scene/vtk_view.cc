// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/vtk_view.h"

#include <epoxy/gl.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLState.h>
#include <vtkTextureObject.h>

#include "engine/base/timer.h"

namespace plumbline {

VtkView::VtkView(bool software_gl) {
  window_->SetOwnContext(0);
  window_->SetFrameBlitModeToNoBlit();
  window_->SetMultiSamples(software_gl ? 0 : 4);
  window_->SetIsCurrent(true);
  window_->SetReadyForRendering(true);
  window_->SetSupportsOpenGL(1);
  window_->SetIsDirect(1);
  window_->SetMapped(1);
  window_->OpenGLInitContext();
  window_->SetNumberOfLayers(2);
  SetBackground(false);
  ground_->GradientBackgroundOn();
  ground_->SetBackgroundAlpha(1.0);
  front_->SetLayer(1);
  ground_->SetActiveCamera(front_->GetActiveCamera());
  for (vtkRenderer* renderer : {ground_.Get(), front_.Get()}) {
    renderer->AutomaticLightCreationOff();
    AddLight(renderer, 0.4, 0.9, 1.0, 0.85);
    AddLight(renderer, -0.8, 0.2, 0.6, 0.35);
    window_->AddRenderer(renderer);
  }
}

void VtkView::AddLight(vtkRenderer* renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

void VtkView::SetBackground(bool light) {
  const double low = light ? 0.86 : 0.058, high = light ? 0.95 : 0.122;
  ground_->SetBackground(0.86 * low, low, light ? low : 1.2 * low);
  ground_->SetBackground2(0.86 * high, high, light ? high : 1.2 * high);
  if (!light) return;
  ground_->SetBackground(low, low, low);
  ground_->SetBackground2(high, high, high);
}

bool VtkView::Resize(int width, int height) {
  if (width == width_ && height == height_) return false;
  width_ = width;
  height_ = height;
  window_->SetSize(width, height);
  return true;
}

void VtkView::SetCamera(const TurntableCamera& turntable, double near_m, double far_m) {
  vtkCamera& camera = *front_->GetActiveCamera();
  const Eigen::Matrix3d view = turntable.view_from_world();
  // Without perspective the distance changes nothing but what would be behind the eye.
  const double back_m = turntable.parallel() ? far_m : 0;
  const Eigen::Vector3d eye = turntable.eye_in_world() + back_m * view.row(2).transpose();
  camera.SetParallelProjection(turntable.parallel());
  camera.SetParallelScale(turntable.distance_m() * std::tan(0.5 * TurntableCamera::kViewAngle));
  camera.SetPosition(eye.x(), eye.y(), eye.z());
  camera.SetFocalPoint(turntable.focus_in_world().data());
  camera.SetViewUp(view(1, 0), view(1, 1), view(1, 2));
  camera.SetViewAngle(TurntableCamera::kViewAngle * 180 / std::numbers::pi);
  camera.SetWindowCenter(0, 0);
  camera.SetClippingRange(near_m, far_m + back_m);
}

double VtkView::Render() {
  const Stopwatch watch;
  window_->GetState()->Reset();
  window_->GetState()->Push();
  window_->Render();
  window_->GetState()->Pop();
  glFinish();
  return watch.Milliseconds();
}

ImTextureID VtkView::texture() {
  vtkTextureObject* texture =
      window_->GetDisplayFramebuffer()->GetColorAttachmentAsTextureObject(0);
  return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture->GetHandle()));
}

}  // namespace plumbline
