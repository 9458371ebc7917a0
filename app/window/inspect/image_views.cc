// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/image_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "ui/framework/widgets.h"

namespace plumbline {

std::vector<LayoutRect> ImageViewRects(const InspectLayout& layout, int count) {
  const LayoutRect below{layout.edges.low, layout.particles.high};
  const LayoutRect left{below.low, {layout.edges.high.x, below.high.y}};
  const LayoutRect right{{layout.depth.low.x, below.low.y}, below.high};
  const LayoutRect& image = layout.image;
  switch (count) {
    case 1:
      return {{image.low, below.high}};
    case 2:
      return {image, below};
    case 3:
      return {image, left, right};
    case 4:
      return {{image.low, {left.high.x, image.high.y}},
              {{right.low.x, image.low.y}, image.high},
              left,
              right};
    default:
      return {image, layout.edges, layout.depth, layout.masks, layout.particles};
  }
}

bool ImageViews::Handle(const WindowCommand& command, FrameContext& context) {
  if (const auto* count = std::get_if<ImageViewsCommand>(&command)) {
    context.image_views = std::clamp(count->count, 1, kMost);
    return true;
  }
  if (const auto* place = std::get_if<PlaceViewCommand>(&command)) {
    const auto found = std::find_if(views_.begin(), views_.end(),
                                    [&](Panel* panel) { return place->panel == panel->Id(); });
    if (found != views_.end() && place->view >= 0 && place->view < kMost)
      std::swap(views_[static_cast<std::size_t>(place->view)], *found);
    return true;
  }
  return false;
}

void ImageViews::Draw(const FrameContext& context, const InspectLayout& layout, Panel* in_second,
                      CommandSink& sink) const {
  const std::vector<LayoutRect> rects =
      ImageViewRects(layout, in_second != nullptr ? 2 : context.image_views);
  for (std::size_t i = 0; i < rects.size(); ++i) {
    if (i == 1 && in_second != nullptr)
      DrawPanel(context, rects[i], *in_second, sink);
    else
      DrawPanel(context, rects[i], *views_[i], sink,
                [&] { DrawMenu(context, static_cast<int>(i), sink); });
  }
}

void ImageViews::DrawMenu(const FrameContext& context, int view, CommandSink& sink) const {
  DimText("Show here");
  for (Panel* panel : views_) {
    const bool here = panel == views_[static_cast<std::size_t>(view)];
    if (ImGui::MenuItem(panel->Title(), nullptr, here))
      sink.Post(PlaceViewCommand{view, panel->Id()});
    LogItem(context, fmt::format("views.place.{}", panel->Id()));
    Tooltip(context, panel->Help());
  }
  ImGui::Separator();
  DimText("Image views");
  for (int count = 1; count <= kMost; ++count) {
    if (ImGui::MenuItem(fmt::format("{}", count).c_str(), nullptr, count == context.image_views))
      sink.Post(ImageViewsCommand{count});
    LogItem(context, fmt::format("views.count.{}", count));
  }
}

nlohmann::json ImageViews::Save(const FrameContext& context) const {
  nlohmann::json order = nlohmann::json::array();
  for (const Panel* panel : views_) order.push_back(panel->Id());
  return {{"count", context.image_views}, {"order", order}};
}

void ImageViews::Load(const nlohmann::json& json, FrameContext& context) {
  context.image_views = std::clamp(json.value("count", context.image_views), 1, kMost);
  const auto order = json.value("order", std::vector<std::string>());
  for (std::size_t i = 0; i < std::min(order.size(), views_.size()); ++i)
    Handle(PlaceViewCommand{static_cast<int>(i), order[i]}, context);
}

}  // namespace plumbline
