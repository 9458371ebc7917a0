// SPDX-License-Identifier: Apache-2.0
// The palette with queued input: a slow frame gets a whole word and Enter at once.

#include "ui/common/palette.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/platform/input_queue.h"
#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

constexpr int kReturnKey = 257, kDownKey = 264, kControlKey = 341, kPKey = 80, kLetterKey = 65;

/// Control+P opens it, as in the window; remembers what it ran.
class PaletteAtWork {
 public:
  explicit PaletteAtWork(std::vector<std::string> texts) : texts_(std::move(texts)) {
    ImGui::GetIO().KeyMap[ImGuiKey_Enter] = kReturnKey;
  }

  void Press(int key) {
    queue_.AddKey(key, true, 0);
    queue_.AddKey(key, false, 0);
  }
  void Type(const std::string& text) {
    for (const char c : text) {
      queue_.AddKey(kLetterKey, true, 0);
      queue_.AddCharacter(static_cast<char32_t>(c), 0);
      queue_.AddKey(kLetterKey, false, 0);
    }
  }
  void Open() {
    queue_.AddKey(kControlKey, true, 0);
    queue_.AddKey(kPKey, true, 0);
    queue_.AddKey(kPKey, false, 0);
    queue_.AddKey(kControlKey, false, 0);
  }
  /// Frames until everything that was done has been handed out. @return How many.
  int Work() {
    int frames = 0;
    for (; frames < 60 && !queue_.empty(); ++frames) Frame();
    Frame();
    return frames;
  }
  /// Until the field has the keyboard.
  void Rest() {
    for (int i = 0; i < 5; ++i) Frame();
  }

  std::string ran;

 private:
  void Frame() {
    ImGuiIO& io = ImGui::GetIO();
    const WindowInput& input = queue_.Next(io.WantTextInput, 0);
    for (std::size_t key = 0; key < input.keys.size(); ++key) io.KeysDown[key] = input.keys[key];
    io.KeyCtrl = input.keys[kControlKey];
    for (const char32_t character : input.characters) io.AddInputCharacter(character);
    ImGui::NewFrame();
    const bool chord = io.KeyCtrl && ImGui::IsKeyPressed(kPKey, false);
    std::vector<PaletteEntry> all;
    for (const std::string& text : texts_)
      all.push_back({text, "", [this, text](CommandSink&) { ran = text; }});
    DrawPalette(
        harness_.context, state_, std::move(all),
        [](const std::string&) { return std::vector<PaletteEntry>(); }, harness_.sink);
    if (chord) state_.open = true;
    ImGui::EndFrame();
  }

  std::vector<std::string> texts_;
  PanelHarness harness_;
  InputQueue queue_;
  PaletteState state_;
};

TEST(Palette, EnterInTheFrameOfTheTextRunsWhatTheTextSays) {
  PaletteAtWork palette({"Open", "Show edges", "Show masks", "Show help"});
  palette.Open();
  palette.Work();
  palette.Rest();
  palette.Type("masks");
  palette.Press(kReturnKey);
  EXPECT_LE(palette.Work(), 2) << "text and Enter came at once";
  EXPECT_EQ(palette.ran, "Show masks");
}

TEST(Palette, TakesWhatIsTypedRightAfterTheKeysThatOpenIt) {
  PaletteAtWork palette({"Open", "Show edges", "Show masks", "Show help"});
  palette.Open();
  palette.Type("masks");
  palette.Press(kReturnKey);
  palette.Work();
  EXPECT_EQ(palette.ran, "Show masks");
}

TEST(Palette, ForgetsWhatWasChosenAmongOtherEntries) {
  PaletteAtWork palette({"Show edges", "Show masks", "Show help"});
  palette.Open();
  palette.Work();
  palette.Press(kDownKey);
  palette.Press(kDownKey);
  palette.Work();
  palette.Type("show");
  palette.Press(kReturnKey);
  palette.Work();
  EXPECT_EQ(palette.ran, "Show edges");
}

TEST(Palette, PutsWhatIsTypedInFullFirst) {
  PaletteAtWork palette({"Map: look through the camera", "Through the wall", "Through"});
  palette.Open();
  palette.Type("through");
  palette.Press(kReturnKey);
  palette.Work();
  EXPECT_EQ(palette.ran, "Through");
}

}  // namespace
}  // namespace plumbline
