// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "ui/framework/layout.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// The image views of Inspect: one to five, and what each of them shows.
class ImageViews {
 public:
  static constexpr int kMost = 5;

  /// @param panels  kMost of them: what the views show at first.
  explicit ImageViews(std::vector<Panel*> panels) : views_(std::move(panels)) {}
  void SetCount(int count, FrameContext& context) const;
  /// Shows a panel in a view; what was there goes where it was. Nothing if either does not exist.
  void Place(int view, const std::string& panel);
  /// @param in_second  Shown in place of all views but the first; null: nothing is.
  /// @param most  How many at most.
  void Draw(const FrameContext& context, const InspectLayout& layout, int most, Panel* in_second,
            CommandSink& sink) const;
  /// How many show: as many as are asked for, and not hidden.
  int Shown(const FrameContext& context) const;
  nlohmann::json Save(const FrameContext& context) const;
  /// Ignores what it does not know.
  void Load(const nlohmann::json& json, FrameContext& context);

 private:
  void DrawMenu(const FrameContext& context, const Panel& shown, CommandSink& sink) const;
  /// Those that are not hidden, in order.
  std::vector<Panel*> NotHidden(const FrameContext& context) const;

  std::vector<Panel*> views_;
};

/// Where `count` views go.
std::vector<LayoutRect> ImageViewRects(const InspectLayout& layout, int count);

}  // namespace plumbline
