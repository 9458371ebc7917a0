// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <imgui.h>

#include "ui/framework/frame_context.h"

namespace plumbline {

// Controls of the house: each has a name for scripts (Panel's Id and a word: "image.outlines") and
// a tooltip.

enum class Icon { kPlay, kPause, kStepBack, kStepForward, kFirst, kLast, kHelp, kCamera };

/// Remembers the last ImGui item under `name`.
void LogItem(const FrameContext& context, const std::string& name);
/// Tooltip of the last item, below, above or beside it, and never over a dialog.
void Tooltip(const FrameContext& context, const std::string& text);
/// The tooltip that is begun next explains this part of a picture, and does not lie over it where
/// there is room beside it.
void PutTooltipBeside(const FrameContext& context, ImVec2 low, ImVec2 high);
/// The same for the pixel under the mouse and what is next to it.
void PutTooltipBesideMouse(const FrameContext& context);

/// Known to ImGui by its name: the label may change while the mouse is down on it.
bool Button(const FrameContext& context, const std::string& name, const char* label,
            const std::string& tooltip);
bool IconButton(const FrameContext& context, const std::string& name, Icon icon, bool on,
                const std::string& tooltip);
/// A small switch with text; true when it was clicked (and `value` turned).
bool Toggle(const FrameContext& context, const std::string& name, const char* label, bool& value,
            const std::string& tooltip);
/// Width that Toggle takes.
float ToggleWidth(const FrameContext& context, const char* label);
/// Moves the cursor so that a row of `width` ends at the right edge.
void AlignRight(float width);

/// Centred, dim: what is missing and what to do.
void EmptyState(const FrameContext& context, const char* title, const char* advice);

/// A horizontal bar of `share` in [0, 1] with text over it.
void Bar(ImVec2 size, double share, ImU32 color);

/// A square in the object's colour, a line of text high, with the cursor behind it; half of it is
/// dark where the colour is another object's, too.
void Chip(const FrameContext& context, ObjectId object);
void Chip(const FrameContext& context, ImU32 color);
/// The same at a place beside a line of small text. @return How much room it takes.
float DrawChip(const FrameContext& context, ImDrawList& draw, ImVec2 low, ObjectId object);
/// An open line; dashed where that tells objects apart.
void Polyline(const FrameContext& context, ImDrawList& draw, std::span<const ImVec2> points,
              ImU32 color, float width, bool dashed);

void DimText(const char* format, ...) IM_FMTARGS(1);
void SmallText(const FrameContext& context, ImU32 color, const char* format, ...) IM_FMTARGS(3);
void WrappedText(ImU32 color, const std::string& text);
/// A row of a table with three columns: what, its value, and what qualifies it (dim).
void TableRow(const char* name, const std::string& value, const std::string& more = "");

/// Labels with a dark ground in a picture, placed so that they do not cover one another where that
/// can be helped. Those that may be left out stay away instead, and once labels cover a sixth of
/// the picture.
class PictureLabels {
 public:
  enum class Need { kAlways, kIfFree };
  PictureLabels(const FrameContext& context, ImVec2 clip_low, ImVec2 clip_high)
      : context_(context), clip_low_(clip_low), clip_high_(clip_high) {}
  /// @param corners  Lower left corners by falling preference; labels are kept inside the picture.
  /// @return Whether it is drawn.
  bool Add(std::initializer_list<ImVec2> corners, ImU32 color, const std::string& text,
           Need need = Need::kAlways);
  ImVec2 SizeOf(const std::string& text) const;

 private:
  struct Placed {
    ImVec2 low, high;
  };
  float Covered(const Placed& rect) const;

  const FrameContext& context_;
  ImVec2 clip_low_, clip_high_;
  std::vector<Placed> placed_;
  float area_ = 0;  ///< Of all that are placed.
};

}  // namespace plumbline
