// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timings_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/networks_sheet.h"
#include "ui/inspect/timeline/timings_plot.h"

namespace plumbline {
namespace {

class TimingsPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Over time"));
    Toggle(context, "timings.over_time", "Over time", over_time_,
           "The stages of all frames so far, one upon the other.");
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    if (DrawWaiting(context)) return;
    Remember(context);
    ImGui::PushFont(context.fonts.small);
    DrawRates(context);
    if (over_time_) {
      DrawTimingsPlot(context);
      return ImGui::PopFont();
    }
    ImGui::BeginChild("timings.scroll", ImGui::GetContentRegionAvail());
    const auto& timings = context.snapshot->report.timings;
    double total = 0, longest = 1;
    for (const StageTiming& timing : timings) {
      total += timing.milliseconds;
      longest = std::max({longest, timing.milliseconds, means_[timing.stage]});
    }
    const bool wide = ImGui::GetContentRegionAvail().x > context.Scaled(240);
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(4), context.Scaled(2)});
    if (ImGui::BeginTable("timings.table", wide ? 4 : 3, ImGuiTableFlags_SizingFixedFit)) {
      ImGui::TableSetupColumn("stage");
      ImGui::TableSetupColumn("bar", ImGuiTableColumnFlags_WidthStretch);
      ImGui::TableSetupColumn("now");
      if (wide) ImGui::TableSetupColumn("mean");
      for (const StageTiming& timing : timings) {
        Row(context, timing.stage, timing.milliseconds, wide ? means_[timing.stage] : -1, longest,
            StageColor(static_cast<std::size_t>(&timing - timings.data())),
            NetworkOf(context, timing.stage));
      }
      Row(context, "frame", total, wide ? mean_total_ : -1, 0, colors::kText,
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
    ImGui::PopFont();
  }

  nlohmann::json SaveState() const override { return {{"over_time", over_time_}}; }
  void LoadState(const nlohmann::json& json) override {
    over_time_ = json.value("over_time", over_time_);
  }

 private:
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

  void Remember(const FrameContext& context) {
    if (version_ == context.snapshot_version) return;
    version_ = context.snapshot_version;
    if (source_version_ != context.source_version) {  // another run
      source_version_ = context.source_version;
      means_.clear();
      mean_total_ = 0;
    }
    double total = 0;
    for (const StageTiming& timing : context.snapshot->report.timings) {
      total += timing.milliseconds;
      const auto [entry, is_new] = means_.emplace(timing.stage, timing.milliseconds);
      if (!is_new) entry->second += kShare * (timing.milliseconds - entry->second);
    }
    mean_total_ = mean_total_ == 0 ? total : mean_total_ + kShare * (total - mean_total_);
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
    Tooltip(context, "Running mean over about 30 frames.");
  }

  static constexpr double kShare = 1.0 / 30;
  bool over_time_ = false;
  std::map<std::string, double> means_;
  double mean_total_ = 0;
  std::uint64_t version_ = 0, source_version_ = 0;
};

}  // namespace

std::unique_ptr<Panel> MakeTimingsPanel() { return std::make_unique<TimingsPanel>(); }

}  // namespace plumbline
