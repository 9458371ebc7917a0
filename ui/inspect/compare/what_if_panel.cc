// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/what_if_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/angles.h"
#include "engine/snapshot/comparison_view.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

struct ShownToggle {
  const char* name;
  const char* label;
  RunShown shown;
  const char* tooltip;
};
constexpr ShownToggle kShown[] = {
    {"what_if.first", "First", RunShown::kFirst, "The window shows the run that was opened (V)."},
    {"what_if.other", "Other", RunShown::kOther,
     "The window shows the other run: images, map, objects and answers are its own (V)."},
    {"what_if.blink", "Blink", RunShown::kBlink,
     "Blink between the two runs: whatever moves differs."},
    {"what_if.beside", "Beside", RunShown::kBeside, "The images of both, one above the other."},
};

class WhatIfPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    const float gap = context.Scaled(3);
    const bool live = context.sequence != nullptr && !context.playback->recorded;
    float width = ToggleWidth(context, "Fork from here");
    if (live) width += ToggleWidth(context, "Options") + gap;
    if (context.other != nullptr) {
      for (const ShownToggle& toggle : kShown) width += ToggleWidth(context, toggle.label) + gap;
      width += ToggleWidth(context, "Close") + context.Scaled(20);
    }
    AlignRight(width);
    if (live) {
      bool options = false;
      if (Toggle(context, "what_if.options", "Options", options,
                 "Changes options of this run between two frames, while it is mapped."))
        sink.Post(AskOptionsCommand{});
      ImGui::SameLine(0, gap);
    }
    bool fork = context.fork != nullptr && context.fork->state == ForkState::kRunning;
    if (Toggle(context, "what_if.fork", "Fork from here", fork,
               "Continues from this frame with other options or another seed, in a second run."))
      sink.Post(AskForkCommand{});
    if (context.other == nullptr) return;
    ImGui::SameLine(0, context.Scaled(12));
    for (const ShownToggle& toggle : kShown) {
      bool on = context.run_shown == toggle.shown;
      if (Toggle(context, toggle.name, toggle.label, on, toggle.tooltip))
        sink.Post(ShowRunCommand{toggle.shown});
      ImGui::SameLine(0, gap);
    }
    bool close = false;
    ImGui::SameLine(0, context.Scaled(8));
    if (Toggle(context, "what_if.close", "Close", close, "Closes the other run."))
      sink.Post(CompareRunCommand{});
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    if (context.fork != nullptr && context.fork->state == ForkState::kRunning)
      DrawProgress(context, *context.fork, sink);
    const OtherRun* other = context.other.get();
    if (other == nullptr)
      return EmptyState(context, "One run is open",
                        context.playback->recorded
                            ? "Fork it from here with other options or another seed, or give a "
                              "second one: plumbline gui RUN.plb --compare OTHER.plb"
                            : "Change its options while it is mapped, or fork it at any frame that "
                              "it has mapped.");
    if (other->playback->state == PlaybackState::kFailed)
      return EmptyState(context, "The other run cannot be shown", other->playback->message.c_str());
    if (other->comparison == nullptr)
      return EmptyState(context, "Opening the other run", other->source.c_str());
    ImGui::PushFont(context.fonts.small);
    DrawSettings(context, *other->comparison);
    const float room = ImGui::GetContentRegionAvail().x;
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(6), context.Scaled(3)});
    ImGui::BeginChild("what_if.left", {0.66f * room, 0});
    DrawObjects(context, *other, sink);
    ImGui::EndChild();
    ImGui::SameLine(0, context.Scaled(10));
    ImGui::BeginChild("what_if.right", {0, 0});
    DrawStages(context, *other->comparison);
    ImGui::EndChild();
    ImGui::PopStyleVar();
    ImGui::PopFont();
  }

 private:
  static void DrawProgress(const FrameContext& context, const ForkView& fork, CommandSink& sink) {
    const float stop = context.Scaled(70);
    const double share = fork.total > 0 ? static_cast<double>(fork.done) / fork.total : 0;
    Bar({ImGui::GetContentRegionAvail().x - stop, ImGui::GetFrameHeight()}, share,
        colors::kAccentDim);
    LogItem(context, "what_if.progress");
    Tooltip(context, fork.out);
    const ImVec2 low = ImGui::GetItemRectMin();
    const ImVec2 inset = ImGui::GetStyle().FramePadding;
    const std::string text = fork.total > 0
                                 ? fmt::format("{}: {} of {}", fork.message, fork.done, fork.total)
                                 : fork.message;
    ImGui::GetWindowDrawList()->AddText({low.x + inset.x, low.y + inset.y}, colors::kText,
                                        text.c_str());
    ImGui::SameLine();
    if (Button(context, "what_if.stop", "Stop", "Ends the fork; what is done is kept and shown."))
      sink.Post(CancelForkCommand{});
  }

  static void DrawSettings(const FrameContext& context, const ComparisonView& comparison) {
    std::string text;
    for (const std::string& setting : comparison.settings)
      text += (text.empty() ? "" : ",  ") + setting;
    if (text.empty()) text = "same settings";
    ImGui::PushStyleColor(ImGuiCol_Text, colors::kText);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopStyleColor();
    LogItem(context, "what_if.settings");
    Tooltip(context, "What the runs were made with, where it differs: first / other.\n" + text);
    ImGui::SameLine(0, context.Scaled(14));
    if (comparison.first_difference)
      DimText("first difference in frame %d", *comparison.first_difference);
    else
      DimText("no difference so far");
    LogItem(context, "what_if.difference");
    Tooltip(context, "The first frame in which the beliefs of the two runs are not the same.");
  }

  static void Headings(const FrameContext& context,
                       std::initializer_list<std::pair<const char*, const char*>> columns) {
    for (const auto& [name, help] : columns) ImGui::TableSetupColumn(name);
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableNextRow(ImGuiTableRowFlags_Headers);
    for (const auto& [name, help] : columns) {
      ImGui::TableNextColumn();
      DimText("%s", name);
      Tooltip(context, help);
    }
  }

  static std::optional<TruthError> ErrorIn(const RunHistory& history, int frame,
                                           const ObjectReport* object) {
    if (object == nullptr) return std::nullopt;
    const auto found = std::lower_bound(
        history.frames.begin(), history.frames.end(), frame,
        [](const auto& sample, int wanted) { return sample != nullptr && sample->frame < wanted; });
    if (found == history.frames.end() || *found == nullptr || (*found)->frame != frame)
      return std::nullopt;
    for (const ObjectSample& sample : (*found)->objects) {
      if (sample.id == object->id) return sample.error;
    }
    return std::nullopt;
  }

  static void ErrorText(const std::optional<TruthError>& error) {
    if (error)
      ImGui::Text("%.1f cm  %.0f\u00b0", 100.0 * error->translation_m,
                  kDegPerRad * error->azimuth_rad);
    else
      DimText("\u2013");
  }

  /// Modulo the symmetry of the shape [deg].
  static double Turned(const FrameContext& context, const ObjectPair& pair) {
    const ModelView* model = context.Model(pair.a->label);
    const double turned = kDegPerRad * pair.azimuth_rad;
    if (model == nullptr || pair.a->label != pair.b->label) return turned;
    if (model->any_azimuth) return 0;
    const double period = 360.0 / std::max(1, model->symmetry_order);
    return std::abs(std::remainder(turned, period));
  }

  static void NameText(const FrameContext& context, const ObjectLooks* looks,
                       const ObjectReport* object) {
    if (object == nullptr) return DimText("missing");
    const ModelView* model = context.Model(object->label);
    Chip(context, ColorOfLook(FrameContext::LookOf(looks, object->id)));
    ImGui::Text("#%d %s", object->id.value,
                model != nullptr ? model->name.c_str() : object->category.c_str());
  }

  static void DrawObjects(const FrameContext& context, const OtherRun& other, CommandSink& sink) {
    constexpr auto kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                            ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_NoBordersInBody;
    if (!ImGui::BeginTable("what_if.objects", 5, kFlags, ImGui::GetContentRegionAvail())) return;
    Headings(context, {{"First", "Confirmed objects of the run that was opened, in this frame."},
                       {"Other", "The same object in the other run: of its category, nearest."},
                       {"Apart", "Distance and turn between the two."},
                       {"Error, first", "Position and azimuth against ground truth, if any."},
                       {"Error, other", "Position and azimuth against ground truth, if any."}});
    const ComparisonView& comparison = *other.comparison;
    const FrameReport &a = comparison.a->report, &b = comparison.b->report;
    int row = 0;
    for (const ObjectPair& pair : comparison.pairs) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      const std::string name = fmt::format("what_if.row.{}", row++);
      const ObjectReport* object = context.shows_other ? pair.b : pair.a;
      const bool selected = object != nullptr && object->id == context.selection.object;
      if (ImGui::Selectable(("##" + name).c_str(), selected, ImGuiSelectableFlags_SpanAllColumns) &&
          object != nullptr)
        sink.Post(SelectObjectCommand{object->id});
      LogItem(context, name);
      ImGui::SameLine(0, 0);
      NameText(context, context.first_looks.get(), pair.a);
      ImGui::TableNextColumn();
      NameText(context, context.other->looks.get(), pair.b);
      ImGui::TableNextColumn();
      if (pair.a != nullptr && pair.b != nullptr)
        ImGui::Text("%.1f cm  %.0f\u00b0", 100 * pair.distance_m, Turned(context, pair));
      else
        DimText("\u2013");
      ImGui::TableNextColumn();
      ErrorText(ErrorIn(*context.playback->history, a.frame, pair.a));
      ImGui::TableNextColumn();
      ErrorText(ErrorIn(*other.playback->history, b.frame, pair.b));
    }
    ImGui::EndTable();
  }

  static void DrawStages(const FrameContext& context, const ComparisonView& comparison) {
    constexpr auto kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                            ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_NoBordersInBody;
    if (!ImGui::BeginTable("what_if.stages", 3, kFlags, ImGui::GetContentRegionAvail())) return;
    Headings(context, {{"Mean time", "Of each stage, over all frames of the run."},
                       {"First", "Milliseconds a frame."},
                       {"Other", "Milliseconds a frame."}});
    for (const StageDifference& stage : comparison.stages) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      DimText("%s", stage.stage.c_str());
      ImGui::TableNextColumn();
      ImGui::Text("%.1f ms", stage.mean_a_ms);
      ImGui::TableNextColumn();
      ImGui::Text("%.1f ms", stage.mean_b_ms);
    }
    ImGui::EndTable();
  }
};

}  // namespace

