// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/proposal_buttons.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

class AnnotateFloorPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    ImGui::BeginChild("floor", {0, 0});
    if (context.annotation->floor) {
      DrawProposal(context, *context.annotation->floor, sink);
    } else {
      DrawWays(context, sink);
    }
    ImGui::EndChild();
  }

 private:
  void DrawWays(const FrameContext& context, CommandSink& sink) {
    const AnnotationSnapshot& snapshot = *context.annotation;
    WrappedText(colors::kDimText,
                snapshot.floor_known
                    ? "The floor is known. Find it again:"
                    : "Objects stand upright, so the floor comes first: where is it?");
    ImGui::Dummy({0, context.Scaled(4)});
    const ImVec2 wide(ImGui::GetContentRegionAvail().x, 0);
    const bool picks = context.annotate->tool == AnnotateTool::kFloor;
    ImGui::BeginDisabled(!snapshot.ready_to_align);
    ImGui::PushStyleColor(ImGuiCol_Button, picks ? colors::kAccent : colors::kAccentDim);
    if (ImGui::Button(picks ? "Now click the floor" : "Click on the floor", wide)) {
      context.annotate->tool = picks ? AnnotateTool::kSelect : AnnotateTool::kFloor;
    }
    ImGui::PopStyleColor();
    LogItem(context, "floor.pick");
    Tooltip(context, "The plane around the point is grown to the whole floor.");
    if (ImGui::Button("Find it", wide)) sink.Post(FindFloorCommand{});
    LogItem(context, "floor.find");
    Tooltip(context,
            "Takes the widest plane that has the scene on one side. Look at the result: it "
            "may be a wall.");
    ImGui::EndDisabled();
    ImGui::Dummy({0, context.Scaled(6)});
    WrappedText(colors::kDimText, "Or type which way is up in the scan's file:");
    ImGui::SetNextItemWidth(wide.x);
    ImGui::InputScalarN("##floor.up", ImGuiDataType_Double, typed_.data(), 3, nullptr, nullptr,
                        "%.4f");
    LogItem(context, "floor.up");
    Tooltip(context, "x, y, z of a vector that points up, of any length.");
    ImGui::Checkbox("floor at", &floor_typed_);
    LogItem(context, "floor.typed");
    ImGui::SameLine();
    ImGui::BeginDisabled(!floor_typed_);
    ImGui::SetNextItemWidth(context.Scaled(80));
    ImGui::InputDouble("##floor.height", &height_m_, 0, 0, "%.3f");
    ImGui::EndDisabled();
    LogItem(context, "floor.height");
    Tooltip(context, "Height of the floor along that direction, from the origin of the file.");
    ImGui::SameLine(0, context.Scaled(6));
    DimText("m");
    if (Button(context, "floor.type", "Take this", "Proposes it; nothing changes yet.")) {
      TypeGravityCommand command{typed_, std::nullopt};
      if (floor_typed_) command.floor_offset_m = -height_m_;
      sink.Post(command);
    }
  }

  static void DrawProposal(const FrameContext& context, const FloorProposal& floor,
                           CommandSink& sink) {
    const auto row = [](const char* name, const std::string& value) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      DimText("%s", name);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(value.c_str());
    };
    WrappedText(colors::kDimText,
                "Green points belong to the floor, red ones are close to it but not on it. Is "
                "this the floor?");
    ImGui::Dummy({0, context.Scaled(2)});
    if (ImGui::BeginTable("floor.table", 2, ImGuiTableFlags_SizingFixedFit)) {
      const Eigen::Vector3d& up = floor.up_in_scan;
      row("How", floor.source);
      row("Up in the file", fmt::format("{:.4f}  {:.4f}  {:.4f}", up.x(), up.y(), up.z()));
      row("Turns the scan by", fmt::format("{:.2f}\u00b0", floor.turn_rad * kDegreesPerRadian));
      if (floor.offset_m) {
        row("Floor", fmt::format("at {:.3f} m along up", -*floor.offset_m));
        row("Points on it", fmt::format("{}", floor.num_inliers));
      }
      if (floor.rmse_m > 0) {
        row("Off the plane", fmt::format("{:.1f} mm rms", 1000 * floor.rmse_m));
        row("Up is known to",
            fmt::format("{:.3f}\u00b0", floor.normal_std_rad * kDegreesPerRadian));
      }
      ImGui::EndTable();
    }
    ImGui::Dummy({0, context.Scaled(6)});
    const ProposalAnswer answer = DrawProposalButtons(context, "Accept", "Enter accepts it too.",
                                                      true, "Esc discards it too.");
    if (answer == ProposalAnswer::kAccept) {
      sink.Post(AcceptProposalCommand{});
      context.annotate->tool = AnnotateTool::kSelect;
      context.annotate->reset = true;
    }
    if (answer == ProposalAnswer::kDiscard) sink.Post(CancelProposalCommand{});
  }

  Eigen::Vector3d typed_{0, 0, 1};
  bool floor_typed_ = false;
  double height_m_ = 0;
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateFloorPanel() { return std::make_unique<AnnotateFloorPanel>(); }

}  // namespace plumbline
