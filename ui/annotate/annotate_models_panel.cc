// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr float kCellWidth = 112, kPictureHeight = 84;

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string Shortened(ImFont& font, const std::string& text, float width) {
  std::string shown = text;
  while (shown.size() > 1 &&
         font.CalcTextSizeA(font.FontSize, 1e6f, 0, (shown + "..").c_str()).x > width) {
    shown.pop_back();
  }
  return shown.size() == text.size() ||
                 font.CalcTextSizeA(font.FontSize, 1e6f, 0, text.c_str()).x <= width
             ? text
             : shown + "..";
}

class AnnotateModelsPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    if (context.annotation == nullptr || context.annotation->models->empty()) return;
    const float width = context.Scaled(110);
    AlignRight(width);
    ImGui::PushFont(context.fonts.small);
    ImGui::SetNextItemWidth(width);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {context.Scaled(7), context.Scaled(2)});
    ImGui::InputTextWithHint("##annotate_models.filter", "Filter", filter_, sizeof(filter_));
    LogItem(context, "annotate_models.filter");
    ImGui::PopStyleVar();
    Tooltip(context, "Shows only models whose name or category contains this text.");
    ImGui::PopFont();
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (snapshot.models->empty()) {
      return EmptyState(context, snapshot.models_problem.empty() ? "Reading" : "No models",
                        snapshot.models_problem.empty() ? "The models are loading."
                                                        : snapshot.models_problem.c_str());
    }
    ImGui::BeginChild("models", {0, 0});
    const std::string wanted = Lower(filter_);
    const float room = ImGui::GetContentRegionAvail().x;
    const int columns = std::max(1, static_cast<int>(room / context.Scaled(kCellWidth)));
    const float gap = context.Scaled(6);
    const float width =
        (room - gap * static_cast<float>(columns - 1)) / static_cast<float>(columns);
    int shown = 0;
    for (std::size_t i = 0; i < snapshot.models->size(); ++i) {
      const AnnotationModel& model = (*snapshot.models)[i];
      if (Lower(model.name + " " + model.category).find(wanted) == std::string::npos) continue;
      if (shown++ % columns != 0) ImGui::SameLine(0, gap);
      DrawModel(context, model, width, sink);
    }
    if (shown == 0) EmptyState(context, "Nothing fits", "No model name contains this text.");
    ImGui::EndChild();
  }

 private:
  static void DrawModel(const FrameContext& context, const AnnotationModel& model, float width,
                        CommandSink& sink) {
    AnnotateView& view = *context.annotate;
    const std::string name = "annotate_models." + model.name;
    ImFont& font = *context.fonts.small;
    const float picture = std::min(context.Scaled(kPictureHeight), 0.75f * width);
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const ImVec2 size(width, picture + font.FontSize + context.Scaled(8));
    if (ImGui::InvisibleButton(name.c_str(), size)) {
      const bool was = view.tool == AnnotateTool::kPlace && view.model == model.name;
      ChooseModel(context, model.name, sink);
      if (was) view.tool = AnnotateTool::kSelect;
    }
    LogItem(context, name);
    const Eigen::Vector3f extent = model.bounds.sizes();
    Tooltip(context, fmt::format("{} ({})\n{:.2f} \u00d7 {:.2f} \u00d7 {:.2f} m\n{}", model.name,
                                 model.category, extent.x(), extent.y(), extent.z(),
                                 model.on_floor ? "Stands on the floor." : "Stands on anything."));
    const bool chosen = view.tool == AnnotateTool::kPlace && view.model == model.name;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 high(low.x + size.x, low.y + size.y);
    draw.AddRectFilled(low, high, chosen ? colors::kAccentDim : colors::kInset, context.Scaled(5));
    if (context.textures != nullptr && !model.thumbnail.empty()) {
      const ImTextureID texture =
          context.textures->Get("model." + model.name, context.annotation->models_version,
                                [&] { return model.thumbnail; });
      const float aspect =
          static_cast<float>(model.thumbnail.cols) / static_cast<float>(model.thumbnail.rows);
      const float shown =
          std::min(width - context.Scaled(4), aspect * (picture - context.Scaled(4)));
      const ImVec2 a(low.x + 0.5f * (width - shown), low.y + context.Scaled(3));
      draw.AddImageRounded(texture, a, {a.x + shown, a.y + shown / aspect}, {0, 0}, {1, 1},
                           IM_COL32_WHITE, context.Scaled(4));
    }
    if (chosen || ImGui::IsItemHovered()) {
      draw.AddRect(low, high, chosen ? colors::kAccent : colors::kFaint, context.Scaled(5), 0,
                   context.Scaled(chosen ? 2 : 1));
    }
    const std::string label = Shortened(font, model.name, width - context.Scaled(8));
    const float text = font.CalcTextSizeA(font.FontSize, 1e6f, 0, label.c_str()).x;
    draw.AddText(&font, font.FontSize,
                 {low.x + 0.5f * (width - text), low.y + picture + context.Scaled(3)},
                 colors::kText, label.c_str());
  }

  char filter_[64] = "";
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateModelsPanel() { return std::make_unique<AnnotateModelsPanel>(); }

}  // namespace plumbline
