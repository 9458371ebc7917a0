// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include <imgui.h>

#include "ui/framework/frame_context.h"
#include "ui/framework/theme.h"

namespace plumbline {

/// A column of a table and what explains it.
struct TableHead {
  std::string name;
  const char* help = "";
  ImGuiTableColumnFlags flags = 0;
  float width = 0;                 ///< In units of the small text's size; 0: as the flags have it.
  ImU32 color = colors::kDimText;  ///< Of the name.
};

/// Sets up the columns of the open table and draws their heads, which stay as the rows scroll.
/// @param log          Heads are logged as `log`.0 and so on; "": they are not.
/// @param kept_columns How many columns stay as the table scrolls sideways.
void DrawTableHeads(const FrameContext& context, std::span<const TableHead> heads,
                    const std::string& log = "", int kept_columns = 0);

}  // namespace plumbline
