// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/networks_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "ui/framework/actions.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kSheetWidth = 820;

/// One that can be chosen, or why not.
struct Choice {
  std::string choice;  ///< As --edges or --detector name it.
  std::string name, about;
  std::string why_not = {};  ///< "": it can.
};

constexpr float kPadding = 2;  ///< Of the round button of a choice, above and below.

/// Where its text begins.
float IndentOfChoice(const FrameContext& context) {
  return ImGui::GetFontSize() + 2 * context.Scaled(kPadding) + ImGui::GetStyle().ItemInnerSpacing.x;
}

bool DrawChoice(const FrameContext& context, const std::string& widget, const Choice& choice,
                bool chosen) {
  const bool offered = choice.why_not.empty() && !context.playback->recorded;
  const ImGuiStyle& style = ImGui::GetStyle();
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {style.ItemSpacing.x, context.Scaled(1)});
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {style.FramePadding.x, context.Scaled(kPadding)});
  ImGui::PushStyleColor(ImGuiCol_FrameBg, colors::kControlHovered);
  ImGui::BeginDisabled(!offered);
  const bool clicked = ImGui::RadioButton((choice.name + "##" + widget).c_str(), chosen);
  LogItem(context, widget);
  ImGui::EndDisabled();
  const float indent = IndentOfChoice(context);
  ImGui::Indent(indent);
  ImGui::PushFont(context.fonts.small);
  WrappedText(colors::kDimText, choice.about);
  if (!offered && !context.playback->recorded) WrappedText(colors::kWarning, choice.why_not);
  ImGui::PopFont();
  ImGui::Unindent(indent);
  ImGui::Dummy({0, context.Scaled(8)});
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
  return clicked && !chosen;
}

bool IsFile(const std::string& choice) { return choice.ends_with(".onnx"); }

void Heading(const FrameContext& context, const char* text) {
  SmallText(context, colors::kAccent, "%s", text);
  ImGui::Dummy({0, context.Scaled(2)});
}

}  // namespace

std::string NetworkName(const std::string& choice) {
  if (choice.empty()) return "?";
  return IsFile(choice) ? std::filesystem::path(choice).stem().string() : choice;
}

void NetworksSheet::OpenWith(const std::string& file) {
  open_ = true;
  std::snprintf(file_, sizeof(file_), "%s", file.c_str());
}

