// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/theme.h"

#include <fontconfig/fontconfig.h>
#include <imgui_freetype.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "engine/base/log.h"

namespace plumbline {
namespace {

/// File of a family that fontconfig really has (it always offers something); "" if not.
std::string FontFile(const char* family, int weight) {
  const std::unique_ptr<FcPattern, decltype(&FcPatternDestroy)> wanted(FcPatternCreate(),
                                                                       &FcPatternDestroy);
  FcPatternAddString(wanted.get(), FC_FAMILY, reinterpret_cast<const FcChar8*>(family));
  FcPatternAddInteger(wanted.get(), FC_WEIGHT, weight);
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result{};
  const std::unique_ptr<FcPattern, decltype(&FcPatternDestroy)> match(
      FcFontMatch(nullptr, wanted.get(), &result), &FcPatternDestroy);
  FcChar8* found = nullptr;
  if (!match || FcPatternGetString(match.get(), FC_FAMILY, 0, &found) != FcResultMatch) return "";
  if (std::string(reinterpret_cast<const char*>(found)) != family) return "";
  if (FcPatternGetString(match.get(), FC_FILE, 0, &found) != FcResultMatch) return "";
  return reinterpret_cast<const char*>(found);
}

std::string TextFontFile(int weight) {
  for (const char* family : {"Inter", "DejaVu Sans"}) {
    std::string file = FontFile(family, weight);
    if (!file.empty()) return file;
  }
  return "";
}

/// @param latin_only  A large font would fill the texture with letters that nothing needs.
ImFont* AddFont(const std::string& file, double pixels, bool latin_only = false) {
  static constexpr ImWchar kLatin[] = {0x20, 0xFF, 0};
  static constexpr ImWchar kRanges[] = {0x20,   0xFF,   0x370,  0x3FF,  0x2010, 0x2030, 0x2070,
                                        0x209F, 0x2190, 0x2193, 0x2212, 0x2212, 0};
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  if (!file.empty()) {
    ImFont* font = atlas.AddFontFromFileTTF(file.c_str(), static_cast<float>(pixels), nullptr,
                                            latin_only ? kLatin : kRanges);
    if (font != nullptr) return font;
  }
  ImFontConfig config;
  config.SizePixels = static_cast<float>(pixels);
  return atlas.AddFontDefault(&config);
}

/// Gives all digits one width, so that numbers do not dance while a sequence plays.
void MakeDigitsTabular(ImFont& font) {
  float widest = 0;
  for (ImWchar c = '0'; c <= '9'; ++c) {
    if (const ImFontGlyph* glyph = font.FindGlyphNoFallback(c)) {
      widest = std::max(widest, glyph->AdvanceX);
    }
  }
  for (ImFontGlyph& glyph : font.Glyphs) {
    if (glyph.Codepoint < '0' || glyph.Codepoint > '9') continue;
    const float shift = 0.5f * (widest - glyph.AdvanceX);
    glyph.X0 += shift;
    glyph.X1 += shift;
    glyph.AdvanceX = widest;
  }
  font.BuildLookupTable();
}

void ChooseColors(bool light) {
  using namespace colors;  // NOLINT: all of them
  const auto choose = [&](ImU32& color, ImU32 dark, ImU32 bright) {
    color = light ? bright : dark;
  };
  choose(kBackground, IM_COL32(17, 20, 24, 255), IM_COL32(226, 230, 235, 255));
  choose(kPanel, IM_COL32(25, 29, 35, 255), IM_COL32(248, 249, 251, 255));
  choose(kInset, IM_COL32(13, 15, 18, 255), IM_COL32(230, 234, 239, 255));
  choose(kBorder, IM_COL32(44, 51, 60, 255), IM_COL32(202, 208, 216, 255));
  choose(kControl, IM_COL32(40, 46, 55, 255), IM_COL32(226, 230, 236, 255));
  choose(kControlHovered, IM_COL32(54, 62, 74, 255), IM_COL32(208, 215, 224, 255));
  choose(kSheet, IM_COL32(33, 38, 46, 255), IM_COL32(255, 255, 255, 255));
  choose(kText, IM_COL32(228, 232, 238, 255), IM_COL32(24, 30, 38, 255));
  choose(kDimText, IM_COL32(147, 157, 170, 255), IM_COL32(84, 94, 106, 255));
  choose(kFaint, IM_COL32(92, 101, 113, 255), IM_COL32(134, 143, 155, 255));
  choose(kAccent, IM_COL32(82, 168, 224, 255), IM_COL32(20, 116, 182, 255));
  choose(kAccentDim, IM_COL32(38, 82, 112, 255), IM_COL32(186, 217, 240, 255));
  choose(kGood, IM_COL32(94, 201, 142, 255), IM_COL32(20, 130, 72, 255));
  choose(kWarning, IM_COL32(236, 184, 84, 255), IM_COL32(172, 106, 0, 255));
  choose(kBad, IM_COL32(236, 106, 94, 255), IM_COL32(190, 44, 34, 255));
}

void SetColors(ImGuiStyle& style) {
  const auto set = [&](ImGuiCol index, ImU32 color) {
    style.Colors[index] = ImGui::ColorConvertU32ToFloat4(color);
  };
  set(ImGuiCol_Text, colors::kText);
  set(ImGuiCol_TextDisabled, colors::kDimText);
  set(ImGuiCol_WindowBg, colors::kBackground);
  set(ImGuiCol_ChildBg, IM_COL32(0, 0, 0, 0));
  set(ImGuiCol_PopupBg, colors::kSheet);
  set(ImGuiCol_Border, colors::kBorder);
  set(ImGuiCol_FrameBg, colors::kControl);
  set(ImGuiCol_FrameBgHovered, colors::kControlHovered);
  set(ImGuiCol_FrameBgActive, colors::kControlHovered);
  set(ImGuiCol_Button, colors::kControl);
  set(ImGuiCol_ButtonHovered, colors::kControlHovered);
  set(ImGuiCol_ButtonActive, colors::kAccentDim);
  set(ImGuiCol_Header, WithAlpha(colors::kAccent, 0.22));
  set(ImGuiCol_HeaderHovered, WithAlpha(colors::kAccent, 0.14));
  set(ImGuiCol_HeaderActive, WithAlpha(colors::kAccent, 0.30));
  set(ImGuiCol_CheckMark, colors::kAccent);
  set(ImGuiCol_SliderGrab, colors::kAccent);
  set(ImGuiCol_SliderGrabActive, colors::kAccent);
  set(ImGuiCol_ScrollbarBg, IM_COL32(0, 0, 0, 0));
  set(ImGuiCol_ScrollbarGrab, colors::kControlHovered);
  set(ImGuiCol_ScrollbarGrabHovered, colors::kFaint);
  set(ImGuiCol_ScrollbarGrabActive, colors::kFaint);
  set(ImGuiCol_TableHeaderBg, colors::kPanel);
  set(ImGuiCol_TableBorderLight, WithAlpha(colors::kBorder, 0.6));
  set(ImGuiCol_TableBorderStrong, colors::kBorder);
  set(ImGuiCol_TableRowBg, IM_COL32(0, 0, 0, 0));
  set(ImGuiCol_TableRowBgAlt, WithAlpha(colors::kText, 0.02));
  set(ImGuiCol_Separator, colors::kBorder);
  set(ImGuiCol_NavHighlight, IM_COL32(0, 0, 0, 0));
  set(ImGuiCol_ModalWindowDimBg, IM_COL32(0, 0, 0, 120));
}

}  // namespace

ImU32 ColorOfLook(const ObjectLook& look) {
  const LookColor color = ColorOf(look);
  return IM_COL32(color.red, color.green, color.blue, 255);
}

ImU32 SeriesColor(std::size_t index) { return ColorOfLook({static_cast<int>(index)}); }

namespace {

/// Red, green and blue, from 0 to 1, proportional to light.
cv::Vec3d LinearOf(ImU32 color) {
  const cv::Vec3b bgr = BgrOf(color);
  cv::Vec3d linear;
  for (int c = 0; c < 3; ++c) {
    const double value = bgr[2 - c] / 255.0;
    linear[c] = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  }
  return linear;
}

double LuminanceOf(const cv::Vec3d& linear) {
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

}  // namespace

double ContrastOf(ImU32 a, ImU32 b) {
  const auto [low, high] = std::minmax({LuminanceOf(LinearOf(a)), LuminanceOf(LinearOf(b))});
  return (high + 0.05) / (low + 0.05);
}

ImU32 OnPanel(ImU32 color) {
  constexpr double kLeast = 3.1;  // a little more than 3, for rounding
  // Plots lie on insets, which are a little darker.
  const double panel =
      std::min(LuminanceOf(LinearOf(colors::kPanel)), LuminanceOf(LinearOf(colors::kInset)));
  const double ink = LuminanceOf(LinearOf(color));
  const double most = (panel + 0.05) / kLeast - 0.05;
  if (panel < 0.5 || ink <= most) return color;
  // One factor for all three keeps the hue.
  const cv::Vec3d dark = LinearOf(color) * (most / ink);
  cv::Vec3d srgb;
  for (int c = 0; c < 3; ++c)
    srgb[c] = dark[c] <= 0.0031308 ? 12.92 * dark[c] : 1.055 * std::pow(dark[c], 1 / 2.4) - 0.055;
  const ImVec4 value(static_cast<float>(srgb[0]), static_cast<float>(srgb[1]),
                     static_cast<float>(srgb[2]), ImGui::ColorConvertU32ToFloat4(color).w);
  return ImGui::ColorConvertFloat4ToU32(value);
}

ImU32 WithAlpha(ImU32 color, double alpha) {
  return (color & ~IM_COL32_A_MASK) |
         (static_cast<ImU32>(std::clamp(alpha, 0.0, 1.0) * 255.0 + 0.5) << IM_COL32_A_SHIFT);
}

ImU32 Mixed(ImU32 color, ImU32 other, double share) {
  const ImVec4 a = ImGui::ColorConvertU32ToFloat4(color);
  const ImVec4 b = ImGui::ColorConvertU32ToFloat4(other);
  const auto s = static_cast<float>(share);
  return ImGui::ColorConvertFloat4ToU32(
      ImVec4(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z), a.w));
}

cv::Vec3b BgrOf(ImU32 color) {
  return {static_cast<std::uint8_t>(color >> IM_COL32_B_SHIFT),
          static_cast<std::uint8_t>(color >> IM_COL32_G_SHIFT),
          static_cast<std::uint8_t>(color >> IM_COL32_R_SHIFT)};
}

double GhostShare(double log_evidence) {
  constexpr double kLeast = 0.1, kMost = 0.5;
  return kLeast + (kMost - kLeast) / (1 + std::exp(-log_evidence));
}

ImU32 StateColor(ObjectState state) {
  switch (state) {
    case ObjectState::kTentative:
      return colors::kWarning;
    case ObjectState::kConfirmed:
      return colors::kGood;
    case ObjectState::kRetired:
      return colors::kFaint;
  }
  return colors::kFaint;
}

ImU32 EventColor(EventKind kind) {
  switch (kind) {
    case EventKind::kSpawned:
      return colors::kAccent;
    case EventKind::kConfirmed:
      return colors::kGood;
    case EventKind::kMerged:
      return OnPanel(IM_COL32(190, 150, 240, 255));
    case EventKind::kRetired:
      return colors::kDimText;
    case EventKind::kLabelChanged:
      return colors::kWarning;
    case EventKind::kFrameSkipped:
      return colors::kBad;
    case EventKind::kOptionsChanged:
      return OnPanel(IM_COL32(236, 122, 190, 255));
    case EventKind::kPosesCorrected:
      return OnPanel(IM_COL32(120, 200, 230, 255));
  }
  return colors::kDimText;
}

Fonts ApplyTheme(double scale, bool light) {
  ChooseColors(light);
  ImGuiStyle style;
  style.WindowPadding = {12, 12};
  style.FramePadding = {9, 5};
  style.ItemSpacing = {9, 7};
  style.ItemInnerSpacing = {7, 5};
  style.CellPadding = {8, 4};
  style.ScrollbarSize = 11;
  style.WindowRounding = 0;
  style.ChildRounding = 6;
  style.FrameRounding = 5;
  style.PopupRounding = 6;
  style.GrabRounding = 4;
  style.ScrollbarRounding = 6;
  style.WindowBorderSize = 0;
  style.ChildBorderSize = 0;
  style.PopupBorderSize = 1;
  style.FrameBorderSize = 0;
  style.ScaleAllSizes(static_cast<float>(scale));
  SetColors(style);
  ImGui::GetStyle() = style;

  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  atlas.FontBuilderIO = ImGuiFreeType::GetBuilderForFreeType();
  atlas.FontBuilderFlags = ImGuiFreeTypeBuilderFlags_LightHinting;
  const std::string regular = TextFontFile(FC_WEIGHT_REGULAR);
  const std::string medium = TextFontFile(FC_WEIGHT_DEMIBOLD);
  if (regular.empty()) {
    log::warn(
        "neither the font Inter nor DejaVu Sans is installed; install fonts-inter for better text");
  }
  Fonts fonts;
  fonts.text = AddFont(regular, 15.0 * scale);
  fonts.strong = AddFont(medium, 15.0 * scale);
  fonts.small = AddFont(regular, 13.0 * scale);
  fonts.title = AddFont(medium, 21.0 * scale);
  fonts.caption = AddFont(medium, 40.0 * scale, true);
  atlas.Build();
  for (ImFont* font : {fonts.text, fonts.strong, fonts.small, fonts.title, fonts.caption})
    MakeDigitsTabular(*font);
  return fonts;
}

}  // namespace plumbline
