// SPDX-License-Identifier: Apache-2.0
// The window's own files, as far as they are read without it; panel_targets.cc has the rest.
#include <array>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "tests/fuzz/fuzz_targets.h"
#include "ui/files/bookmark_file.h"
#include "ui/files/clip_box_json.h"
#include "ui/files/kept_value.h"
#include "ui/files/layout_ratios.h"
#include "ui/files/saved_view.h"
#include "ui/files/script_file.h"
#include "ui/files/window_settings.h"

namespace plumbline::fuzz {
namespace {

Status Script(std::string_view input) { return StatusOf(ReadScript(FileOf("script.json", input))); }

Status Bookmarks(std::string_view input) {
  const auto file = FileOf("run.plb.bookmarks.json", input);
  const auto bookmarks = ReadBookmarks(file);
  if (const Status written = WriteBookmarks(file, bookmarks); !written.ok()) return written;
  PLB_CHECK(ReadBookmarks(file).size() == bookmarks.size());  // what is written is read again
  return {};
}

Status Settings(std::string_view input) {
  const nlohmann::json settings = ReadSettings(FileOf("window.json", input));
  (void)WindowSettingsFromJson(settings);
  LayoutRatios ratios;
  RatiosFromJson(KeptObject(settings, "layout"), ratios);
  for (const auto& [name, own] : ArrangementsFromJson(KeptObject(settings, "own_layouts")))
    (void)ToJson(ArrangementFromJson(ToJson(own)));
  const nlohmann::json annotate = KeptObject(settings, "annotate");
  (void)ToJson(ScanLookFromJson(KeptObject(annotate, "scan_look")));
  for (const auto& views : KeptObject(annotate, "views")) {
    const auto kept = SavedViewsFromJson(views);
    PLB_CHECK(SavedViewsFromJson(ToJson(kept)).size() == kept.size());
  }
  const auto box =
      ClipBoxFromJson(KeptObject(KeptObject(KeptObject(settings, "panels"), "scene"), "clip"));
  if (box) PLB_CHECK(ClipBoxFromJson(ToJson(*box)) == box);
  return {};
}

constexpr std::array kWindowTargets = {Target{"window_script", Script},
                                       Target{"bookmarks", Bookmarks},
                                       Target{"window_settings", Settings}};

}  // namespace

std::span<const Target> WindowTargets() { return kWindowTargets; }

}  // namespace plumbline::fuzz
