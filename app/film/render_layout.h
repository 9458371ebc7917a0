// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// A panel at a place in the picture, in shares of its width and height.
struct PlacedPanel {
  const char* panel;  ///< Panel::Id
  float x0, y0, x1, y1;
};

/// What a film or a figure shows. No panels: the whole window as people use it.
struct RenderLayout {
  const char* name;
  const char* meaning;
  std::vector<PlacedPanel> panels;
  nlohmann::json states = nlohmann::json::object();  ///< Of panels, where they differ.
};

const std::vector<RenderLayout>& RenderLayouts();
/// Errors: kNotFound, listing the names.
Result<const RenderLayout*> FindRenderLayout(const std::string& name);

}  // namespace plumbline
