// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <type_traits>

#include "engine/base/options.h"
#include "ui/framework/widgets.h"

namespace plumbline {

/// True if `text` has the letters of `query`, large or small.
inline bool HasLetters(std::string_view text, std::string_view query) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), query.begin(), query.end(), same) != text.end() ||
         query.empty();
}

/// One field of an options struct in the shape that fits its type; numbers are kept in range.
template <typename T>
void DrawOptionField(const std::string& id, const FieldInfo& info, T& field) {
  if constexpr (std::is_same_v<T, bool>) {
    ImGui::Checkbox(id.c_str(), &field);
  } else if constexpr (std::is_enum_v<T>) {
    const auto index = static_cast<std::size_t>(field);
    if (!ImGui::BeginCombo(id.c_str(), std::string(EnumNames<T>::names[index]).c_str())) return;
    for (std::size_t i = 0; i < std::size(EnumNames<T>::names); ++i) {
      if (ImGui::Selectable(std::string(EnumNames<T>::names[i]).c_str(), i == index))
        field = static_cast<T>(i);
    }
    ImGui::EndCombo();
  } else if constexpr (std::is_integral_v<T>) {
    ImGui::InputInt(id.c_str(), &field, 0, 0);
    field = std::clamp(field, static_cast<T>(info.min), static_cast<T>(info.max));
  } else {
    ImGui::InputDouble(id.c_str(), &field, 0, 0, "%g");
    field = std::clamp(field, info.min, info.max);
  }
}

/// All fields of `options` that fit `filter`, in two columns, each with its unit and an explanation
/// under the mouse; those that differ from `before` are marked. Fields are named `name`.FIELD.
template <typename Options>
void DrawOptionsForm(const FrameContext& context, const std::string& name, std::string_view filter,
                     const Options& before, Options& options) {
  const nlohmann::json old = OptionsToJson(before);
  if (!ImGui::BeginTable(name.c_str(), 2, ImGuiTableFlags_SizingStretchSame)) return;
  int shown = 0;
  VisitFields(options, [&](auto& field, const FieldInfo& info) {
    if (!HasLetters(info.name, filter) && !HasLetters(info.help, filter)) return;
    ++shown;
    ImGui::TableNextColumn();
    const std::string key(info.name), id = "##" + name + "." + key;
    nlohmann::json now;
    if constexpr (std::is_enum_v<std::remove_reference_t<decltype(field)>>)
      now = EnumNames<std::remove_reference_t<decltype(field)>>::names[static_cast<std::size_t>(
          field)];
    else
      now = field;
    const bool changed = now != old.at(key);
    ImGui::SetNextItemWidth(context.Scaled(128));
    DrawOptionField(id, info, field);
    LogItem(context, name + "." + key);
    std::string help(info.help);
    if constexpr (std::is_arithmetic_v<std::remove_reference_t<decltype(field)>> &&
                  !std::is_same_v<std::remove_reference_t<decltype(field)>, bool>)
      help += fmt::format("\n{:g} to {:g}{}{}", info.min, info.max, info.unit.empty() ? "" : " ",
                          info.unit);
    if (changed) help += "\nThe run has " + old.at(key).dump() + ".";
    Tooltip(context, help);
    ImGui::SameLine(0, context.Scaled(8));
    ImGui::AlignTextToFramePadding();
    ImGui::PushStyleColor(ImGuiCol_Text, changed ? colors::kAccent : colors::kText);
    ImGui::TextUnformatted(key.c_str());
    ImGui::PopStyleColor();
    Tooltip(context, help);
    if (info.unit.empty()) return;
    ImGui::SameLine(0, context.Scaled(6));
    SmallText(context, colors::kFaint, "%s", std::string(info.unit).c_str());
  });
  ImGui::EndTable();
  if (shown == 0) DimText("No option fits.");
}

/// Fields in which two structs differ.
template <typename Options>
int NumChanged(const Options& a, const Options& b) {
  const nlohmann::json x = OptionsToJson(a), y = OptionsToJson(b);
  int count = 0;
  for (const auto& [key, value] : x.items()) count += value != y.at(key);
  return count;
}

}  // namespace plumbline
