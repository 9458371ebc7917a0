// SPDX-License-Identifier: Apache-2.0
#include "ui/common/welcome.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>

#include "engine/snapshot/annotation_snapshot.h"
#include "ui/common/window_actions.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

void Headline(const FrameContext& context, const char* text) {
  ImGui::PushFont(context.fonts.title);
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

/// As a shell takes it for one word.
std::string ShellWord(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_./-+:,@%=").find(c) != std::string::npos;
  });
  if (plain && !text.empty()) return text;
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'') word += "'\\'";
    word += c;
  }
  return word + "'";
}

void DrawWays(const FrameContext& context, CommandSink& sink) {
  WrappedText(colors::kDimText,
              "Drop the folder of a sequence, a recorded run (.plb) or a folder of models onto "
              "this window, or name it on "
              "the command line:");
  ImGui::Indent(context.Scaled(14));
  WrappedText(colors::kText, "plumbline gui SEQUENCE");
  WrappedText(colors::kText, "plumbline gui RUN.plb");
  ImGui::Unindent(context.Scaled(14));
  ImGui::Dummy({0, context.Scaled(6)});
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  if (Button(context, "welcome.open", "Open \u2026",
             "Choose a sequence, a run, a scan or a project from a list (Ctrl + O).")) {
    AskWhatToOpen(context);
  }
  ImGui::SameLine();
  if (Button(context, "welcome.demo", "Play the built-in demo",
             "A synthetic room; it is made the first time, which takes a minute.")) {
    sink.Post(OpenCommand{kDemoPath});
  }
  ImGui::PopStyleColor();
}

void DrawRecent(const FrameContext& context, CommandSink& sink) {
  if (context.recent.empty()) return;
  ImGui::Dummy({0, context.Scaled(8)});
  SmallText(context, colors::kAccent, "Opened before");
  for (std::size_t i = 0; i < context.recent.size(); ++i) {
    const std::string& path = context.recent[i];
    const std::string name =
        path == kDemoPath ? "Built-in demo" : std::filesystem::path(path).filename().string();
    const std::string id = "welcome.recent." + std::to_string(i);
    if (ImGui::Selectable((name + "##" + id).c_str())) sink.Post(OpenCommand{path});
    LogItem(context, id);
    Tooltip(context, path);
  }
}

/// A sequence of which nobody has said where the camera was.
void DrawLackOfPoses(const FrameContext& context, CommandSink& sink) {
  const std::string name = ShellWord(context.source);
  Headline(context, "This sequence has no camera poses");
  WrappedText(colors::kDimText, context.source);
  ImGui::Dummy({0, context.Scaled(2)});
  WrappedText(colors::kText,
              "Objects are mapped into one world, so every frame needs to know where its camera "
              "was.");
  ImGui::Dummy({0, context.Scaled(6)});
  if (context.has_imu) {
    WrappedText(colors::kText,
                "It has an IMU: the visual-inertial filter finds the poses from the images and the "
                "IMU while it is mapped.");
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    if (Button(context, "welcome.find_poses", "Find the poses and map",
               "Opens the sequence once more, as --poses vio does."))
      sink.Post(FindPosesCommand{});
    ImGui::PopStyleColor();
    WrappedText(colors::kDimText, "The same on the command line, and the poses alone as a file:");
    ImGui::Indent(context.Scaled(14));
    WrappedText(colors::kText, "plumbline gui " + name + " --poses vio");
    WrappedText(colors::kText, "plumbline vio " + name + " --out trajectory.txt");
    ImGui::Unindent(context.Scaled(14));
  } else {
    WrappedText(colors::kText,
                "It has no IMU either, which the visual-inertial filter (--poses vio) needs.");
  }
  ImGui::Dummy({0, context.Scaled(4)});
  WrappedText(colors::kDimText,
              "With poses from elsewhere, as a TUM trajectory on the same clock:");
  ImGui::Indent(context.Scaled(14));
  WrappedText(colors::kText, "plumbline gui " + name + " --poses trajectory.txt");
  ImGui::Unindent(context.Scaled(14));
}

/// What the Annotate workspace shows while no scan is open.
void DrawAnnotateWelcome(const FrameContext& context, CommandSink& sink) {
  if (context.annotation == nullptr) {
    Headline(context, "No scan is open");
    WrappedText(
        colors::kDimText,
        "Drop a scan (.ply, .pcd, .obj) or an annotation project (.json) onto this window, or "
        "name it "
        "on the command line:");
    ImGui::Indent(context.Scaled(14));
    WrappedText(colors::kText, "plumbline gui SCAN.ply --models FOLDER");
    WrappedText(colors::kText, "plumbline gui PROJECT.json");
    ImGui::Unindent(context.Scaled(14));
    ImGui::Dummy({0, context.Scaled(6)});
    ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
    if (Button(context, "welcome.open", "Open \u2026",
               "Choose a scan or a project from a list (Ctrl + O)."))
      AskWhatToOpen(context);
    ImGui::PopStyleColor();
    return DrawRecent(context, sink);
  }
  const bool failed = !context.annotation->failure.empty();
  Headline(context, failed ? "This could not be opened" : "Opening");
  if (failed) WrappedText(colors::kBad, context.annotation->failure);
}

}  // namespace

void DrawWelcome(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) {
  const float width = std::min(context.Scaled(620), rect.width() - context.Scaled(40));
  const bool failed = context.playback->state == PlaybackState::kFailed;
  ImGui::SetNextWindowPos({0.5f * (rect.low.x + rect.high.x), rect.low.y + 0.42f * rect.height()},
                          ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kPanel);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(30), context.Scaled(26)});
  ImGui::Begin("welcome", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing);
  if (context.workspace == WorkspaceId::kAnnotate) {
    DrawAnnotateWelcome(context, sink);
  } else if (context.source.empty()) {
    Headline(context, "Nothing is open");
    DrawWays(context, sink);
    DrawRecent(context, sink);
  } else if (failed && context.lacks_poses) {
    DrawLackOfPoses(context, sink);
  } else if (failed) {
    Headline(context, "This could not be opened");
    WrappedText(colors::kDimText, context.source);
    ImGui::Dummy({0, context.Scaled(2)});
    WrappedText(colors::kBad, context.playback->message);
    ImGui::Dummy({0, context.Scaled(10)});
    if (!context.source.ends_with(".plb")) {
      if (Button(context, "welcome.networks", "Choose networks",
                 "Maps the sequence with other networks for edges and boxes."))
        sink.Post(AskNetworksCommand{});
      ImGui::Dummy({0, context.Scaled(10)});
    }
    DrawWays(context, sink);
  } else {
    Headline(context, "Opening");
    WrappedText(colors::kDimText,
                context.source == kDemoPath ? "the built-in demo" : context.source);
    ImGui::Dummy({0, context.Scaled(6)});
    WrappedText(colors::kText, context.playback->message);
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
  ImGui::PopStyleColor();
}

}  // namespace plumbline
