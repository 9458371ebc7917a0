// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "engine/base/options.h"
#include "ui/framework/option_name.h"
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

/// One field with its name, its unit, and an explanation under the mouse.
/// @param changed  Marked, and told what it was: `before`.
template <typename T>
void DrawNamedOption(const FrameContext& context, const std::string& id, const FieldInfo& info,
                     std::string_view name, bool changed, const std::string& before, T& field) {
  ImGui::TableNextColumn();
  ImGui::SetNextItemWidth(context.Scaled(96));
  DrawOptionField("##" + id, info, field);
  LogItem(context, id);
  std::string help = fmt::format("{}: {}", info.name, info.help);
  if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
    help += fmt::format("\n{:g} to {:g}{}{}", info.min, info.max, info.unit.empty() ? "" : " ",
                        info.unit);
  if (changed) help += "\nThe run has " + before + ".";
  Tooltip(context, help);
  ImGui::SameLine(0, context.Scaled(8));
  ImGui::AlignTextToFramePadding();
  ImGui::PushStyleColor(ImGuiCol_Text, changed ? colors::kAccent : colors::kText);
  ImGui::TextUnformatted(name.data(), name.data() + name.size());
  ImGui::PopStyleColor();
  Tooltip(context, help);
  if (info.unit.empty()) return;
  ImGui::SameLine(0, context.Scaled(6));
  SmallText(context, colors::kFaint, "%s", std::string(info.unit).c_str());
}

/// All fields of `options` that fit `filter` by name, key or explanation, in two columns under the
/// headings of their groups; those that differ from `before` are marked. Fields are named
/// `name`.KEY.
/// @param names  Of every field, groups in one piece.
template <typename Options>
void DrawOptionsForm(const FrameContext& context, const std::string& name, std::string_view filter,
                     std::span<const OptionName> names, const Options& before, Options& options) {
  const nlohmann::json old = OptionsToJson(before), now = OptionsToJson(options);
  int shown = 0;
  for (std::size_t first = 0, end = 0; first < names.size(); first = end) {
    while (end < names.size() && names[end].group == names[first].group) ++end;
    bool open = false;  // the group's heading is there
    for (const OptionName& entry : names.subspan(first, end - first)) {
      VisitFields(options, [&](auto& field, const FieldInfo& info) {
        if (info.name != entry.key) return;
        if (!HasLetters(entry.name, filter) && !HasLetters(info.name, filter) &&
            !HasLetters(info.help, filter) && !HasLetters(entry.group, filter))
          return;
        const std::string key(info.name);
        if (!open) {
          if (shown > 0) ImGui::Dummy({0, context.Scaled(6)});
          ImGui::PushFont(context.fonts.strong);
          ImGui::TextUnformatted(entry.group.data(), entry.group.data() + entry.group.size());
          ImGui::PopFont();
          open = ImGui::BeginTable((name + std::to_string(first)).c_str(), 2,
                                   ImGuiTableFlags_SizingStretchSame);
        }
        ++shown;
        if (open)
          DrawNamedOption(context, name + "." + key, info, entry.name, now.at(key) != old.at(key),
                          old.at(key).dump(), field);
      });
    }
    if (open) ImGui::EndTable();
  }
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
