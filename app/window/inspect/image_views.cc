// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/image_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "ui/files/kept_value.h"
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

void ImageViews::SetCount(int count, FrameContext& context) const {
  context.image_views = std::clamp(count, 1, kMost);
}

void ImageViews::Place(int view, const std::string& panel) {
  const auto found =
      std::find_if(views_.begin(), views_.end(), [&](Panel* p) { return panel == p->id(); });
  if (found != views_.end() && view >= 0 && view < kMost)
    std::swap(views_[static_cast<std::size_t>(view)], *found);
}

std::vector<Panel*> ImageViews::NotHidden(const FrameContext& context) const {
  std::vector<Panel*> shown;
  for (Panel* panel : views_) {
    if (!context.hidden_panels.contains(panel->id())) shown.push_back(panel);
  }
  return shown;
}

int ImageViews::Shown(const FrameContext& context) const {
  return std::min(context.image_views, static_cast<int>(NotHidden(context).size()));
}

void ImageViews::Draw(const FrameContext& context, const InspectLayout& layout, int most,
                      Panel* in_second, CommandSink& sink) const {
  const std::vector<Panel*> shown = NotHidden(context);
  if (shown.empty()) return;
  const std::vector<LayoutRect> rects =
      ImageViewRects(layout, in_second != nullptr ? 2 : std::min(most, Shown(context)));
  for (std::size_t i = 0; i < rects.size(); ++i) {
    if (i == 1 && in_second != nullptr)
      DrawPanel(context, rects[i], *in_second, sink);
    else
      DrawPanel(context, rects[i], *shown[i], sink, [&] { DrawMenu(context, *shown[i], sink); });
  }
}

void ImageViews::DrawMenu(const FrameContext& context, const Panel& shown,
                          CommandSink& sink) const {
  const auto view = std::find(views_.begin(), views_.end(), &shown) - views_.begin();
  DimText("Show here");
  for (Panel* panel : views_) {
    if (ImGui::MenuItem(panel->info().title, nullptr, panel == &shown))
      sink.Post(PlaceViewCommand{static_cast<int>(view), panel->id()});
    LogItem(context, fmt::format("views.place.{}", panel->id()));
    Tooltip(context, panel->info().help);
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
  for (const Panel* panel : views_) order.push_back(panel->id());
  return {{"count", context.image_views}, {"order", order}};
}

void ImageViews::Load(const nlohmann::json& json, FrameContext& context) {
  SetCount(KeptValue(json, "count", context.image_views), context);
  const auto order = KeptValue(json, "order", std::vector<std::string>());
  for (std::size_t i = 0; i < std::min(order.size(), views_.size()); ++i)
    Place(static_cast<int>(i), order[i]);
}

}  // namespace plumbline
