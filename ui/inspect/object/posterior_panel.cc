// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/snapshot/calibration.h"
#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/object/label_plot.h"
#include "ui/inspect/object/posterior_marginals.h"
#include "ui/inspect/panels.h"

namespace plumbline {
namespace {

void Words(const FrameContext& context, ImVec2 at, float align, ImU32 color,
           const std::string& words) {
  ImFont* font = context.fonts.small;
  const float width = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width, at.y}, color,
                                      words.c_str());
}

std::string Percent(int part, int whole) {
  return whole > 0 ? fmt::format("{:.0f} %", 100.0 * part / whole) : "\u2013";
}

class PosteriorPanel : public Panel {
 public:
  const char* Id() const override { return "posterior"; }
  const char* Title() const override { return "Belief"; }
  const char* Help() const override {
    return "How the hypotheses of the selected object spread along each parameter, in the camera "
           "of its reference time; what it was believed to be over time; and, where there is "
           "ground truth, whether beliefs of this run "
           "are honest: the truth should lie in half of the 50 % regions and in 95 of 100 of the "
           "95 % regions.";
  }

  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Shapes over time"));
    Toggle(context, "posterior.shapes", "Shapes over time", shapes_,
           "What the object was believed to be, frame by frame, instead of its parameters now.");
  }

  nlohmann::json SaveState() const override { return {{"shapes", shapes_}}; }
  void LoadState(const nlohmann::json& json) override { shapes_ = json.value("shapes", shapes_); }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr || object->particles == nullptr || object->particles->empty())
      return EmptyState(context, "No hypotheses",
                        "Select an object in the list, in an image or in the map.");
    ImGui::PushFont(context.fonts.small);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const bool beside = room.x > context.Scaled(520) && room.y > context.Scaled(60);
    const float side = beside ? context.Scaled(250) : 0;
    Remember(context, *object);
    if (shapes_)
      DrawLabelPlot(context, labels_, corner, {room.x - side, room.y}, sink);
    else
      DrawMarginals(context, corner, {room.x - side, room.y});
    if (beside) {
      ImGui::SetCursorScreenPos({corner.x + room.x - side + context.Scaled(14), corner.y});
      ImGui::BeginChild("posterior.honest", {side - context.Scaled(14), room.y});
      DrawHonesty(context);
      ImGui::EndChild();
    }
    ImGui::PopFont();
  }

 private:
  void Remember(const FrameContext& context, const ObjectReport& object) {
    const RunHistory* history = context.shown_playback().history.get();
    const bool same = version_ == context.snapshot_version && object_ == object.id;
    if (same && history_ == history) return;
    version_ = context.snapshot_version;
    object_ = object.id;
    history_ = history;
    marginals_ = MarginalsOf(context, object);
    all_ = CalibrationOf(*history);
    this_ = CalibrationOf(*history, object.id);
    labels_ = LabelsOf(*history, object.id);
  }

  void DrawMarginals(const FrameContext& context, ImVec2 corner, ImVec2 room) const {
    const float gap = context.Scaled(10);
    const ImVec2 size(0.5f * (room.x - gap), 0.5f * (room.y - 0.5f * gap));
    if (size.x < 30 || size.y < 3 * context.fonts.small->FontSize) return;
    for (int axis = 0; axis < 4; ++axis) {
      DrawHistogram(context, axis,
                    {corner.x + static_cast<float>(axis % 2) * (size.x + gap),
                     corner.y + static_cast<float>(axis / 2) * (size.y + 0.5f * gap)},
                    size);
    }
  }

  void DrawHistogram(const FrameContext& context, int axis, ImVec2 corner, ImVec2 size) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = context.fonts.small->FontSize;
    const ImVec2 low(corner.x, corner.y + font + 1),
        high(corner.x + size.x, corner.y + size.y - font);
    draw.AddRectFilled(low, high, colors::kInset, context.Scaled(2));
    const auto& share = marginals_.share[axis];
    const double tallest = *std::max_element(std::begin(share), std::end(share));
    const float width = size.x / kMarginalBins;
    const ImU32 color = ObjectColor(object_);
    for (int i = 0; i < kMarginalBins; ++i) {
      const auto tall = static_cast<float>(share[i] / tallest) * (high.y - low.y - 2);
      draw.AddRectFilled({low.x + width * static_cast<float>(i), high.y - tall},
                         {low.x + width * static_cast<float>(i + 1) - 1, high.y},
                         WithAlpha(color, 0.65));
    }
    const auto x_of = [&](double v) {
      return low.x + static_cast<float>((v - marginals_.low[axis]) /
                                        (marginals_.high[axis] - marginals_.low[axis])) *
                         size.x;
    };
    const auto line = [&](double v, ImU32 ink) {
      const float x = x_of(v);
      if (x >= low.x && x <= high.x)
        draw.AddLine({x, low.y}, {x, high.y}, ink, context.Scaled(1.5));
    };
    line(marginals_.mean[axis], colors::kText);
    if (marginals_.truth) line(marginals_.truth->value[axis], colors::kTruth);
    const auto number = [&](double v) {
      return axis == kDepthAxis ? fmt::format("{:.2f} m", std::exp(v))
                                : fmt::format("{:.1f}{}", v, kParameterAxes[axis].unit);
    };
    const std::string spread =
        axis == kDepthAxis
            ? fmt::format("{:.1f} %", 100 * marginals_.std[axis])
            : fmt::format("{:.1f}{}", marginals_.std[axis], kParameterAxes[axis].unit);
    Words(context, corner, 0, colors::kDimText, kParameterAxes[axis].name);
    Words(context, {high.x, corner.y}, 1, colors::kText,
          fmt::format("{} \u00b1 {}", number(marginals_.mean[axis]), spread));
    Words(context, {low.x, high.y}, 0, colors::kFaint, number(marginals_.low[axis]));
    Words(context, {high.x, high.y}, 1, colors::kFaint, number(marginals_.high[axis]));
    if (marginals_.truth)
      Words(context, {0.5f * (low.x + high.x), high.y}, 0.5f, colors::kTruth,
            "truth " + number(marginals_.truth->value[axis]));
    ImGui::SetCursorScreenPos(corner);
    ImGui::InvisibleButton(kParameterAxes[axis].name, size);
    LogItem(context, fmt::format("posterior.axis.{}", axis));
    Tooltip(context, std::string(kParameterAxes[axis].help) +
                         " Bars: the particles by weight. White: their mean. Green: the truth.");
  }

  void DrawHonesty(const FrameContext& context) const {
    DimText("Is the belief honest?");
    Tooltip(context,
            "Over the frames of this run so far in which a confirmed object was weighed and a true "
            "one of its category is within 50 cm. The regions are those of a Gaussian with the "
            "belief's covariance. Frames of one object resemble one another: these are few "
            "independent trials.");
    if (all_.poses == 0) {
      ImGui::PushStyleColor(ImGuiCol_Text, colors::kFaint);
      ImGui::TextWrapped("%s", context.sequence->truth.empty()
                                   ? "Needs ground truth beside the sequence."
                                   : "No confirmed object is near a true one yet.");
      ImGui::PopStyleColor();
      return;
    }
    DrawJudgement();
    if (!ImGui::BeginTable("posterior.table", 3, ImGuiTableFlags_SizingStretchProp)) return;
    Row("truth in the", fmt::format("#{}", object_.value), "all", colors::kDimText);
    Row("50 % region", Percent(this_.within_50, this_.poses), Percent(all_.within_50, all_.poses),
        colors::kText);
    Row("95 % region", Percent(this_.within_95, this_.poses), Percent(all_.within_95, all_.poses),
        colors::kText);
    Row("shape right", Percent(this_.right(), this_.labels()), Percent(all_.right(), all_.labels()),
        colors::kText);
    Row("believed", this_.labels() > 0 ? fmt::format("{:.0f} %", 100 * this_.claimed()) : "\u2013",
        fmt::format("{:.0f} %", 100 * all_.claimed()), colors::kText);
    Row("frames", fmt::format("{}", this_.poses), fmt::format("{}", all_.poses), colors::kFaint);
    ImGui::EndTable();
  }

  void DrawJudgement() const {
    const double most = static_cast<double>(all_.within_95) / all_.poses;
    const double half = static_cast<double>(all_.within_50) / all_.poses;
    const bool too_sure = most<0.8, unsure = half> 0.8;
    ImGui::PushStyleColor(ImGuiCol_Text, too_sure ? colors::kWarning
                                         : unsure ? colors::kAccent
                                                  : colors::kGood);
    ImGui::TextUnformatted(too_sure ? "Too sure: errors exceed it."
                           : unsure ? "Cautious: errors are smaller."
                                    : "About as sure as it may be.");
    ImGui::PopStyleColor();
  }

  static void Row(const char* name, const std::string& object, const std::string& all,
                  ImU32 color) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    DimText("%s", name);
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(object.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(all.c_str());
    ImGui::PopStyleColor();
  }

  std::uint64_t version_ = 0;
  ObjectId object_;
  const RunHistory* history_ = nullptr;  ///< Compared only.
  Marginals marginals_{};
  LabelHistory labels_;
  bool shapes_ = false;
  Calibration all_, this_;
};

}  // namespace

std::unique_ptr<Panel> MakePosteriorPanel() { return std::make_unique<PosteriorPanel>(); }

}  // namespace plumbline