ActionGroup TwoRunActions() {
  const auto two = [](const FrameContext& context) { return context.other != nullptr; };
  return {
      "What if?",
      {{.text = "Fork the run from here: what if?", .run = Posts(AskForkCommand{})},
       {.text = "Change options of this run: what if?",
        .run = Posts(AskOptionsCommand{}),
        .is_offered = [](const FrameContext& context) { return !context.playback->recorded; }},
       {.text = "Networks of this run: edges and boxes", .run = Posts(AskNetworksCommand{})},
       {.text = "Two runs: open another beside this one",
        .run =
            [](const FrameContext& context, CommandSink&) {
              AskPath(context, {.title = "Open another run of the same sequence beside this one",
                                .button = "Open",
                                .kinds = {PathKind::kRun},
                                .answer = [](const std::string& path, CommandSink& sink) {
                                  sink.Post(CompareRunCommand{path});
                                }});
            },
        .is_offered = [](const FrameContext& context) { return context.sequence != nullptr; }},
       {.text = "Two runs: show the other",
        .keys = {{keys::kV}},
        .run =
            [](const FrameContext& context, CommandSink& sink) {
              const bool other = context.run_shown == RunShown::kOther;
              sink.Post(ShowRunCommand{other ? RunShown::kFirst : RunShown::kOther});
            },
        .help_keys = "V",
        .help = "This run or the other, where two are open",
        .text_when_on = "Two runs: show the first",
        .is_on = [](const FrameContext& context) { return context.run_shown == RunShown::kOther; },
        .is_offered = two},
       {.text = "Two runs: blink",
        .run = Posts(ShowRunCommand{RunShown::kBlink}),
        .is_offered = two},
       {.text = "Two runs: side by side",
        .run = Posts(ShowRunCommand{RunShown::kBeside}),
        .is_offered = two},
       {.text = "Two runs: close the other",
        .run = Posts(CompareRunCommand{}),
        .is_offered = two}}};
}

std::unique_ptr<Panel> MakeWhatIfPanel() { return std::make_unique<WhatIfPanel>(); }

}  // namespace plumbline
