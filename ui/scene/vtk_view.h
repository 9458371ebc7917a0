// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include "ui/scene/turntable_camera.h"

namespace plumbline {

/// VTK drawing into a texture of the window's GL context, in two layers that share a camera: what
/// is in `front` is never hidden by what is in `ground`. Use it while that context is current.
class VtkView {
 public:
  explicit VtkView(bool software_gl);

  vtkRenderer* ground() { return ground_; }
  vtkRenderer* front() { return front_; }
  vtkGenericOpenGLRenderWindow* window() { return window_; }
  int width() const { return width_; }
  int height() const { return height_; }
  void SetBackground(bool light);
  /// Whether the size changed.
  bool Resize(int width, int height);
  /// Puts VTK's camera where the turntable has it.
  void SetCamera(const TurntableCamera& camera, double near_m, double far_m);
  /// Draws, and waits for it; milliseconds.
  double Render();
  ImTextureID texture();

 private:
  void AddLight(vtkRenderer* renderer, double x, double y, double z, double intensity);

  vtkNew<vtkRenderer> ground_, front_;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  int width_ = 0, height_ = 0;
};

}  // namespace plumbline
