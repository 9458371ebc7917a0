// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/number_field.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ui/framework/widgets.h"

namespace plumbline {

std::optional<double> NumberFields::Draw(const FrameContext& context, const std::string& name,
                                         double value, const char* format, const char* tooltip) {
  char shown[64];
  std::snprintf(shown, sizeof(shown), format, value);
  double typed = value;
  const bool changed = ImGui::InputDouble(("##" + name).c_str(), &typed, 0, 0, format,
                                          ImGuiInputTextFlags_AutoSelectAll);
  const bool left = ImGui::IsItemDeactivatedAfterEdit() && name_ == name;
  // Tab leaves it one frame after the last frame in which it tells what is in it.
  if (changed || ImGui::IsItemActive()) {
    name_ = name;
    typed_ = typed;
  }
  LogItem(context, name);
  Tooltip(context, tooltip);
  if (!left) return std::nullopt;
  name_.clear();
  const bool given_up = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
  if (given_up || !std::isfinite(typed_) || typed_ == value || typed_ == std::atof(shown))
    return std::nullopt;
  return typed_;
}

}  // namespace plumbline
