// SPDX-License-Identifier: Apache-2.0
// What the window reads and keeps: damage costs no more than what is damaged.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/support/test_data.h"
#include "ui/files/bookmark_file.h"
#include "ui/files/kept_value.h"
#include "ui/files/layout_ratios.h"
#include "ui/files/saved_view.h"
#include "ui/files/script_file.h"
#include "ui/files/window_settings.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class WindowFiles : public testing::Test {
 protected:
  std::filesystem::path Write(const char* name, std::string_view content) {
    const auto file = folder_.path() / name;
    EXPECT_TRUE(WriteFileAtomically(file, content).ok());
    return file;
  }
  std::string WhyNot(std::string_view step) {
    const auto script =
        ReadScript(Write("script.json", R"({"steps": [)" + std::string(step) + "]}"));
    return script.ok() ? "" : script.error().message;
  }
  TemporaryFolder folder_;
};

TEST_F(WindowFiles, OneWrongSettingCostsNoOther) {
  const json settings = {{"light", "yes"},      {"ui_scale", 1.5},  {"recent", {"a", 3, "b"}},
                         {"window", {1600, 0}}, {"places", "none"}, {"count", 4e200}};
  const WindowSettings window = WindowSettingsFromJson(settings);
  EXPECT_FALSE(window.light.has_value());
  EXPECT_EQ(window.ui_scale, 1.5);
  EXPECT_EQ(window.recent, (std::vector<std::string>{"a", "b"}));
  EXPECT_FALSE(window.size.has_value());
  EXPECT_TRUE(window.places.empty());
  EXPECT_EQ(KeptValue(settings, "count", 7), 7) << "no int holds it";
  EXPECT_EQ(KeptValue(json(3), "count", 7), 7) << "no object";
  EXPECT_TRUE(KeptObject(settings, "light").empty());
}

TEST_F(WindowFiles, AWindowIsNoLargerThanAScreenCanBe) {
  EXPECT_TRUE(WindowSettingsFromJson({{"window", {1600, 1000}}}).size.has_value());
  EXPECT_FALSE(WindowSettingsFromJson({{"window", {100000, 1000}}}).size.has_value());
  EXPECT_FALSE(WindowSettingsFromJson({{"window", {-5, 1000}}}).size.has_value());
}

TEST_F(WindowFiles, SettingsThatCannotBeReadAreKeptBesideTheNewOnes) {
  const auto file = Write("window.json", R"({"own_layouts": {"mine": )");
  EXPECT_TRUE(ReadSettings(file).empty());
  EXPECT_EQ(ReadFile(folder_.path() / "window.json.damaged").value(),
            R"({"own_layouts": {"mine": )");
  EXPECT_TRUE(ReadSettings(folder_.path() / "none.json").empty());
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none.json.damaged"));
}

TEST_F(WindowFiles, DamagedBookmarksAreKeptBesideTheNewOnes) {
  const std::string text =
      R"({"bookmarks": [{"frame": 3, "note": "a"}, {"frame": 4e200}, {"frame": 5, "note": 1}, 6]})";
  const auto file = Write("run.plb.bookmarks.json", text);
  const auto bookmarks = ReadBookmarks(file);
  ASSERT_EQ(bookmarks.size(), 2u);
  EXPECT_EQ(bookmarks[0].note, "a");
  EXPECT_EQ(bookmarks[1].frame, 5);
  ASSERT_TRUE(WriteBookmarks(file, bookmarks).ok());
  EXPECT_EQ(ReadFile(folder_.path() / "run.plb.bookmarks.json.damaged").value(), text);
  EXPECT_EQ(ReadBookmarks(file).size(), 2u);
}

TEST_F(WindowFiles, ViewsThatAreNoneAreLeftOut) {
  const json views = {{{"name", "door"}, {"focus", {1, 2, 3}}, {"azimuth_rad", 1e300}},
                      {{"name", "texts"}, {"focus", {"a", "b", "c"}}},
                      {{"name", "far"}, {"focus", {1e9, 0, 0}}},
                      {{"name", 3}, {"focus", {1, 2, 3}}}};
  const auto kept = SavedViewsFromJson(views);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].name, "door");
  EXPECT_LE(kept[0].camera.azimuth_rad, 7);
  EXPECT_TRUE(SavedViewsFromJson({{"a", 1}}).empty());
  EXPECT_EQ(ScanLookFromJson({{"point_px", 1e300}, {"coloring", 3}}), ScanLook());
}

TEST_F(WindowFiles, LayoutsTakeWhatMakesSense) {
  const auto own =
      ArrangementsFromJson({{"mine", {{"ratios", 3}, {"image_views", 2.5}, {"hidden", {"why", 1}}}},
                            {"Overview", json::object()},
                            {"", json::object()}});
  ASSERT_EQ(own.size(), 1u) << "neither a built-in one nor one without a name";
  EXPECT_EQ(own.at("mine").image_views, Arrangement().image_views);
  EXPECT_EQ(own.at("mine").hidden, std::set<std::string>{"why"});
}

TEST_F(WindowFiles, ScriptsOfMoreThanAWindowCanDoAreRefusedByStepAndKey) {
  EXPECT_EQ(WhyNot(R"({"key": "space", "times": 3}, {"resize": [1024, 700]})"), "");
  EXPECT_THAT(WhyNot(R"({"key": "space"}, {"wait_frames": 2000000000})"),
              HasSubstr("step 2: \"wait_frames\" must be a whole number of at most 100000"));
  EXPECT_THAT(WhyNot(R"({"key": "space", "times": 1e9})"), HasSubstr("\"times\""));
  EXPECT_THAT(WhyNot(R"({"wheel": "a", "amount": -2147483648})"), HasSubstr("\"amount\""));
  EXPECT_THAT(WhyNot(R"({"resize": [1e300, 700]})"), HasSubstr("\"resize\""));
  EXPECT_THAT(WhyNot(R"({"resize": [0, 700]})"), HasSubstr("\"resize\""));
  EXPECT_THAT(WhyNot(R"({"hover": "a", "at": [1e300, 0]})"), HasSubstr("\"at\""));
  EXPECT_THAT(WhyNot("3"), HasSubstr("step 1: is 3, but must be an object"));
}

}  // namespace
}  // namespace plumbline
