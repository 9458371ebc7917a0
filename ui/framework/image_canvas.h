// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <imgui.h>
#include <Eigen/Core>

#include "engine/geometry/box.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// A picture that fills the rest of a panel, as large as its shape allows. Wheel zooms about the
/// mouse, dragging moves, double click shows all; all canvases of the window move together. Draw
/// overlays between constructor and destructor: they are clipped to the picture.
class ImageCanvas {
 public:
  /// @param width, height  Size of the image whose pixels ToScreen takes.
  ImageCanvas(const FrameContext& context, const std::string& name, ImTextureID texture, int width,
              int height);
  /// Shows this part of the image instead of the common one, and does not listen to the mouse.
  ImageCanvas(const FrameContext& context, const std::string& name, ImTextureID texture, int width,
              int height, const Box2& part);
  ~ImageCanvas();
  ImageCanvas(const ImageCanvas&) = delete;
  ImageCanvas& operator=(const ImageCanvas&) = delete;

  ImVec2 ToScreen(float x_px, float y_px) const;
  ImVec2 ToScreen(const Eigen::Vector2f& pixel) const { return ToScreen(pixel.x(), pixel.y()); }
  /// Pixel under the mouse; nothing if it is elsewhere.
  std::optional<Eigen::Vector2f> hovered() const { return hovered_; }
  /// Pixel of a click that was not a drag.
  std::optional<Eigen::Vector2f> clicked() const { return clicked_; }
  ImVec2 low() const { return low_; }
  ImVec2 high() const { return high_; }
  /// Screen pixels per image pixel.
  float scale() const { return scale_; }
  ImDrawList& draw() const { return *ImGui::GetWindowDrawList(); }

 private:
  void Begin(const FrameContext& context, const std::string& name, float aspect);
  void Listen(ImageViewport& viewport);
  void Show(ImTextureID texture);
  Eigen::Vector2f ToPixel(ImVec2 screen) const;

  int width_ = 0, height_ = 0;
  ImVec2 low_, high_;        // of the picture on the screen
  ImVec2 uv_low_, uv_high_;  // of the part of the image that shows
  float scale_ = 1;
  bool is_hovered_ = false;
  std::optional<Eigen::Vector2f> hovered_, clicked_;
};

}  // namespace plumbline
