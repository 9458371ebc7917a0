// SPDX-License-Identifier: Apache-2.0
// What one slow frame gets of what was done while it was drawn.

#include "app/platform/input_queue.h"

#include <string>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

constexpr int kEnter = 257, kTab = 258, kControl = 341, kZ = 90, kOne = 49;

/// Everything that was done, as the frames get it: "mouse x, buttons, characters" of each.
std::string FramesOf(InputQueue& queue, bool typing = false) {
  std::string frames;
  for (int i = 0; i < 20 && !queue.empty(); ++i) {
    const WindowInput& input = queue.Next(typing, 0);
    frames += "[";
    if (input.mouse_px) frames += std::to_string(static_cast<int>(input.mouse_px->x));
    if (input.buttons[0]) frames += " left";
    if (input.keys[kTab]) frames += " tab";
    if (input.keys[kEnter]) frames += " enter";
    if (input.keys[kControl]) frames += " ctrl";
    if (input.keys[kZ]) frames += " z";
    if (!input.characters.empty()) frames += " ";
    for (const char32_t c : input.characters) frames += static_cast<char>(c);
    frames += "]";
  }
  return frames;
}

void Move(InputQueue& queue, double x) { queue.AddMove(cv::Point2d(x, 0), 0); }

void Type(InputQueue& queue, const std::string& text) {
  for (const char c : text) {
    queue.AddKey(kOne, true, 0);
    queue.AddCharacter(static_cast<char32_t>(c), 0);
    queue.AddKey(kOne, false, 0);
  }
}

TEST(InputQueue, AButtonGoesDownWhereTheMouseWasThen) {
  InputQueue queue;
  Move(queue, 10);
  Move(queue, 300);
  queue.AddButton(0, true, 0);
  queue.AddButton(0, false, 0);
  Move(queue, 500);
  EXPECT_EQ(FramesOf(queue), "[300][300 left][300][500]");
}

TEST(InputQueue, ADragEndsWhereItEnded) {
  InputQueue queue;
  queue.AddButton(0, true, 0);
  for (const double x : {20, 40, 60}) Move(queue, x);
  queue.AddButton(0, false, 0);
  Move(queue, 70);
  EXPECT_EQ(FramesOf(queue), "[ left][60 left][60][70]");
}

TEST(InputQueue, AHeldButtonKeepsTheMouseThatLeavesTheWindow) {
  InputQueue queue;
  Move(queue, 5);
  queue.AddButton(0, true, 0);
  queue.AddMove(std::nullopt, 0);
  Move(queue, -8);
  queue.AddButton(0, false, 0);
  queue.AddMove(std::nullopt, 0);
  EXPECT_EQ(FramesOf(queue), "[5][5 left][-8 left][-8][]");
}

TEST(InputQueue, AShortChordIsSeenWhole) {
  InputQueue queue;
  queue.AddKey(kControl, true, 0);
  queue.AddKey(kZ, true, 0);
  queue.AddKey(kZ, false, 0);
  queue.AddKey(kControl, false, 0);
  queue.AddKey(kEnter, true, 0);
  EXPECT_EQ(FramesOf(queue), "[ ctrl z][][ enter]");
}

TEST(InputQueue, TextComesAtOnceAndWhatFollowsTabGoesIntoTheNextField) {
  InputQueue queue;
  Type(queue, "1.25");
  queue.AddKey(kTab, true, 0);
  queue.AddKey(kTab, false, 0);
  Type(queue, "-3");
  queue.AddKey(kTab, true, 0);
  Type(queue, "7");  // before Tab is let go
  EXPECT_EQ(FramesOf(queue, true), "[ tab 1.25][][ tab -3][ tab][ tab 7]");
}

TEST(InputQueue, TextGoesWhereItWasTypedBeforeAClickElsewhere) {
  InputQueue queue;
  Type(queue, "5");
  queue.AddButton(0, true, 0);
  EXPECT_EQ(FramesOf(queue, true), "[ 5][ left]");
}

TEST(InputQueue, WhatIsHeldAsTheWindowLosesTheKeyboardIsLetGo) {
  InputQueue queue;
  queue.AddKey(kControl, true, 0);
  EXPECT_EQ(FramesOf(queue), "[ ctrl]");
  queue.AddKey(kTab, true, 0);
  queue.AddButton(0, true, 0);
  queue.LetGo(0);
  EXPECT_EQ(FramesOf(queue), "[ left tab ctrl][]");
}

TEST(InputQueue, TellsWhenItHappenedNotWhenItIsShown) {
  InputQueue queue;
  queue.AddButton(0, true, 1.0);
  queue.AddButton(0, false, 1.1);
  queue.AddButton(0, true, 1.2);
  EXPECT_EQ(queue.Next(false, 5).time_s, 1.0);
  EXPECT_EQ(queue.Next(false, 6).time_s, 1.1);
  EXPECT_EQ(queue.Next(false, 7).time_s, 7) << "there is no more";
}

}  // namespace
}  // namespace plumbline
