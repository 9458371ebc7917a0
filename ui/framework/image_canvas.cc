// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/image_canvas.h"

#include <algorithm>
#include <cmath>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {
constexpr float kMaxZoom = 24;
}

ImageCanvas::ImageCanvas(const FrameContext& context, const std::string& name, ImTextureID texture,
                         int width, int height)
    : width_(width), height_(height) {
  Begin(context, name, static_cast<float>(width) / static_cast<float>(height));
  Listen(*context.viewport);
  const ImageViewport& viewport = *context.viewport;
  const float half = 0.5f / viewport.zoom;
  uv_low_ = {viewport.center.x - half, viewport.center.y - half};
  uv_high_ = {viewport.center.x + half, viewport.center.y + half};
  Show(texture);
}

ImageCanvas::ImageCanvas(const FrameContext& context, const std::string& name, ImTextureID texture,
                         int width, int height, const Box2& part)
    : width_(width), height_(height) {
  Begin(context, name, part.width() / part.height());
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  uv_low_ = {(part.x0 + 0.5f) / w, (part.y0 + 0.5f) / h};
  uv_high_ = {(part.x1 + 0.5f) / w, (part.y1 + 0.5f) / h};
  Show(texture);
}

ImageCanvas::~ImageCanvas() { ImGui::GetWindowDrawList()->PopClipRect(); }

void ImageCanvas::Begin(const FrameContext& context, const std::string& name, float aspect) {
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const float width = std::max(1.0f, std::floor(std::min(room.x, room.y * aspect)));
  const float height = std::max(1.0f, std::floor(width / aspect));
  low_ = {std::floor(origin.x + 0.5f * (room.x - width)),
          std::floor(origin.y + 0.5f * (room.y - height))};
  high_ = {low_.x + width, low_.y + height};
  ImGui::SetCursorScreenPos(low_);
  ImGui::InvisibleButton(name.c_str(), {width, height});
  ImGui::SetItemAllowOverlap();  // for controls that panels put into the picture
  LogItem(context, name);
  is_hovered_ = ImGui::IsItemHovered();
}

void ImageCanvas::Listen(ImageViewport& viewport) {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 size(high_.x - low_.x, high_.y - low_.y);
  if (is_hovered_ && io.MouseWheel != 0) {
    const float before = viewport.zoom;
    viewport.zoom = std::clamp(before * std::pow(1.2f, io.MouseWheel), 1.0f, kMaxZoom);
    const ImVec2 mouse((io.MousePos.x - low_.x) / size.x - 0.5f,
                       (io.MousePos.y - low_.y) / size.y - 0.5f);
    viewport.center.x += mouse.x * (1 / before - 1 / viewport.zoom);
    viewport.center.y += mouse.y * (1 / before - 1 / viewport.zoom);
  }
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
    viewport.center.x -= io.MouseDelta.x / size.x / viewport.zoom;
    viewport.center.y -= io.MouseDelta.y / size.y / viewport.zoom;
  }
  if (is_hovered_ && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) viewport = {};
  const float half = 0.5f / viewport.zoom;
  viewport.center.x = std::clamp(viewport.center.x, half, 1 - half);
  viewport.center.y = std::clamp(viewport.center.y, half, 1 - half);
}

void ImageCanvas::Show(ImTextureID texture) {
  scale_ = (high_.x - low_.x) / ((uv_high_.x - uv_low_.x) * static_cast<float>(width_));
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRect(low_, high_, true);
  list.AddImage(texture, low_, high_, uv_low_, uv_high_);
  const ImGuiIO& io = ImGui::GetIO();
  if (!is_hovered_) return;
  hovered_ = ToPixel(io.MousePos);
  const ImVec2 dragged = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left);
  if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && ImGui::IsItemDeactivated() &&
      dragged.x == 0 && dragged.y == 0) {
    clicked_ = hovered_;
  }
}

ImVec2 ImageCanvas::ToScreen(float x_px, float y_px) const {
  const float u = (x_px + 0.5f) / static_cast<float>(width_);
  const float v = (y_px + 0.5f) / static_cast<float>(height_);
  return {low_.x + (u - uv_low_.x) / (uv_high_.x - uv_low_.x) * (high_.x - low_.x),
          low_.y + (v - uv_low_.y) / (uv_high_.y - uv_low_.y) * (high_.y - low_.y)};
}

Eigen::Vector2f ImageCanvas::ToPixel(ImVec2 screen) const {
  const float u = uv_low_.x + (screen.x - low_.x) / (high_.x - low_.x) * (uv_high_.x - uv_low_.x);
  const float v = uv_low_.y + (screen.y - low_.y) / (high_.y - low_.y) * (uv_high_.y - uv_low_.y);
  return {u * static_cast<float>(width_) - 0.5f, v * static_cast<float>(height_) - 0.5f};
}

}  // namespace plumbline
