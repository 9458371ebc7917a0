// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "ui/common/palette.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The menu "View": what the scan's colours mean, how large its points are, and views to come back
/// to.
void DrawViewMenu(const FrameContext& context);
/// The same for the palette. They keep a reference to `context`.
void AddViewEntries(const FrameContext& context, std::vector<PaletteEntry>& entries);

// What the settings keep. What cannot be read is left out.
nlohmann::json ToJson(const ScanLook& look);
ScanLook ScanLookFromJson(const nlohmann::json& json);
nlohmann::json ToJson(const std::vector<SavedView>& views);
std::vector<SavedView> SavedViewsFromJson(const nlohmann::json& json);

}  // namespace plumbline
