// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/residual_color.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kShownTilt_rad = 1e-4;  ///< Less is rounding: what is locked keeps its tilt.

class AnnotateRefinementPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (!context.annotation->refinement) {
      return EmptyState(context, "Nothing is being refined",
                        "Select an object, then Refine or By images.");
    }
    const RefinementView& refinement = *context.annotation->refinement;
    ImGui::BeginChild("refinement", {0, 0});
    ImGui::TextUnformatted(refinement.instance.c_str());
    ImGui::SameLine();
    DimText("%s", !refinement.problem.empty()                  ? ""
                  : refinement.running && refinement.by_images ? "trying places in all images ..."
                  : refinement.running
                      ? fmt::format("iteration {} ...", refinement.iteration).c_str()
                  : refinement.converged
                      ? fmt::format("converged after {} iterations", refinement.iteration).c_str()
                      : fmt::format("stopped after {} iterations", refinement.iteration).c_str());
    if (!refinement.problem.empty()) {
      WrappedText(colors::kWarning, refinement.problem);
    }
    ImGui::Dummy({0, context.Scaled(2)});
    if (ImGui::BeginTable("refinement.table", 3, ImGuiTableFlags_SizingFixedFit)) {
      TableRow(
          "Azimuth", fmt::format("{:+.2f}\u00b0", refinement.azimuth_rad * kDegreesPerRadian),
          refinement.azimuth_std_rad > 0
              ? fmt::format("\u00b1 {:.2f}\u00b0", refinement.azimuth_std_rad * kDegreesPerRadian)
              : "");
      TableRow("Along the floor", fmt::format("{:.1f} mm", 1000 * refinement.horizontal_m),
               refinement.horizontal_std_m > 0
                   ? fmt::format("\u00b1 {:.1f} mm", 1000 * refinement.horizontal_std_m)
                   : "");
      TableRow(
          "Height",
          fmt::format("{:+.1f} mm",
                      1000 * (std::abs(refinement.height_m) < 5e-5 ? 0.0 : refinement.height_m)),
          refinement.height_std_m > 0
              ? fmt::format("\u00b1 {:.1f} mm", 1000 * refinement.height_std_m)
          : refinement.running ? ""
                               : "kept");
      if (refinement.tilt_rad > kShownTilt_rad) {
        TableRow("Tilt", fmt::format("{:.2f}\u00b0", refinement.tilt_rad * kDegreesPerRadian),
                 "unlocked");
      }
      DrawFit(refinement);
      ImGui::EndTable();
    }
    ImGui::Dummy({0, context.Scaled(4)});
    if (!refinement.by_images) DrawLegend(context);
    ImGui::Dummy({0, context.Scaled(6)});
    const ProposalAnswer answer =
        DrawProposalButtons(context, "Accept", "Enter accepts it too, as one edit.", true,
                            "Leaves it where it was (Esc).");
    if (answer == ProposalAnswer::kAccept) sink.Post(AcceptProposalCommand{});
    if (answer == ProposalAnswer::kDiscard) sink.Post(CancelProposalCommand{});
    ImGui::EndChild();
  }

 private:
  static void DrawFit(const RefinementView& refinement) {
    if (refinement.by_images) {
      TableRow("On edges", fmt::format("{:.0f} %", 100 * refinement.agreement),
               fmt::format("was {:.0f} %", 100 * refinement.agreement_before));
      TableRow("Edges are off by", fmt::format("{:.1f} px", refinement.offset_px),
               fmt::format("was {:.1f}", refinement.offset_before_px));
      return;
    }
    TableRow("Fits", fmt::format("{:.0f} %", 100 * refinement.fitness),
             fmt::format("was {:.0f} %", 100 * refinement.fitness_before));
    TableRow("Distance", fmt::format("{:.1f} mm rms", 1000 * refinement.rmse_m),
             fmt::format("was {:.1f}", 1000 * refinement.rmse_before_m));
  }

  static void DrawLegend(const FrameContext& context) {
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const float width = std::min(ImGui::GetContentRegionAvail().x, context.Scaled(230));
    const float height = context.Scaled(10);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    constexpr int kSteps = 32;
    for (int i = 0; i < kSteps; ++i) {
      const float a = static_cast<float>(i) / kSteps, b = static_cast<float>(i + 1) / kSteps;
      draw.AddRectFilled({low.x + a * width, low.y}, {low.x + b * width, low.y + height},
                         ResidualColor(a * kWorstResidual_m));
    }
    ImGui::Dummy({width, height});
    SmallText(context, colors::kDimText, "0");
    ImGui::SameLine(0.5f * width - context.Scaled(8));
    SmallText(context, colors::kDimText, "%.0f", 500 * kWorstResidual_m);
    ImGui::SameLine(width - context.Scaled(36));
    SmallText(context, colors::kDimText, "%.0f mm", 1000 * kWorstResidual_m);
    const ImVec2 grey = ImGui::GetCursorScreenPos();
    draw.AddRectFilled({grey.x, grey.y + context.Scaled(3)},
                       {grey.x + height, grey.y + context.Scaled(3) + height}, ResidualColor(-1));
    ImGui::SetCursorScreenPos({grey.x + height + context.Scaled(6), grey.y});
    SmallText(context, colors::kDimText, "no scan within 10 cm");
  }
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateRefinementPanel() {
  return std::make_unique<AnnotateRefinementPanel>();
}

}  // namespace plumbline
