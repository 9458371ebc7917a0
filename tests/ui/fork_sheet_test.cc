// SPDX-License-Identifier: Apache-2.0
// The sheet of options: every option has a name, and can be found by it or by its key.

#include "ui/inspect/compare/fork_sheet.h"
#include "engine/mapping/mapper_options.h"
#include "ui/inspect/compare/option_names.h"

#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

TEST(OptionNames, NameEveryOptionOnceAndNothingElse) {
  std::set<std::string> keys;
  MapperOptions options;
  VisitFields(options, [&](auto&, const FieldInfo& info) { keys.emplace(info.name); });
  std::set<std::string> named, groups_before, names;
  std::string group;
  for (const OptionName& entry : MapperOptionNames()) {
    EXPECT_TRUE(named.emplace(entry.key).second) << entry.key << " twice";
    EXPECT_TRUE(names.insert(std::string(entry.group) + "/" + std::string(entry.name)).second)
        << entry.name << " means two things";
    EXPECT_LE(entry.name.size(), 30u) << entry.name;
    if (entry.group == group) continue;
    group = entry.group;
    EXPECT_TRUE(groups_before.insert(group).second) << group << " is in two pieces";
  }
  EXPECT_EQ(named, keys);
}

class ForkSheetAtWork {
 public:
  ForkSheetAtWork() {
    ImGui::GetIO().DisplaySize = {1200, 2400};
    harness.ShowFrame(20);
    auto offer = std::make_shared<ForkOffer>();
    offer->out = "fork.plb";
    harness.context.fork_offer = offer;
    sheet.Open(harness.context, true);
  }
  void Draw(const std::string& typed = "") {
    for (int frame = 0; frame < 4; ++frame) {
      if (frame == 2) ImGui::GetIO().AddInputCharactersUTF8(typed.c_str());
      ImGui::NewFrame();
      harness.widgets.Clear();
      sheet.Draw(harness.context, harness.sink);
      ImGui::Render();
    }
  }
  /// Types into the field that finds options.
  void Find(const std::string& text) {
    Draw();
    const WidgetLog::Rect rect = *harness.widgets.Find("fork.filter");
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {0.5f * (rect.low.x + rect.high.x), 0.5f * (rect.low.y + rect.high.y)};
    Draw();
    io.MouseDown[0] = true;
    Draw();
    io.MouseDown[0] = false;
    Draw(text);
    Draw();
  }
  bool Shows(const std::string& key) const {
    return harness.widgets.Find("fork.option." + key) != nullptr;
  }

  PanelHarness harness;
  ForkSheet sheet;
};

TEST(ForkSheet, ShowsWhatCountsMostFirst) {
  ForkSheetAtWork work;
  work.Draw();
  ASSERT_TRUE(work.Shows("beta"));
  ASSERT_TRUE(work.Shows("particles"));
  EXPECT_LT(work.harness.widgets.Find("fork.option.beta")->low.y,
            work.harness.widgets.Find("fork.option.particles")->low.y);
}

TEST(ForkSheet, FindsOptionsByPlainNameKeyAndGroup) {
  for (const auto& [typed, key] : std::map<std::string, std::string>{
           {"weight of edges", "beta"}, {"view_corr", "view_correlation"}, {"new obj", "prior"}}) {
    SCOPED_TRACE(typed);
    ForkSheetAtWork work;
    work.Find(typed);
    EXPECT_TRUE(work.Shows(key));
    EXPECT_FALSE(work.Shows("particles"));
  }
}

}  // namespace
}  // namespace plumbline