void NetworksSheet::Draw(const FrameContext& context, CommandSink& sink) {
  if (!open_) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(context.Scaled(kSheetWidth), 0.94f * display.x), 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(24), context.Scaled(18)});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kSheet);
  ImGui::Begin(
      "networks", nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  if (ImGui::IsWindowAppearing()) ImGui::SetWindowFocus();
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted("Networks of this run");
  ImGui::PopFont();
  WrappedText(colors::kDimText,
              context.playback->recorded
                  ? "A recorded run keeps its networks. Open its sequence to map it with others."
                  : "A choice maps the sequence again from its first frame. A run that is recorded "
                    "(--out) is kept; the next one is recorded beside it.");
  ImGui::Dummy({0, context.Scaled(6)});
  if (ImGui::BeginTable("networks.columns", 2, ImGuiTableFlags_SizingStretchSame)) {
    ImGui::TableNextColumn();
    DrawEdges(context, sink);
    ImGui::TableNextColumn();
    DrawDetectors(context, sink);
    ImGui::EndTable();
  }
  if (!context.playback->recorded) DrawOwn(context, sink);
  if (const PlaybackView* next = context.reopening.get()) {
    const bool failed = next->state == PlaybackState::kFailed;
    WrappedText(failed ? colors::kBad : colors::kText,
                failed ? "Nothing has changed: " + next->message : next->message + " ..");
    LogItem(context, "networks.reopening");
  }
  ImGui::Dummy({0, context.Scaled(6)});
  if (Button(context, "networks.close", "Close", "Esc closes it too.") ||
      (ImGui::IsKeyPressed(keys::kEscape, false) && !AsksForPath(context)))
    open_ = false;
  const ImVec2 low = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  context.widgets->Add("networks.sheet", low, {low.x + size.x, low.y + size.y});
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

void NetworksSheet::DrawEdges(const FrameContext& context, CommandSink& sink) const {
  const std::string& now = context.playback->edges;
  const bool has_none = context.sequence != nullptr && !context.sequence->has_edges;
  std::vector<Choice> choices = {
      {"dataset", "dataset", "The sequence's own edges.", has_none ? "It has none (edges/)." : ""},
      {"builtin", "builtin", "Our edge network."},
      {"builtin-half", "builtin-half",
       "One half as wide, for live work: two to three times as fast."},
      {"gradient", "gradient", "Image gradients, no network: the fastest."}};
  if (IsFile(now)) choices.push_back({now, NetworkName(now), now});
  Heading(context, "Edges");
  for (const Choice& choice : choices) {
    if (DrawChoice(context, "networks.edges." + choice.name, choice, choice.choice == now))
      sink.Post(UseNetworksCommand{choice.choice, ""});
  }
}

/// Of one that has not been fetched: a button that does so, how far it is, why it failed.
void DrawFetching(const FrameContext& context, const ListedDetector& detector, CommandSink& sink) {
  const float indent = IndentOfChoice(context);
  ImGui::Indent(indent);
  const std::string widget = "networks.fetch." + detector.name;
  if (!detector.fetching.empty()) {
    if (Button(context, widget, "Stop", "What has arrived is kept; fetching goes on from there."))
      sink.Post(StopFetchingCommand{});
    ImGui::SameLine();
    DimText("%s", detector.fetching.c_str());
  } else {
    const std::string terminal =
        "Downloads it and checks that it is the listed file. In a terminal: plumbline networks "
        "get " +
        detector.name;
    if (Button(context, widget, "Fetch", terminal.c_str()))
      sink.Post(FetchNetworkCommand{detector.name});
  }
  if (!detector.problem.empty()) {
    WrappedText(colors::kBad, detector.problem);
    LogItem(context, widget + ".problem");
  }
  ImGui::Unindent(indent);
  ImGui::Dummy({0, context.Scaled(6)});
}

void NetworksSheet::DrawDetectors(const FrameContext& context, CommandSink& sink) const {
  const std::string& now = context.playback->detector;
  const bool has_none = context.sequence != nullptr && !context.sequence->has_proposals;
  const auto draw = [&](const Choice& choice) {
    const bool chosen = !now.empty() && choice.choice == now;
    if (DrawChoice(context, "networks.detector." + choice.name, choice, chosen))
      sink.Post(UseNetworksCommand{"", choice.choice});
  };
  Heading(context, "Boxes");
  draw({"dataset", "dataset", "The sequence's own boxes.",
        has_none ? "It has none (proposals/)." : ""});
  draw({"builtin", "builtin", "Our network: chairs, tables, cups and nine other kinds of things."});
  bool listed = !IsFile(now);
  if (context.networks != nullptr) {
    for (const ListedDetector& detector : context.networks->detectors) {
      const bool fetched = !detector.file.empty();
      draw({detector.file, detector.name, detector.about, fetched ? "" : "Not fetched yet."});
      if (!fetched && !context.playback->recorded) DrawFetching(context, detector, sink);
      listed |= fetched && detector.file == now;
    }
  }
  if (!listed) draw({now, NetworkName(now), now});
}

/// A file that the user names: first what it is, then whether to use it.
void NetworksSheet::DrawOwn(const FrameContext& context, CommandSink& sink) {
  Heading(context, "A network of your own");
  const char* help =
      "The path of an ONNX network of edges or boxes; it can be dropped onto the window, too.";
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - context.Scaled(96) -
                          BrowseWidth(context));
  const bool entered = ImGui::InputTextWithHint(
      "##networks.file", "FILE.onnx", file_, sizeof(file_), ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "networks.file");
  Tooltip(context, help);
  BrowseButton(context, "networks.browse", [this] {
    return PathQuestion{.title = "Look at a network",
                        .button = "Look at it",
                        .kinds = {PathKind::kNetwork},
                        .at = file_,
                        .answer = [this](const std::string& path, CommandSink& to) {
                          std::snprintf(file_, sizeof(file_), "%s", path.c_str());
                          to.Post(LookAtNetworkCommand{path});
                        }};
  });
  ImGui::SameLine();
  if ((Button(context, "networks.look", "Look at it", help) || entered) && file_[0] != '\0')
    sink.Post(LookAtNetworkCommand{file_});
  if (context.networks == nullptr || context.networks->file.file.empty()) return;
  const NetworkFile& file = context.networks->file;
  if (!file.known) return DimText("looking at %s ..", file.file.c_str());
  if (!file.problem.empty()) {
    WrappedText(colors::kBad, file.problem);
    return LogItem(context, "networks.problem");
  }
  ImGui::Dummy({0, context.Scaled(2)});
  ImGui::TextWrapped("%s: %s%s", NetworkName(file.file).c_str(), file.what.c_str(),
                     file.guessed ? ", a guess" : ", as its sidecar says");
  LogItem(context, "networks.what");
  ImGui::PushFont(context.fonts.small);
  for (const std::string& reason : file.reasons) WrappedText(colors::kDimText, reason);
  ImGui::PopFont();
  const PlaybackView& run = *context.playback;
  if (file.file == (file.edges ? run.edges : run.detector)) return DimText("The run uses it.");
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  const char* use =
      file.guessed ? "Keeps the guess as its sidecar (FILE.json beside it), to be corrected there."
                   : "Maps the sequence again with it.";
  if (Button(context, "networks.use", file.edges ? "Use for edges" : "Use for boxes", use))
    sink.Post(UseNetworksCommand{file.edges ? file.file : "", file.edges ? "" : file.file});
  ImGui::PopStyleColor();
}

}  // namespace plumbline
