// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timings_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/networks_sheet.h"
#include "ui/inspect/timeline/timings_plot.h"

namespace plumbline {
namespace {

class TimingsPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Whole run") + ToggleWidth(context, "Over time") +
               context.Scaled(3));
    const bool changed = Toggle(context, "timings.whole_run", "Whole run", whole_run_,
                                "Mean, median, 95 % and worst of each stage over all frames, and "
                                "the slowest frames.");
    if (changed) over_time_ = false;
    ImGui::SameLine();
    if (Toggle(context, "timings.over_time", "Over time", over_time_,
               "The stages of all frames so far, one upon the other; a click goes to the frame."))
      whole_run_ = false;
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    sink.Post(NeedCommand{NeedCommand::What::kTimings, {}});
    ImGui::PushFont(context.fonts.small);
    DrawRates(context);
    if (over_time_)
      DrawTimingsPlot(context, sink);
    else if (whole_run_)
      DrawWholeRun(context, sink);
    else
      DrawFrame(context);
    ImGui::PopFont();
  }

  nlohmann::json SaveState() const override {
    return {{"over_time", over_time_}, {"whole_run", whole_run_}};
  }
  void LoadState(const nlohmann::json& json) override {
    over_time_ = KeptValue(json, "over_time", over_time_);
    whole_run_ = KeptValue(json, "whole_run", whole_run_);
  }

 private:
  /// Of a stage over the run; 0 while it is not known.
  static double MeanOf(const FrameContext& context, const std::string& stage) {
    if (context.timings == nullptr) return 0;
    for (const StageStatistics& of : context.timings->stages) {
      if (of.stage == stage) return of.mean_ms;
    }
    return 0;
  }

  static void DrawFrame(const FrameContext& context) {
    ImGui::BeginChild("timings.scroll", ImGui::GetContentRegionAvail());
    const auto& timings = context.snapshot->report.timings;
    double total = 0, longest = 1;
    for (const StageTiming& timing : timings) {
      total += timing.milliseconds;
      longest = std::max({longest, timing.milliseconds, MeanOf(context, timing.stage)});
    }
    const bool wide =
        context.timings != nullptr && ImGui::GetContentRegionAvail().x > context.Scaled(240);
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(4), context.Scaled(2)});
    if (ImGui::BeginTable("timings.table", wide ? 4 : 3, ImGuiTableFlags_SizingFixedFit)) {
      ImGui::TableSetupColumn("stage");
      ImGui::TableSetupColumn("bar", ImGuiTableColumnFlags_WidthStretch);
      ImGui::TableSetupColumn("now");
      if (wide) ImGui::TableSetupColumn("mean");
      for (const StageTiming& timing : timings) {
        Row(context, timing.stage, timing.milliseconds, wide ? MeanOf(context, timing.stage) : -1,
            longest, StageColor(static_cast<std::size_t>(&timing - timings.data())),
            NetworkOf(context, timing.stage));
      }
      Row(context, "frame", total, wide ? context.timings->all.mean_ms : -1, 0, colors::kText,
          "The work of all stages. Edges and boxes are found ahead, at the same time, so that a "
          "frame\n"
          "may come sooner.");
      Row(context, "window", context.window_ms, -1, 0, colors::kDimText);
      Tooltip(context, "CPU time of drawing the window.");
      Row(context, "3-D view", context.scene_ms, -1, 0, colors::kDimText);
      ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::EndChild();
  }

  static void Cell(ImU32 color, const std::string& text) {
    ImGui::TableNextColumn();
    const float width = ImGui::CalcTextSize("00000.0").x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + width - ImGui::CalcTextSize(text.c_str()).x);
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopStyleColor();
  }

  static void StatisticsRow(const FrameContext& context, const StageStatistics& of,
                            CommandSink& sink) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const std::string name = "timings.stage." + of.stage;
    if (ImGui::Selectable((of.stage + "##" + name).c_str(), false,
                          ImGuiSelectableFlags_SpanAllColumns))
      sink.Post(SeekCommand{of.worst_frame});
    LogItem(context, name);
    Tooltip(context, fmt::format("Longest in frame {}; a click goes there.", of.worst_frame));
    for (const double ms : {of.mean_ms, of.median_ms, of.most_of_95_ms, of.worst_ms})
      Cell(ms == of.worst_ms ? colors::kWarning : colors::kText, fmt::format("{:.1f}", ms));
  }

  static void DrawWholeRun(const FrameContext& context, CommandSink& sink) {
    const TimingStatistics* statistics = context.timings.get();
    if (statistics == nullptr || statistics->frames == 0)
      return EmptyState(context, "No times yet", "They are being read.");
    ImGui::BeginChild("timings.scroll", ImGui::GetContentRegionAvail());
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(4), context.Scaled(2)});
    DimText("%d frames, in ms", statistics->frames);
    if (ImGui::BeginTable("timings.statistics", 5, ImGuiTableFlags_SizingFixedFit)) {
      ImGui::TableSetupColumn("stage", ImGuiTableColumnFlags_WidthStretch);
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      for (const char* title : {"mean", "median", "95 %", "worst"}) Cell(colors::kFaint, title);
      for (const StageStatistics& of : statistics->stages) StatisticsRow(context, of, sink);
      StatisticsRow(context, statistics->all, sink);
      ImGui::EndTable();
    }
    DimText("Slowest frames");
    for (std::size_t i = 0; i < statistics->slowest.size(); ++i) {
      const TimingStatistics::SlowFrame& slow = statistics->slowest[i];
      const std::string name = fmt::format("timings.slow.{}", i);
      const std::string text =
          fmt::format("frame {}: {:.0f} ms, of which {} {:.0f}##{}", slow.frame, slow.total_ms,
                      slow.stage, slow.stage_ms, name);
      if (ImGui::Selectable(text.c_str(), slow.frame == context.playback->frame))
        sink.Post(SeekCommand{slow.frame});
      LogItem(context, name);
    }
    ImGui::PopStyleVar();
    ImGui::EndChild();
  }

  /// Hypotheses a second, and frames that were not used.
  static void DrawRates(const FrameContext& context) {
    double update_ms = 0;
    std::size_t hypotheses = 0;
    for (const StageTiming& timing : context.snapshot->report.timings) {
      // "weigh" in runs of version 0.1.0.
      if (timing.stage == "update" || timing.stage == "weigh" || timing.stage == "score boxes")
        update_ms += timing.milliseconds;
    }
    for (const ObjectReport& object : context.snapshot->report.objects) {
      // Birth has a stage of its own.
      const bool born_now = object.first_frame == context.snapshot->report.frame;
      if (object.updated && !born_now && object.particles != nullptr)
        hypotheses += object.particles->size();
    }
    int skipped = 0;
    for (const auto& frame : context.playback->history->frames)
      skipped += frame != nullptr && frame->skipped;
    if (hypotheses > 0 && update_ms > 0)
      DimText("%.0f 000 hypotheses/s", std::ceil(static_cast<double>(hypotheses) / update_ms));
    else
      DimText("no hypotheses updated");
    Tooltip(
        context,
        "Particles updated in this frame, over the time of the stages 'update' and 'score boxes'.");
    ImGui::SameLine(0, context.Scaled(12));
    if (skipped > 0)
      SmallText(context, colors::kWarning, "%d frames skipped", skipped);
    else
      DimText("none skipped");
    Tooltip(context, "Frames of this run that could not be used.");
    if (!context.playback->live) return;
    ImGui::SameLine(0, context.Scaled(12));
    DimText("%d passed over", context.playback->live->passed_over);
    Tooltip(context, "Frames that came by the clock while the mapper was busy.");
  }

  /// Which network a stage waits for; "": none.
  static std::string NetworkOf(const FrameContext& context, const std::string& stage) {
    const PlaybackView& run = context.shown_playback();
    const std::string edges = NetworkName(run.edges), boxes = NetworkName(run.detector);
    constexpr const char* kCached =
        "\nWhat a network has made of an image before is read from the cache.";
    if (stage == "edges") return "Edges: " + edges + "." + kCached;
    if (stage == "detect") return "Boxes in the image (bottom-up): " + boxes + "." + kCached;
    if (stage == "score boxes") return "Scores of the hypotheses' boxes (top-down): " + boxes + ".";
    return "";
  }

  /// Without a bar where `longest` is 0, without a mean where it is negative.
  static void Row(const FrameContext& context, const std::string& name, double now, double mean,
                  double longest, ImU32 color, const std::string& help = "") {
    const auto number = [&](double value, ImU32 ink) {
      const std::string text = fmt::format("{:.1f} ms", value);
      const float width = ImGui::CalcTextSize("0000.0 ms").x;
      ImGui::SetCursorPosX(ImGui::GetCursorPosX() + width - ImGui::CalcTextSize(text.c_str()).x);
      ImGui::PushStyleColor(ImGuiCol_Text, ink);
      ImGui::TextUnformatted(text.c_str());
      ImGui::PopStyleColor();
    };
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::PushStyleColor(ImGuiCol_Text, longest > 0 ? colors::kDimText : color);
    ImGui::TextUnformatted(name.c_str());
    ImGui::PopStyleColor();
    LogItem(context, "timings." + name);
    Tooltip(context, help);
    ImGui::TableNextColumn();
    if (longest > 0) {
      ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 0.25f * ImGui::GetTextLineHeight());
      Bar({std::max(4.0f, ImGui::GetContentRegionAvail().x), 0.5f * ImGui::GetTextLineHeight()},
          now / longest, color);
    }
    ImGui::TableNextColumn();
    number(now, longest > 0 ? colors::kText : color);
    if (mean < 0) return;
    ImGui::TableNextColumn();
    number(mean, colors::kFaint);
    Tooltip(context, "Mean over all frames of the run.");
  }

  bool over_time_ = false, whole_run_ = false;  ///< If both, the former shows.
};

}  // namespace

std::unique_ptr<Panel> MakeTimingsPanel() { return std::make_unique<TimingsPanel>(); }

}  // namespace plumbline
