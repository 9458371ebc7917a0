// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kFloats_m = 0.03;

class AnnotateCandidatesPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (!context.annotation->placement) {
      return EmptyState(context, "Nothing is being placed",
                        "Choose a model, then click in the scan where it stands.");
    }
    const PlacementView& placement = *context.annotation->placement;
    if (placement.running) {
      return EmptyState(context, "Trying 24 azimuths", "Each is aligned to the scan. Esc stops.");
    }
    if (!placement.problem.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, colors::kWarning);
      ImGui::TextWrapped("%s. It can be placed as it is and aligned by hand.",
                         placement.problem.c_str());
      ImGui::PopStyleColor();
    } else {
      const char* symmetric =
          placement.symmetry_order == 0  ? "  The model is round: its azimuth means nothing."
          : placement.symmetry_order > 1 ? "  The model looks the same from several sides."
                                         : "";
      SmallText(context, colors::kDimText, "%zu found in %.2f s.%s", placement.candidates.size(),
                placement.seconds, symmetric);
      const char* images = placement.searching
                               ? "No candidate agrees with the images; searching the images ..."
                           : placement.by_images ? "The images decided which is first."
                                                 : nullptr;
      if (images != nullptr) SmallText(context, colors::kWarning, "%s", images);
    }
    const float buttons = ImGui::GetFrameHeight() + context.Scaled(14);
    ImGui::BeginChild("candidates", {0, ImGui::GetContentRegionAvail().y - buttons});
    for (int i = 0; i < static_cast<int>(placement.candidates.size()); ++i) {
      DrawCandidate(context, i, sink);
    }
    ImGui::EndChild();
    ImGui::Dummy({0, context.Scaled(2)});
    const ProposalAnswer answer = DrawProposalButtons(
        context, "Place it", "Enter accepts the chosen one too.", true, "Esc discards it too.");
    if (answer == ProposalAnswer::kAccept)
      AcceptProposal(context, context.annotate->candidate, sink);
    if (answer == ProposalAnswer::kDiscard) sink.Post(CancelProposalCommand{});
  }

 private:
  static void DrawCandidate(const FrameContext& context, int index, CommandSink& sink) {
    const PlacementCandidate& candidate =
        context.annotation->placement->candidates[static_cast<std::size_t>(index)];
    int& chosen = context.annotate->candidate;
    const std::string name = fmt::format("candidate.{}", index);
    const float width = ImGui::GetContentRegionAvail().x;
    const float picture_width = std::min(0.55f * width, context.Scaled(150));
    const float height = 0.75f * picture_width;
    const ImVec2 low = ImGui::GetCursorScreenPos();
    if (ImGui::InvisibleButton(name.c_str(), {width, height})) chosen = index;
    if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      AcceptProposal(context, index, sink);
    }
    LogItem(context, name);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 high(low.x + width, low.y + height);
    const bool is_chosen = chosen == index;
    draw.AddRectFilled(low, high, is_chosen ? colors::kAccentDim : colors::kInset,
                       context.Scaled(5));
    if (context.textures != nullptr && !candidate.picture.empty()) {
      const ImTextureID texture = context.textures->Get(name, context.annotation->proposal_number,
                                                        [&] { return candidate.picture; });
      draw.AddImageRounded(texture, low, {low.x + picture_width, high.y}, {0, 0}, {1, 1},
                           IM_COL32_WHITE, context.Scaled(5));
    }
    if (is_chosen || ImGui::IsItemHovered()) {
      draw.AddRect(low, high, is_chosen ? colors::kAccent : colors::kFaint, context.Scaled(5), 0,
                   context.Scaled(is_chosen ? 2 : 1));
    }
    float y = low.y + context.Scaled(8);
    const float x = low.x + picture_width + context.Scaled(10);
    ImFont& font = *context.fonts.small;
    const auto line = [&](ImU32 color, const std::string& text) {
      draw.PushClipRect(low, high, true);
      draw.AddText(&font, font.FontSize, {x, y}, color, text.c_str());
      draw.PopClipRect();
      y += font.FontSize + context.Scaled(4);
    };
    line(colors::kText,
         fmt::format("azimuth {:.1f}\u00b0", candidate.azimuth_rad * kDegreesPerRadian));
    const ImU32 dim = is_chosen ? colors::kText : colors::kDimText;
    line(dim, candidate.from_images ? "by the images"
                                    : fmt::format("fits {:.0f} %", 100 * candidate.fitness));
    if (candidate.agreement) {
      line(dim, fmt::format("images {:.0f} %", 100 * *candidate.agreement));
    }
    if (!candidate.from_images) line(dim, fmt::format("{:.1f} mm rms", 1000 * candidate.rmse_m));
    if (candidate.position_std_m > 0) {
      line(dim, fmt::format("\u00b1 {:.1f} mm, {:.2f}\u00b0", 1000 * candidate.position_std_m,
                            candidate.azimuth_std_rad * kDegreesPerRadian));
    }
    const AnnotationModel* model = context.annotation->Model(context.annotation->placement->model);
    const double above = ReadPose(*context.annotation, candidate.scan_from_object).z;
    if (context.annotation->floor_known && model != nullptr && model->on_floor &&
        std::abs(above) > kFloats_m) {
      line(colors::kWarning, fmt::format("{:.0f} cm {} the floor", 100 * std::abs(above),
                                         above > 0 ? "above" : "below"));
    }
    if (candidate.same_by_symmetry) line(colors::kWarning, "same shape");
    Tooltip(context,
            "Fit: share of the model's surface with scan points within 2 cm; the back is "
            "often not scanned. Then the distance of the scan points from the model, and "
            "how well place and azimuth are known.");
  }
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateCandidatesPanel() {
  return std::make_unique<AnnotateCandidatesPanel>();
}

}  // namespace plumbline
