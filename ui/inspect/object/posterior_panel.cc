// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/posterior_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angle_text.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/object_history.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/object/label_plot.h"
#include "ui/inspect/object/posterior_marginals.h"
#include "ui/inspect/object/reliability_view.h"

namespace plumbline {
namespace {

void Words(const FrameContext& context, ImVec2 at, float align, ImU32 color,
           const std::string& words) {
  ImFont* font = context.fonts.small;
  const float width = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width, at.y}, color,
                                      words.c_str());
}

class PosteriorPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Shapes over time") + ToggleWidth(context, "Reliability") +
               context.Scaled(4));
    if (Toggle(
            context, "posterior.shapes", "Shapes over time", shapes_,
            "What the object was believed to be, frame by frame, instead of its parameters now."))
      reliability_ = false;
    ImGui::SameLine();
    if (Toggle(context, "posterior.reliability", "Reliability", reliability_,
               "How often the truth lies where the beliefs of this run say, for every object."))
      shapes_ = false;
  }

  nlohmann::json SaveState() const override {
    return {{"shapes", shapes_}, {"reliability", reliability_}};
  }
  void LoadState(const nlohmann::json& json) override {
    shapes_ = KeptValue(json, "shapes", shapes_);
    reliability_ = KeptValue(json, "reliability", reliability_);
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr || object->particles == nullptr || object->particles->empty())
      return EmptyState(context, "No hypotheses",
                        "Select an object in the list, in an image or in the map.");
    ImGui::PushFont(context.fonts.small);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const bool beside =
        !reliability_ && room.x > context.Scaled(520) && room.y > context.Scaled(60);
    const float side = beside ? context.Scaled(250) : 0;
    sink.Post(NeedCommand{NeedCommand::What::kObjectHistory});
    Remember(context, *object);
    if (reliability_)
      DrawReliability(context, *history_, corner, room);
    else if (shapes_)
      DrawLabelPlot(context, history_->labels, corner, {room.x - side, room.y}, sink);
    else
      DrawMarginals(context, corner, {room.x - side, room.y});
    if (beside) {
      ImGui::SetCursorScreenPos({corner.x + room.x - side + context.Scaled(14), corner.y});
      ImGui::BeginChild("posterior.summary", {side - context.Scaled(14), room.y});
      DrawReliabilitySummary(context, *history_);
      ImGui::EndChild();
    }
    ImGui::PopFont();
  }

 private:
  void Remember(const FrameContext& context, const ObjectReport& object) {
    if (context.history != nullptr && context.history->object == object.id)
      history_ = context.history;
    else if (history_->object != object.id)
      history_ = std::make_shared<const ObjectHistory>();  // the one asked for is on its way
    if (version_ == context.snapshot_version && object_ == object.id) return;
    version_ = context.snapshot_version;
    object_ = object.id;
    label_ = object.label;
    marginals_ = MarginalsOf(context, object);
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
    const ImU32 color = OnPanel(context.ColorOf(object_));
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
    const auto number = [&](double v) {
      if (axis == kDepthAxis) return fmt::format("{:.2f} m", std::exp(v));
      if (axis == kAzimuthAxis) return AngleText(kRadPerDeg * v, 1);
      return NumberText(v, 1) + kParameterAxes[axis].unit;
    };
    const ModelView* model = context.Model(label_);
    const bool any = axis == kAzimuthAxis && model != nullptr && model->any_azimuth;
    if (!any) line(marginals_.mean[axis], colors::kText);
    if (marginals_.truth && !any) line(marginals_.truth->value[axis], OnPanel(colors::kTruth));
    const std::string spread =
        axis == kDepthAxis
            ? fmt::format("{:.1f} %", 100 * marginals_.std[axis])
            : fmt::format("{:.1f}{}", marginals_.std[axis], kParameterAxes[axis].unit);
    Words(context, corner, 0, colors::kDimText, kParameterAxes[axis].name);
    Words(context, {high.x, corner.y}, 1, colors::kText,
          any ? "any" : fmt::format("{} \u00b1 {}", number(marginals_.mean[axis]), spread));
    Words(context, {low.x, high.y}, 0, colors::kFaint, number(marginals_.low[axis]));
    Words(context, {high.x, high.y}, 1, colors::kFaint, number(marginals_.high[axis]));
    if (marginals_.truth && !any)
      Words(context, {0.5f * (low.x + high.x), high.y}, 0.5f, OnPanel(colors::kTruth),
            "truth " + number(marginals_.truth->value[axis]));
    ImGui::SetCursorScreenPos(corner);
    ImGui::InvisibleButton(kParameterAxes[axis].name, size);
    LogItem(context, fmt::format("posterior.axis.{}", axis));
    Tooltip(context, std::string(kParameterAxes[axis].help) +
                         " Bars: the particles by weight. White: their mean. Green: the truth.");
  }

  std::uint64_t version_ = 0;
  ObjectId object_;
  ModelId label_;
  /// Of that object; never null.
  std::shared_ptr<const ObjectHistory> history_ = std::make_shared<const ObjectHistory>();
  Marginals marginals_{};
  bool shapes_ = false, reliability_ = false;  ///< If both, the latter shows.
};

}  // namespace

std::unique_ptr<Panel> MakePosteriorPanel() { return std::make_unique<PosteriorPanel>(); }

}  // namespace plumbline
