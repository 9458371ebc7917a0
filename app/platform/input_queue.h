// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <opencv2/core/types.hpp>

namespace plumbline {

/// What the user did, as far as one frame of the window gets to know it.
struct WindowInput {
  std::bitset<512> keys;                ///< That are down, by GLFW's numbers.
  std::bitset<8> buttons;               ///< Of the mouse, likewise.
  std::optional<cv::Point2d> mouse_px;  ///< Nothing: outside the window.
  cv::Point2d wheel;                    ///< Notches since the frame before.
  std::vector<char32_t> characters;     ///< Typed since the frame before.
  double time_s = 0;                    ///< When the last of it happened.
};

/// Hands out what the user did in the order in which it was done, a frame at a time, and only as
/// much at once as leaves its order visible: however slow the window, a button goes down where the
/// mouse was then, a short stroke of a key is a stroke, and what is typed after Tab goes into the
/// next field.
class InputQueue {
 public:
  void AddKey(int key, bool down, double time_s);
  void AddCharacter(char32_t character, double time_s);
  void AddButton(int button, bool down, double time_s);
  /// Nothing: it left the window; not heeded while a button is held, which keeps the mouse.
  void AddMove(std::optional<cv::Point2d> mouse_px, double time_s);
  void AddWheel(cv::Point2d notches, double time_s);
  /// The window lost the keyboard: what is held now will be let go elsewhere.
  void LetGo(double time_s);

  bool empty() const { return events_.empty(); }
  /// @param typing  Text is being typed: keys of letters and digits are characters, nothing else.
  const WindowInput& Next(bool typing, double now_s);

 private:
  enum class Kind : std::uint8_t { kKey, kCharacter, kButton, kMove, kWheel };
  struct Event {
    Kind kind = Kind::kMove;
    bool down = false;
    int code = 0;  ///< Of a key, a character or a button.
    std::optional<cv::Point2d> at;
    double time_s = 0;
  };
  /// What the frame that is being made up has of each kind already.
  struct Taken {
    std::bitset<512> keys;
    bool pressed = false, released = false, typed = false, button = false, moved = false;
  };
  bool Fits(const Event& event, const Taken& taken, bool typing) const;
  void Take(const Event& event, Taken& taken);
  bool IsCharacter(const Event& event, bool typing) const;

  std::deque<Event> events_;
  WindowInput input_;
  bool pressed_before_ = false;  ///< A key went down in the frame before.
};

}  // namespace plumbline
