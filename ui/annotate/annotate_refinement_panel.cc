// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angle_text.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/residual_color.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kShownTilt_rad = 1e-4;  ///< Less is rounding: what is locked keeps its tilt.

const char* NameOf(RefineBy by) {
  switch (by) {
    case RefineBy::kScan:
      return "By scan";
    case RefineBy::kImages:
      return "By images";
    case RefineBy::kBoth:
      break;
  }
  return "Together";
}

const char* KeyOf(RefineBy by) {
  return by == RefineBy::kScan     ? "refined.scan"
         : by == RefineBy::kImages ? "refined.images"
                                   : "refined.both";
}

double Distance(const RefinedPose& pose) { return std::hypot(pose.horizontal_m, pose.height_m); }

std::string Millimetres(double meters) {
  return fmt::format("{:.1f} mm", 1000 * (std::abs(meters) < 5e-5 ? 0.0 : meters));
}

std::string Degrees(double angle_rad, int decimals) {
  const std::string text = AngleText(angle_rad, decimals);
  const bool turns = text.find_first_of("123456789") != std::string::npos;
  return (turns && angle_rad > 0 ? "+" : "") + text;
}

class AnnotateRefinementPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (!context.annotation->refinement) {
      return EmptyState(context, "Nothing is being refined", "Select an object, then Refine.");
    }
    const RefinementView& refinement = *context.annotation->refinement;
    ImGui::BeginChild("refinement", {0, 0});
    ImGui::TextUnformatted(refinement.instance.c_str());
    ImGui::SameLine();
    DimText("%s", StateOf(refinement).c_str());
    if (!refinement.problem.empty()) WrappedText(colors::kWarning, refinement.problem + ".");
    if (!refinement.one_problem.empty()) {
      WrappedText(colors::kWarning, std::string(refinement.has_scan && refinement.has_images &&
                                                        refinement.by == RefineBy::kScan
                                                    ? "Not by the images: "
                                                    : "Not by the scan: ") +
                                        refinement.one_problem + ".");
    }
    if (!refinement.scale_problem.empty()) {
      WrappedText(colors::kWarning, "Scale kept: " + refinement.scale_problem + ".");
    }
    ImGui::Dummy({0, context.Scaled(2)});
    if (refinement.found.size() > 1) DrawChoices(context, refinement, sink);
    if (ImGui::BeginTable("refinement.table", 3, ImGuiTableFlags_SizingFixedFit)) {
      DrawChange(refinement, refinement.running);
      if (refinement.tilt_rad > kShownTilt_rad) {
        TableRow("Tilt", fmt::format("{:.2f}\u00b0", refinement.tilt_rad * kDegreesPerRadian),
                 "unlocked");
      }
      if (refinement.scale_std > 0) {
        TableRow("Scale", fmt::format("{:.4f}", refinement.scale),
                 fmt::format("\u00b1 {:.4f}", refinement.scale_std));
      }
      DrawFit(refinement);
      ImGui::EndTable();
    }
    ImGui::Dummy({0, context.Scaled(4)});
    if (refinement.has_scan) DrawLegend(context);
    ImGui::Dummy({0, context.Scaled(6)});
    const ProposalAnswer answer =
        DrawProposalButtons(context, "Accept", "Enter accepts it too, as one edit.", true,
                            "Leaves it where it was (Esc).");
    if (answer == ProposalAnswer::kAccept) sink.Post(AcceptProposalCommand{});
    if (answer == ProposalAnswer::kDiscard) sink.Post(CancelProposalCommand{});
    ImGui::EndChild();
  }

 private:
  static std::string StateOf(const RefinementView& refinement) {
    if (!refinement.problem.empty()) return "";
    if (!refinement.running) return refinement.converged ? "converged" : "stopped while it moved";
    if (!refinement.has_scan) return "trying places in all images ...";
    return fmt::format("iteration {} on the scan ...", refinement.iteration);
  }

  /// What was found, one line each; a click proposes it.
  static void DrawChoices(const FrameContext& context, const RefinementView& refinement,
                          CommandSink& sink) {
    for (const RefinedPose& found : refinement.found) {
      const bool chosen = found.by == refinement.by;
      if (ImGui::RadioButton(NameOf(found.by), chosen) && !chosen) {
        sink.Post(ChooseRefinementCommand{found.by});
      }
      LogItem(context, KeyOf(found.by));
      Tooltip(context,
              found.by == RefineBy::kBoth
                  ? "Both results, weighted by their covariances; in the images a shared error of "
                    "the cameras of 1 cm and 0.3\u00b0 is counted in."
              : found.by == RefineBy::kScan ? "The scan alone."
                                            : "The edges in its key frames alone.");
      ImGui::SameLine(context.Scaled(122));
      ImGui::AlignTextToFramePadding();
      SmallText(context, chosen ? colors::kText : colors::kDimText, "%.0f mm, %s   other images %s",
                1000 * Distance(found), Degrees(found.azimuth_rad, 1).c_str(),
                found.agreement_held_out
                    ? fmt::format("{:.0f} %", 100 * *found.agreement_held_out).c_str()
                    : "-");
    }
    const RefinedPose& apart = refinement.apart;
    const std::string how = fmt::format(
        "Scan and images are {:.0f} mm and {:.1f}\u00b0 apart, where {:.0f} mm and "
        "{:.1f}\u00b0 are expected",
        1000 * Distance(apart), std::abs(apart.azimuth_rad) * kDegreesPerRadian,
        1000 * std::hypot(apart.horizontal_std_m, apart.height_std_m),
        apart.azimuth_std_rad * kDegreesPerRadian);
    if (refinement.contradict) {
      WrappedText(colors::kWarning,
                  how + ": they contradict each other. Look at all outlines in the images.");
    } else {
      WrappedText(colors::kDimText, how + ".");
    }
    ImGui::Dummy({0, context.Scaled(3)});
  }

  static void DrawChange(const RefinedPose& pose, bool running) {
    TableRow("Azimuth", Degrees(pose.azimuth_rad, 2),
             pose.azimuth_std_rad > 0
                 ? fmt::format("\u00b1 {:.2f}\u00b0", pose.azimuth_std_rad * kDegreesPerRadian)
                 : "");
    TableRow("Along the floor", Millimetres(pose.horizontal_m),
             pose.horizontal_std_m > 0 ? "\u00b1 " + Millimetres(pose.horizontal_std_m) : "");
    TableRow("Height", (pose.height_m >= 5e-5 ? "+" : "") + Millimetres(pose.height_m),
             pose.height_std_m > 0 ? "\u00b1 " + Millimetres(pose.height_std_m)
             : running             ? ""
                                   : "kept");
  }

  static void DrawFit(const RefinementView& refinement) {
    const RefinedPose& before = refinement.before;
    const bool done = !refinement.running && refinement.problem.empty();
    const auto was = [&](const std::string& text) { return done ? "was " + text : std::string(); };
    const auto percent = [](double share) { return fmt::format("{:.0f} %", 100 * share); };
    if (refinement.has_scan) {
      TableRow("Fits the scan", percent(refinement.fitness), was(percent(before.fitness)));
      TableRow("Distance", fmt::format("{:.1f} mm rms", 1000 * refinement.rmse_m),
               was(fmt::format("{:.1f}", 1000 * before.rmse_m)));
    }
    if (!refinement.has_images || !done) return;
    TableRow("On edges", percent(refinement.agreement), was(percent(before.agreement)));
    if (refinement.agreement_held_out && before.agreement_held_out) {
      TableRow("In other images", percent(*refinement.agreement_held_out),
               was(percent(*before.agreement_held_out)));
    }
    TableRow("Edges are off by", fmt::format("{:.1f} px", refinement.offset_px),
             was(fmt::format("{:.1f}", before.offset_px)));
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
