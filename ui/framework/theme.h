// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <imgui.h>
#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/mapping/event_report.h"
#include "engine/snapshot/object_look.h"

namespace plumbline {

/// Colours of the window, as ImGui packs them. ApplyTheme alone changes them; these are the dark
/// ones.
namespace colors {
inline ImU32 kBackground = IM_COL32(17, 20, 24, 255);
inline ImU32 kPanel = IM_COL32(25, 29, 35, 255);
inline ImU32 kInset = IM_COL32(13, 15, 18, 255);
inline ImU32 kBorder = IM_COL32(44, 51, 60, 255);
inline ImU32 kControl = IM_COL32(40, 46, 55, 255);
inline ImU32 kControlHovered = IM_COL32(54, 62, 74, 255);
inline ImU32 kSheet = IM_COL32(33, 38, 46, 255);  ///< What lies over everything else.
inline ImU32 kText = IM_COL32(228, 232, 238, 255);
inline ImU32 kDimText = IM_COL32(147, 157, 170, 255);
inline ImU32 kFaint = IM_COL32(92, 101, 113, 255);
inline ImU32 kAccent = IM_COL32(82, 168, 224, 255);
inline ImU32 kAccentDim = IM_COL32(38, 82, 112, 255);
inline ImU32 kGood = IM_COL32(94, 201, 142, 255);
inline ImU32 kWarning = IM_COL32(236, 184, 84, 255);
inline ImU32 kBad = IM_COL32(236, 106, 94, 255);
inline ImU32 kTrajectory = IM_COL32(242, 145, 50, 255);
inline ImU32 kTruth = IM_COL32(88, 214, 110, 255);
inline ImU32 kSmoothed = IM_COL32(196, 160, 250, 255);
// Over pictures, in every theme:
inline constexpr ImU32 kOnPicture = IM_COL32(228, 232, 238, 255);
inline constexpr ImU32 kOnPictureDim = IM_COL32(160, 170, 182, 255);
}  // namespace colors

/// Of an object's look (FrameContext::ColorOf): the same in both themes and over pictures.
ImU32 ColorOfLook(const ObjectLook& look);
/// For things that are counted: stages, shapes, axes, annotated instances; from 0.
ImU32 SeriesColor(std::size_t index);
/// Relative luminance of the lighter by the darker, from 1 to 21 (WCAG 2).
double ContrastOf(ImU32 a, ImU32 b);
/// A colour of the data as text, lines and bars on panels have it: itself on dark panels; of the
/// same hue, but darker, where it would stand off light ones, or the ground of their plots, by less
/// than 3 to 1.
ImU32 OnPanel(ImU32 color);
ImU32 WithAlpha(ImU32 color, double alpha);
/// Blends towards `other` by `share`.
ImU32 Mixed(ImU32 color, ImU32 other, double share);
cv::Vec3b BgrOf(ImU32 color);

/// How much of a tentative object is drawn: the likelier it is there, the more.
double GhostShare(double log_evidence);

ImU32 StateColor(ObjectState state);
ImU32 EventColor(EventKind kind);

/// Fonts in the order they were loaded.
struct Fonts {
  ImFont* text = nullptr;
  ImFont* strong = nullptr;
  ImFont* small = nullptr;
  ImFont* title = nullptr;
  ImFont* caption = nullptr;  ///< For a projector.
};

/// Sets colours and style and loads the fonts (Inter, else DejaVu Sans, found through fontconfig;
/// else ImGui's own) for a scale of 1 = 15 px text. The font texture must be made again afterwards.
Fonts ApplyTheme(double scale, bool light = false);

}  // namespace plumbline
