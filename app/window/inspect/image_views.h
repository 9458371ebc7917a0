// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <nlohmann/json.hpp>

#include "ui/framework/layout.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// The image views of Inspect: one to five, and what each of them shows.
class ImageViews {
 public:
  static constexpr int kMost = 5;
  using Panels = std::array<Panel*, kMost>;

  explicit ImageViews(const Panels& panels) : views_(panels) {}
  /// True if it took the command.
  bool Handle(const WindowCommand& command, FrameContext& context);
  /// @param in_second  Shown in place of all views but the first; null: nothing is.
  void Draw(const FrameContext& context, const InspectLayout& layout, Panel* in_second,
            CommandSink& sink) const;
  nlohmann::json Save(const FrameContext& context) const;
  /// Ignores what it does not know.
  void Load(const nlohmann::json& json, FrameContext& context);

 private:
  void DrawMenu(const FrameContext& context, int view, CommandSink& sink) const;

  Panels views_;
};

/// Where `count` views go.
std::vector<LayoutRect> ImageViewRects(const InspectLayout& layout, int count);

}  // namespace plumbline
