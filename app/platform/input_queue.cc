// SPDX-License-Identifier: Apache-2.0
#include "app/platform/input_queue.h"

#include <algorithm>

namespace plumbline {
namespace {

// Numbers that GLFW gives.
constexpr int kChordKeys[] = {341, 342, 343, 345, 346, 347};  // Control, Alt, Super

bool WritesCharacter(int key) {
  const bool keypad = key >= 320 && key <= 334;
  return (key >= 32 && key <= 162) || keypad;
}

}  // namespace

void InputQueue::AddKey(int key, bool down, double time_s) {
  if (key < 0 || key >= static_cast<int>(input_.keys.size())) return;
  events_.push_back({Kind::kKey, down, key, {}, time_s});
}

void InputQueue::AddCharacter(char32_t character, double time_s) {
  events_.push_back({Kind::kCharacter, true, static_cast<int>(character), {}, time_s});
}

void InputQueue::AddButton(int button, bool down, double time_s) {
  if (button < 0 || button >= static_cast<int>(input_.buttons.size())) return;
  events_.push_back({Kind::kButton, down, button, {}, time_s});
}

void InputQueue::AddMove(std::optional<cv::Point2d> mouse_px, double time_s) {
  events_.push_back({Kind::kMove, false, 0, mouse_px, time_s});
}

void InputQueue::AddWheel(cv::Point2d notches, double time_s) {
  events_.push_back({Kind::kWheel, false, 0, notches, time_s});
}

void InputQueue::LetGo(double time_s) {
  auto keys = input_.keys;
  auto buttons = input_.buttons;
  for (const Event& event : events_) {
    const auto code = static_cast<std::size_t>(event.code);
    if (event.kind == Kind::kKey) keys.set(code, event.down);
    if (event.kind == Kind::kButton) buttons.set(code, event.down);
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i]) AddKey(static_cast<int>(i), false, time_s);
  }
  for (std::size_t i = 0; i < buttons.size(); ++i) {
    if (buttons[i]) AddButton(static_cast<int>(i), false, time_s);
  }
}

bool InputQueue::IsCharacter(const Event& event, bool typing) const {
  if (event.kind != Kind::kKey || !typing || input_.keys[static_cast<std::size_t>(event.code)])
    return false;
  const bool chord = std::any_of(std::begin(kChordKeys), std::end(kChordKeys), [&](int key) {
    return input_.keys[static_cast<std::size_t>(key)];
  });
  return !chord && WritesCharacter(event.code);
}

bool InputQueue::Fits(const Event& event, const Taken& taken, bool typing) const {
  switch (event.kind) {
    case Kind::kKey:
      // A chord must be seen whole before any of its keys goes up, and go up before the next comes.
      return !taken.button && !taken.keys[static_cast<std::size_t>(event.code)] &&
             !(event.down ? taken.released : taken.pressed);
    case Kind::kCharacter:
      // Tab gives the keyboard to another field, which listens two frames later.
      return !taken.button && !taken.pressed && !taken.released && !(typing && pressed_before_);
    case Kind::kButton:
      // What lies under the mouse is known once it is there, and what is typed goes where it was
      // typed.
      return !taken.button && !taken.moved && !taken.typed;
    case Kind::kMove:
    case Kind::kWheel:
      return !taken.button;
  }
  return true;
}

void InputQueue::Take(const Event& event, Taken& taken) {
  input_.time_s = std::max(input_.time_s, event.time_s);
  switch (event.kind) {
    case Kind::kKey:
      (event.down ? taken.pressed : taken.released) = true;
      taken.keys.set(static_cast<std::size_t>(event.code));
      input_.keys.set(static_cast<std::size_t>(event.code), event.down);
      return;
    case Kind::kCharacter:
      taken.typed = true;
      input_.characters.push_back(static_cast<char32_t>(event.code));
      return;
    case Kind::kButton:
      taken.button = true;
      input_.buttons.set(static_cast<std::size_t>(event.code), event.down);
      return;
    case Kind::kMove:
      if (!event.at && input_.buttons.any()) return;
      taken.moved = true;
      input_.mouse_px = event.at;
      return;
    case Kind::kWheel:
      taken.moved = true;
      input_.wheel += event.at.value_or(cv::Point2d());
      return;
  }
}

const WindowInput& InputQueue::Next(bool typing, double now_s) {
  input_.wheel = {};
  input_.characters.clear();
  Taken taken;
  while (!events_.empty()) {
    const Event& event = events_.front();
    if (!IsCharacter(event, typing)) {
      if (!Fits(event, taken, typing)) break;
      Take(event, taken);
    }
    events_.pop_front();
  }
  pressed_before_ = taken.pressed;
  if (events_.empty()) input_.time_s = std::max(input_.time_s, now_s);
  return input_;
}

}  // namespace plumbline
