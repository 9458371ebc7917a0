// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/processes/processes_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/snapshot/graph_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr int kColumns = 6;
constexpr double kYoung_s = 3;  ///< A node that is not older was started (again) just now.

class ProcessesPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    if (context.graph == nullptr || !context.graph->problem.empty()) return;
    const bool over = IsOver(context);
    const std::string text = over ? "the run has ended" : Summary(*context.graph);
    const bool warns = !over && NumSilent(*context.graph) > 0;
    AlignRight(
        context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, text.c_str()).x);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(3));
    SmallText(context, warns ? colors::kWarning : colors::kDimText, "%s", text.c_str());
    LogItem(context, "processes.summary");
    Tooltip(
        context,
        context.graph->name +
            "\nProcessor time of the last second and memory of those that answer. From image to "
            "map: from when\nthe mapper had the image until its report was done; where every "
            "frame is mapped, it waits in a queue first.");
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    if (context.graph == nullptr)
      return EmptyState(context, "Asking the processes", "They are asked once a second.");
    const GraphView& graph = *context.graph;
    if (!graph.problem.empty())
      return EmptyState(context, "The processes cannot be asked", graph.problem.c_str());
    ImGui::PushFont(context.fonts.small);
    constexpr auto kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                            ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoBordersInBody;
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(6), context.Scaled(1.5f)});
    if (ImGui::BeginTable("processes.table", kColumns, kFlags, ImGui::GetContentRegionAvail())) {
      ImGui::TableSetupColumn("node");
      ImGui::TableSetupColumn("says", ImGuiTableColumnFlags_WidthStretch);
      ImGui::TableSetupScrollFreeze(0, 1);
      DrawHeading(context);
      for (const NodeView& node : graph.nodes) DrawNode(context, node);
      ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::PopFont();
  }

 private:
  /// They have ended because the run has.
  static bool IsOver(const FrameContext& context) {
    return !context.playback->growing &&
           NumSilent(*context.graph) == std::ssize(context.graph->nodes);
  }

  static long NumSilent(const GraphView& graph) {
    return std::count_if(graph.nodes.begin(), graph.nodes.end(),
                         [](const NodeView& node) { return !node.answers; });
  }

  static std::string Summary(const GraphView& graph) {
    double cores = 0, resident_mb = 0;
    std::string latency;
    for (const NodeView& node : graph.nodes) {
      if (!node.answers) continue;
      cores += node.cores;
      resident_mb += node.resident_mb;
      if (node.kind == "mapper" && !node.streams.empty())
        latency = fmt::format("image to map {:.0f} ms, ", node.streams.front().latency_ms);
    }
    const std::string usage = fmt::format("{}{:.1f} cores, {:.0f} MB", latency, cores, resident_mb);
    if (const long silent = NumSilent(graph); silent > 0)
      return fmt::format("{} of {} do not answer; {}", silent, graph.nodes.size(), usage);
    return usage;
  }

  static void Right(ImU32 color, const std::string& text) {
    ImGui::TableNextColumn();
    const float width = ImGui::CalcTextSize("000000").x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() +
                         std::max(0.0f, width - ImGui::CalcTextSize(text.c_str()).x));
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopStyleColor();
  }

  static void DrawHeading(const FrameContext& context) {
    constexpr const char* kHelp[] = {"Of late.",
                                     ("How long one took, mean of late: reading an image, finding "
                                      "edges, asking the detector, mapping a frame."),
                                     "Passed over: of a live run, images that were too old.",
                                     "Processor time over the last second, in cores."};
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TableNextColumn();
    int column = 0;
    for (const char* title : {"a second", "ms", "dropped", "cores"}) {
      Right(colors::kFaint, title);
      Tooltip(context, kHelp[column++]);
    }
  }

  static void DrawNode(const FrameContext& context, const NodeView& node) {
    const bool young = node.answers && node.restarts > 0 && node.up_s < kYoung_s;
    const bool over = IsOver(context);
    const ImU32 color = over                        ? colors::kFaint
                        : !node.answers             ? colors::kBad
                        : young || node.refused > 0 ? colors::kWarning
                                                    : colors::kGood;
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float line = ImGui::GetTextLineHeight();
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + 0.35f * line, at.y + 0.55f * line},
                                                0.24f * line, color);
    ImGui::SetCursorScreenPos({at.x + 0.95f * line, at.y});
    ImGui::TextUnformatted(node.name.c_str());
    LogItem(context, "processes." + node.name);
    Tooltip(context, About(node));
    ImGui::TableNextColumn();
    std::string says = node.answers ? node.state : over ? "has ended" : "does not answer";
    if (node.restarts > 0)
      says += node.restarts == 1 ? ", started again once"
                                 : fmt::format(", started again {} times", node.restarts);
    if (node.refused > 0) says += fmt::format(", refused {}", node.refused);
    ImGui::PushStyleColor(ImGuiCol_Text, color == colors::kGood || over ? colors::kDimText : color);
    ImGui::TextUnformatted(says.c_str());
    ImGui::PopStyleColor();
    Tooltip(context, About(node));
    DrawStream(node.streams.empty() ? nullptr : &node.streams.front());
    Right(colors::kDimText, node.answers ? fmt::format("{:.2f}", node.cores) : "");
  }

  static void DrawStream(const StreamView* stream) {
    if (stream == nullptr) {
      for (int i = 0; i < 3; ++i) ImGui::TableNextColumn();
      return;
    }
    Right(colors::kText, fmt::format("{:.1f}", stream->per_s));
    Right(colors::kText, stream->latency_ms > 0 ? fmt::format("{:.0f}", stream->latency_ms) : "");
    Right(stream->dropped > 0 ? colors::kWarning : colors::kFaint,
          fmt::format("{}", stream->dropped));
  }

  static std::string About(const NodeView& node) {
    std::string text = fmt::format("{} ({}), at {}", node.name, node.kind, node.endpoint);
    if (node.process == 0) return text + "\nIt has not answered yet.";
    text += fmt::format("\nProcess {}, up {:.0f} s, {:.0f} MB; {} requests, {} wait", node.process,
                        node.up_s, node.resident_mb, node.requests, node.waiting);
    for (const StreamView& stream : node.streams)
      text += fmt::format("\n{}: {}, {:.1f} a second, {:.1f} ms each", stream.name, stream.items,
                          stream.per_s, stream.latency_ms);
    for (const PeerView& peer : node.peers) {
      text += fmt::format("\nasks {}: {} requests, {} open, {:.1f} ms each", peer.name,
                          peer.requests, peer.open, peer.mean_wait_ms);
      if (peer.asked_again > 0) text += fmt::format(", {} asked again", peer.asked_again);
      if (!peer.connected) text += ", not connected";
    }
    if (node.clock_ahead_ms)
      text += fmt::format(
          "\nIts clock is {:.1f} ms {} ours, within {:.1f} ms", std::abs(*node.clock_ahead_ms),
          *node.clock_ahead_ms > 0 ? "ahead of" : "behind", node.clock_uncertainty_ms);
    return text;
  }
};

}  // namespace

std::unique_ptr<Panel> MakeProcessesPanel() { return std::make_unique<ProcessesPanel>(); }

}  // namespace plumbline
